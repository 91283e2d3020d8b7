#include "preprocess/input_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/regular_file.h"

namespace rhoray::preprocess {

namespace {

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());  // a folder lists its files in no particular order
  return names;
}

}  // namespace

void require_input(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error_code;
  const std::filesystem::file_status status = std::filesystem::status(path, error_code);
  if (!std::filesystem::exists(status)) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder, error_code))
      throw Error(ErrorCode::unreadable, concat(name, ": no such file; there is no folder ", folder.string()));
    throw Error(ErrorCode::unreadable, concat(name, ": no such file"),
                did_you_mean(path.filename().string(), names_in(folder)));
  }
  if (!std::filesystem::is_directory(status)) require_regular_file(path);
  if (std::filesystem::is_directory(status) && foreign_kind(path) == ForeignKind::unknown)
    throw Error(ErrorCode::unreadable,
                concat(name, ": is a folder; expected a file, or a folder of DICOM images or pictures"));
  if (::access(path.c_str(), R_OK) != 0)
    throw Error(ErrorCode::unreadable, concat(name, ": cannot be read (", std::strerror(errno), ")"));
}

std::string unsupported_type(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension.empty()) return concat(path.string(), ": unknown file type");
  return concat(path.string(), ": unsupported file type \"", extension, "\"");
}

std::uintmax_t input_bytes(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return std::filesystem::file_size(path);
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

}  // namespace rhoray::preprocess

#include "preprocess/input_file.h"

#include "formats/base/error.h"
#include "formats/base/regular_file.h"

namespace rhoray::preprocess {

void require_input(const std::filesystem::path& path) {
  require_readable(path);
  if (std::filesystem::is_directory(path) && foreign_kind(path) == ForeignKind::unknown)
    throw Error(ErrorCode::unreadable,
                concat(path.string(), ": is a folder; expected a file, or a folder of DICOM images or pictures"));
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

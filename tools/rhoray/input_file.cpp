#include "tools/rhoray/input_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "formats/base/nearest_name.h"
#include "formats/base/trouble.h"

namespace rhoray::tools {

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
  std::error_code trouble;
  const std::filesystem::file_status status = std::filesystem::status(path, trouble);
  if (!std::filesystem::exists(status)) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder, trouble))
      throw Error(Trouble::unreadable, concat(name, ": no such file, and no folder ", folder.string()));
    throw Error(Trouble::unreadable, concat(name, ": no such file"),
                did_you_mean(path.filename().string(), names_in(folder)));
  }
  if (std::filesystem::is_directory(status))
    throw Error(Trouble::unreadable, concat(name, ": is a folder; expected a file"));
  if (::access(path.c_str(), R_OK) != 0)
    throw Error(Trouble::unreadable, concat(name, ": cannot be read (", std::strerror(errno), ")"));
}

}  // namespace rhoray::tools

#include "formats/base/component_file.h"

#include <algorithm>
#include <iterator>
#include <system_error>
#include <vector>

#include "formats/base/text.h"

namespace rhoray {

namespace {

namespace fs = std::filesystem;

struct Row {
  std::string_view name, package;
};
constexpr Row packages[] = {{"rhoray-import-worker", "rhoray-import"}, {"rhoray-slices-worker", "rhoray-import"},
                            {"rhoray-vdb-worker", "rhoray-import"},    {"rhoray-tetgen-worker", "rhoray-mesh"},
                            {"rhoray-repair-worker", "rhoray-mesh"},   {"rhoray-validate-worker", "rhoray-mesh"},
                            {"rhoray-pictures.so", "rhoray-pictures"}};

/// RHORAY_COMPONENT_FOLDER is relative to that of the programs.
std::vector<fs::path> usual_folders() {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  return {programs, (programs / RHORAY_COMPONENT_FOLDER).lexically_normal()};
}

}  // namespace

ComponentFile::ComponentFile(std::string_view name, const fs::path& folder) : name_(name) {
  const std::vector<fs::path> folders = folder.empty() ? usual_folders() : std::vector{folder};
  for (const fs::path& each : folders) {
    folders_ += concat(folders_.empty() ? "" : " or ", each.string());
    std::error_code ignored;
    if (exists_ || !fs::exists(each / name, ignored)) continue;
    path_ = each / name;
    exists_ = true;
  }
  if (!exists_) path_ = folders.front() / name;
}

std::string ComponentFile::missing_text() const {
  return concat(name_.ends_with(".so") ? "the module " : "the program ", name_, ", which is not in ", folders_);
}

std::string ComponentFile::hint() const {
  const auto* const row =
      std::find_if(std::begin(packages), std::end(packages), [this](const Row& each) { return each.name == name_; });
  const std::string package = row == std::end(packages) ? "" : concat("the package ", row->package, " has it; ");
  return package + "in a source tree, tools/setup/build builds it";
}

}  // namespace rhoray

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

/// RHORAY_COMPONENT_FOLDER is relative to the folder of the program.
std::vector<fs::path> usual_folders() {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  return {program, (program / RHORAY_COMPONENT_FOLDER).lexically_normal()};
}

}  // namespace

ComponentFile::ComponentFile(std::string_view name, const fs::path& folder) : name_(name) {
  for (const fs::path& searched : folder.empty() ? usual_folders() : std::vector{folder}) {
    searched_ += concat(searched_.empty() ? "" : " or ", searched.string());
    std::error_code ignored;
    if (path_.empty() && fs::exists(searched / name, ignored)) path_ = searched / name;
  }
}

std::string ComponentFile::missing_text() const {
  return concat(name_.ends_with(".so") ? "the module " : "the program ", name_, ", which is not in ", searched_);
}

std::string ComponentFile::hint() const {
  const auto* const row =
      std::find_if(std::begin(packages), std::end(packages), [this](const Row& each) { return each.name == name_; });
  const std::string package = row == std::end(packages) ? "" : concat("the package ", row->package, " contains it; ");
  return package + "in a source tree, tools/setup/build builds it";
}

}  // namespace rhoray

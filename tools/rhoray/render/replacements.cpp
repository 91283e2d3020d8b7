#include "tools/rhoray/render/replacements.h"

#include <string_view>

namespace rhoray::tools {

namespace {

struct Row {
  std::string_view name;
  Option::Replaces replaces;
};

const std::vector<Row>& rows() {
  static const std::vector<std::string> places{"--camera-position", "--camera-target", "--camera-up"};
  static const std::vector<Row> all{
      {"--mode",
       {"mip",
        false,
        {"--iso", "--context", "--surface-color", "--normals", "--color-by", "--colormap", "--texture", "--ambient",
         "--specular", "--shininess", "--feature-edges", "--opacity", "--shadows", "--ao", "--light", "--light-size"}}},
      {"--mode", {"mip", true, {"--range", "--color-scale", "--levels", "--accuracy", "--method"}}},
      {"--mode", {"boundary", false, {"--iso", "--context", "--method"}}},
      {"--mode", {"boundary", true, {"--range", "--color-scale", "--levels", "--accuracy"}}},
      {"--mode", {"iso", true, {"--feature-edges"}}},
      {"--mode", {"iso", true, {"--range", "--colormap", "--color-scale", "--levels", "--accuracy", "--method"}}},
      {"--accuracy", {"", false, {"--method", "--max-error", "--budget-ms"}}},
      {"--method", {"", false, {"--accuracy", "--max-error", "--budget-ms"}}},
      {"--max-error", {"", false, {"--accuracy", "--method"}}},
      {"--budget-ms", {"", false, {"--accuracy", "--method"}}},
      {"--color-by", {"", false, {"--texture"}}},
      {"--color-by", {"", true, {"--range"}}},
      {"--texture", {"", false, {"--color-by", "--colormap", "--color-scale", "--levels", "--range"}}},
      {"--field", {"", true, {"--iso", "--range"}}},
      {"--view", {"", false, {"--azimuth", "--elevation"}}},
      {"--view", {"", false, places}},
      {"--azimuth", {"", false, places}},
      {"--elevation", {"", false, places}},
      {"--camera-position", {"", false, {"--view", "--azimuth", "--elevation"}}},
      {"--fov", {"", false, {"--ortho", "--ortho-height"}}},
      {"--ortho", {"", false, {"--fov"}}},
      {"--ortho-height", {"", false, {"--fov"}}}};
  return all;
}

}  // namespace

std::vector<Option> with_replacements(std::vector<Option> options) {
  for (Option& option : options)
    for (const Row& row : rows())
      if (option.names == row.name) option.replaces.push_back(row.replaces);
  return options;
}

}  // namespace rhoray::tools

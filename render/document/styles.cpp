#include "render/document/styles.h"

#include <algorithm>

#include "formats/base/checks.h"
#include "formats/base/word_list.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

Vec3 color_of(const char* text) {
  Color color;
  read_value(text, color);
  return color.linear;
}

/// A key light 30 degrees to the left of the camera and 40 above it, and a fill light from the
/// other side at a third of its strength. With the ambient light no surface gets more than a white
/// light at the eye gives.
std::vector<LightSpec> key_and_fill() {
  constexpr double key_intensity = 0.9, fill_intensity = 0.3;
  LightSpec key{.type = Light::Kind::directional, .from = "camera", .intensity = key_intensity};
  key.azimuth_deg = -30, key.elevation_deg = 40;
  LightSpec fill{.type = Light::Kind::directional, .from = "camera", .intensity = fill_intensity};
  fill.azimuth_deg = 50, fill.elevation_deg = 0;
  return {key, fill};
}

/// The same with a key light of an angle that makes soft shadows.
std::vector<LightSpec> key_with_shadows_and_fill() {
  std::vector<LightSpec> lights = key_and_fill();
  lights[0].shadows = true;
  lights[0].angular_diameter_deg = 8;
  lights[0].samples = 8;
  return lights;
}

}  // namespace

std::span<const Style> styles() {
  static const std::vector<Style> rows{
      {.name = "default",
       .help = "a key and a fill light, antialiased edges, off-white background; no secondary rays",
       .lights = key_and_fill(),
       .occlusion = {},
       .background = color_of("#f4f4f2"),
       .antialiasing = 8,
       .ambient = 0.12,
       .specular = 0.15,
       .has_smooth_normals = true},
      {.name = "paper",
       .help = "the default on pure white, for print; costs the same",
       .lights = key_and_fill(),
       .occlusion = {},
       .background = {1, 1, 1},
       .antialiasing = 8,
       .ambient = 0.12,
       .specular = 0.15,
       .has_smooth_normals = true},
      {.name = "fast",
       .help = "one light at the camera, one ray per pixel, exact normals, white background; costs about half",
       .lights = {{.type = Light::Kind::head}},
       .occlusion = {},
       .background = {1, 1, 1},
       .antialiasing = 1,
       .ambient = 0.12,
       .specular = 0.25,
       .has_smooth_normals = false},
      {.name = "presentation",
       .help = "soft shadows and ambient occlusion, with more ambient light; costs about ten times as much",
       .lights = key_with_shadows_and_fill(),
       .occlusion = OcclusionSpec{.samples = 8},
       .background = color_of("#f4f4f2"),
       .antialiasing = 8,
       .ambient = 0.3,
       .specular = 0.15,
       .has_smooth_normals = true}};
  return rows;
}

const Style& style_named(const std::string& name) {
  if (name.empty()) return styles().front();
  const auto found =
      std::find_if(styles().begin(), styles().end(), [&](const Style& style) { return name == style.name; });
  RHORAY_CHECK(found != styles().end());
  return *found;
}

std::vector<std::string> style_words() {
  return names_in(styles(), &Style::name);
}

std::string style_help() {
  std::string help;
  for (const Style& style : styles()) help += concat(help.empty() ? "" : ". ", style.name, ": ", style.help);
  return help;
}

std::vector<LightSpec> lights_of_style(const std::string& style) {
  return style_named(style).lights;
}

}  // namespace rhoray::render

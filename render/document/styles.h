#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/scene_spec.h"

namespace rhoray::render {

/// A named set of defaults for a scene. Only this table holds them.
struct Style {
  const char* name;
  const char* help;  ///< what it is for, and what it costs
  std::vector<LightSpec> lights;
  std::optional<OcclusionSpec> occlusion;
  Vec3 background;   ///< linear RGB; behind projections alone it is black
  int antialiasing;  ///< most samples of a pixel that shows surfaces or slices
  double ambient, specular;
  bool has_smooth_normals;  ///< of grids and triangles; meshes are flat
};

/// The default comes first.
std::span<const Style> styles();

/// @param name  empty: the default; else one of style_words()
const Style& style_named(const std::string& name);

}  // namespace rhoray::render

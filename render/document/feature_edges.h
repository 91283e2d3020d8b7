#pragma once

#include "render/resolved_scene.h"

namespace rhoray::render {

/// Default of LayerSpec::feature_edges, for help texts.
inline constexpr const char* feature_edges_words =
    "30 for a mesh's opaque boundary of one colour, unless the lines would nearly cover it";

/// True for a layer that shows the opaque boundary of a mesh in one colour.
bool is_plain_boundary(const ResolvedScene& plan, std::size_t layer);

/// Finds the feature edges of layers that show triangles; none under a heat map. By default a plain
/// boundary has those above 30 degrees, unless their mean distance is less than 1/100 of the
/// surface's diagonal: the lines of voxels or of a rough surface would hide its shape.
void plan_feature_edges(const SceneSpec& scene_spec, ResolvedScene& plan);

}  // namespace rhoray::render

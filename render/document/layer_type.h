#pragma once

#include <cstddef>
#include <string>

#include "render/load.h"
#include "render/scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// True if triangles can be traced at this accuracy.
bool is_level_of_triangles(const std::string& accuracy);

/// Returns the accuracy that the layer or else the scene names; empty: none. For triangles of a
/// document it ignores an accuracy of the scene that triangles do not have.
std::string accuracy_of(const SceneSpec& scene_spec, const LayerSpec& layer);

/// Returns the type of a layer. An automatic layer shows the boundary of a mesh, unless the layer
/// or the command line asks for something that only isosurfaces have. It shows isosurfaces of a
/// grid.
LayerType type_of(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset);

/// Returns the method that the layer names, or that of its accuracy, or the default one.
Method choose_method(const SceneSpec& scene_spec, std::size_t layer, Mode mode, const Dataset& dataset);

/// Refuses keys about fields if the layer's data are triangles.
void refuse_words_of_fields(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset);

/// Refuses keys about isosurfaces if the layer is a boundary.
void refuse_words_of_isosurfaces(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& boundary);

}  // namespace rhoray::render

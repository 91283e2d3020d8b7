#pragma once

#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"
#include "tools/rhoray/scene/place.h"
#include "tools/rhoray/scene/scene_spec.h"

namespace rhoray::tools {

// Materials of surfaces: their names, and the defaults for each kind of data.

/// Names of normals: flat and smooth in meshes and of triangles, exact in grids.
std::vector<std::string> normals_words();
std::string word_of(render::Normals normals, bool has_flat_normals);
bool has_flat_normals(const render::Volume& volume);  ///< meshes and surfaces: also smooth ones

std::vector<std::string> colormap_words();
std::string word_of(render::ColorMap map);

/// Colours, light, normals and opacity of an isosurface of this volume, or of its triangles.
/// Refuses normals that the volume has not, colours by a field that is not there, and a range or
/// colour map without such a field: of a document with the place (ErrorCode::invalid), of a command
/// line with the option (ErrorCode::usage).
/// @param layer  where the wish stands; of a command line without a document
render::Surface choose_surface(const LayerSpec& spec, const render::Volume& volume, const Place& layer);

}  // namespace rhoray::tools

#pragma once

#include <cstddef>
#include <vector>

#include "render/load.h"
#include "render/scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// The colour of one of several surfaces. If there are more than the palette has, hues are evenly
/// spaced, and three pairs of saturation and brightness (HSV, as sRGB) take turns.
Vec3 color_of_surface(std::size_t index, std::size_t count);

/// True if so many isosurfaces of a layer get colours by their values: there are several, and the
/// layer names no colours.
bool are_colored_by_isovalue(const LayerSpec& spec, std::size_t count);

/// Makes several isosurfaces of a layer discernible, where the layer says nothing else.
///
/// Colours: viridis from the lowest isovalue to the highest; coolwarm with 0 in its middle if those
/// below 0 and above 0 enclose different regions: neither bounds of the two extremes contain the
/// other's.
///
/// Opacity: the innermost is opaque. The k-th from inside has opacity 1/(k + 1), so that the
/// innermost contributes twice as much as each other one to a ray that passes all of them. Of two
/// the outer one has the larger bounds. With coolwarm, isovalues below 0 are a set of their own.
void show_several(const LayerSpec& spec, const Dataset& dataset, const std::vector<Layer*>& surfaces);

}  // namespace rhoray::render

#pragma once

#include <span>
#include <string_view>

#include "formats/base/vector.h"

namespace rhoray::render {

/// Colour maps for numbers. Lightness increases monotonically along the first three; coolwarm is
/// lightest in its middle.
enum class ColorMap {
  /// Dark violet to yellow (S. van der Walt and N. Smith), interpolated from five of its colours.
  viridis,
  cubehelix,  ///< black to white through all hues (D. A. Green, Bull. Astr. Soc. India 39, 2011)
  gray,       ///< black to white in even steps of the sRGB code
  /// Blue to red through white, for data with a centre value (K. Moreland, Proc. ISVC 2009).
  coolwarm
};

struct NamedColorMap {
  std::string_view name;
  ColorMap map;
};
/// Returns all colour maps, in the order of the enumeration.
std::span<const NamedColorMap> color_maps();

/// Returns the colour at a position in [0, 1] as linear RGB in [0, 1]; positions outside get the
/// colour of the nearer end.
Vec3 color_of(ColorMap map, double share);

}  // namespace rhoray::render

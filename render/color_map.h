#pragma once

#include <span>
#include <string_view>

#include "formats/base/vector.h"

namespace rhoray::render {

/// Colours for numbers. Along the first three lightness only grows; coolwarm has it largest in its middle.
enum class ColorMap {
  viridis,    ///< dark violet to yellow (S. van der Walt and N. Smith), by five of its colours
  cubehelix,  ///< black to white through all hues (D. A. Green, Bull. Astr. Soc. India 39, 2011)
  gray,       ///< black to white in even steps of the sRGB code
  coolwarm    ///< blue to red through white, for numbers with a middle (K. Moreland, Proc. ISVC 2009)
};

struct NamedColorMap {
  std::string_view name;
  ColorMap map;
};
/// All of them, in the order of the enumeration.
std::span<const NamedColorMap> color_maps();

/// The colour of a share in [0, 1], linear RGB in [0, 1]; shares beyond are those of the nearer end.
Vec3 color_of(ColorMap map, double share);

}  // namespace rhoray::render

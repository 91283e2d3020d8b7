#pragma once

#include <span>
#include <string_view>

#include "formats/base/interval.h"
#include "formats/base/vector.h"

namespace rhoray::render {

/// Colour maps for numbers.
struct ColorMap {
  enum Base {
    // From dark to light; equal steps of the number look like equal steps of colour.
    viridis,    ///< dark violet over green to yellow
    magma,      ///< black over purple to a light yellow
    inferno,    ///< black over red to a light yellow
    plasma,     ///< blue over red to yellow
    cividis,    ///< dark blue to yellow; looks nearly the same to readers who cannot tell red from green
    gray,       ///< black to white in even steps of the sRGB code
    cubehelix,  ///< black to white through all hues (D. A. Green, Bull. Astr. Soc. India 39, 2011)
    /// Dark blue over green to dark red, lightest in its middle. Shows more steps than the others,
    /// but not which of two colours stands for the larger number.
    turbo,
    /// Blue to red through white, for data with a centre value (K. Moreland, Proc. ISVC 2009).
    coolwarm
  };

  Base base = viridis;
  bool is_reversed = false;

  constexpr ColorMap() = default;
  constexpr ColorMap(Base map, bool reversed = false) : base(map), is_reversed(reversed) {}
  bool operator==(const ColorMap&) const = default;
};

struct NamedColorMap {
  std::string_view name;
  ColorMap map;
};
/// All colour maps: each in the order of the enumeration, with its reverse after it.
std::span<const NamedColorMap> color_maps();

/// Returns the colour at a position in [0, 1] as linear RGB in [0, 1]; positions outside get the
/// colour of the nearer end.
Vec3 color_of(ColorMap map, double share);

/// Returns the linear form of a colour that is encoded as sRGB (IEC 61966-2-1); both in [0, 1].
Vec3 linear_from_srgb(const Vec3& encoded);

/// How the values of a range are spread over a colour map.
struct ColorScale {
  bool is_logarithmic = false;  ///< by their logarithms; the range lies above 0
  /// Bands of one colour each, 2 or more, from the first colour of the map to its last; they divide
  /// the range evenly on the scale. 0: colours change continuously.
  int levels = 0;

  bool operator==(const ColorScale&) const = default;
};

/// Returns the position of a value in a range: 0 at its low end, 1 at its high end.
double position_of(const ColorScale& scale, const Interval<double>& range, double value);
/// The inverse.
double value_at(const ColorScale& scale, const Interval<double>& range, double position);

/// Returns the position in the map whose colour is shown at a position in the range.
double position_in_map(const ColorScale& scale, double position);

}  // namespace rhoray::render

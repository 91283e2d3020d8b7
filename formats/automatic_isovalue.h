#pragma once

#include <optional>
#include <vector>

#include "formats/field_summary.h"

namespace rhoray::formats {

/// The isovalue for a field of which nothing else is known, and what else could be meant.
struct AutomaticIsovalue {
  double value = 0;
  bool is_valley = false;             ///< false: value is Otsu's threshold
  std::vector<double> other_valleys;  ///< the gradient's strength decreases
  double otsu_threshold = 0;
};

/// Chooses the valley of the histogram whose isosurface has the strongest gradient.
///
/// A valley parts two peaks of the smoothed histogram: two materials. Its isovalue is midway
/// between the peaks, where a blurred boundary lies, as far as the valley's floor reaches. The
/// strength of a valley is the mean gradient on its isosurface times the root of the area. The area
/// keeps a small surface inside a large one from winning. A valley without samples, such as the
/// edge of a mask, comes after all others.
///
/// The value is Otsu's threshold where no mean gradient was recorded, where there is no valley, and
/// where the isosurface at the threshold is much stronger than that of every valley.
/// @return  nothing when all values are equal or none is finite
std::optional<AutomaticIsovalue> automatic_isovalue(const FieldSummary& field);

}  // namespace rhoray::formats

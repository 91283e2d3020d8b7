#pragma once

#include <vector>

#include "render/cell/trilinear.h"
#include "render/exact/enclosure.h"

namespace rhoray::render {

/// The truth about the isosurface along a chord of a trilinear cell, decided exactly for the given
/// doubles. Inside is value >= isovalue.
struct CellVerdict {
  bool changes = false;  ///< the side changes in [0, 1]
  /// From outside: the chord is inside at this one point only. Every change at s = 1 counts as
  /// such, because this cell does not tell what follows.
  bool touches = false;
  Enclosure s{};  ///< of the change
  /// Distinct points in [0, 1] where value = isovalue; -1 when that holds everywhere.
  int root_count = 0;
  Road road = Road::filter;
};

/// Finds where the side first changes along the straight line from p0 (s = 0) to p1 (s = 1), given
/// in the cell's own coordinates. From outside it is the first s with value >= isovalue; from
/// inside the infimum of s with value < isovalue. A chord that starts on the other side changes at
/// 0.
///
/// @param cell   finite corners; no other requirement
/// @param p0,p1  finite; may be equal, and may be outside of the cell, where the interpolant is
///   continued
/// @param width  > 0; the enclosure is at most this wide, or its ends are the same or neighbouring
///   doubles
CellVerdict exact_crossing(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                           bool starts_inside, double width);

struct MaximumVerdict {
  Enclosure value{};
  Enclosure s{};  ///< of the smallest s at which it is reached
  Road road = Road::filter;
};

/// Finds the largest value along the same line.
/// @param width  > 0; the enclosure of s is at most this wide, that of the value at most `width`
///   times the largest magnitude at a corner; or their ends are the same or neighbouring doubles
MaximumVerdict exact_maximum(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double width);

/// Returns all points in [0, 1] where value = isovalue, in increasing order, each as narrow as for
/// exact_crossing. Returns none when that holds everywhere. In rational numbers.
std::vector<Enclosure> exact_roots(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                                   double width);

/// The same without the filter, as a reference for tests of the filter.
CellVerdict exact_crossing_unfiltered(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                                      bool starts_inside, double width);
MaximumVerdict exact_maximum_unfiltered(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double width);

}  // namespace rhoray::render

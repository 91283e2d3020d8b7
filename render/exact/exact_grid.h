#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/vector.h"
#include "render/exact/enclosure.h"
#include "render/exact/grid_source.h"
#include "render/traverse/ray.h"

namespace rhoray::render {

/// The cost of a verdict.
struct ExactEffort {
  std::int64_t cells_visited = 0;
  std::int64_t regions_skipped = 0;
  std::int64_t filtered = 0;           ///< cells decided in double precision
  std::int64_t exact = 0;              ///< cells decided in rational numbers
  std::int64_t exact_comparisons = 0;  ///< of times at which planes are passed
};

struct GridRayVerdict {
  bool is_hit = false;
  /// The ray comes from outside and is inside at this one point only, as far as there are data.
  bool touches = false;
  Enclosure t{};
  /// The first cell along the ray in which the change is seen. At a shared face it is, from
  /// outside, the cell before it; from inside, the one behind.
  Index3 cell{0, 0, 0};
  /// Roots in that cell's closed part of the ray; -1 when the value is the isovalue everywhere
  /// on it.
  int root_count = 0;
  ExactEffort effort{};
};

/// Finds where the side first changes along a ray through a grid, decided exactly: trilinear
/// between the given samples, along origin + t * direction with the given doubles. Inside is value
/// >= isovalue.
///
/// The box of the grid is closed, and so is [t_min, t_max]. The ray starts on the side where it
/// meets data, and forgets its side in absent cells: there is no surface at the border of data. A
/// ray in a plane between cells goes through the cells above the plane; in the last plane it goes
/// through the last cells. A component of the direction with an infinite inverse counts as zero
/// (PlaneTimesOf). Parts of length zero are ignored. There is no hit for a direction of zero, for a
/// ray that is not finite, and beyond the range of doubles.
///
/// @param width  > 0, finite; the enclosure of t is at most this wide, or its ends are the same or
///   neighbouring doubles
GridRayVerdict exact_first_crossing(const ExactGridSource& grid, const Ray& ray, double isovalue, double width);

/// One change of side along a ray.
struct GridCrossing {
  Enclosure t{};
  /// The first cell along the ray in which the change is seen, as in GridRayVerdict.
  Index3 cell{0, 0, 0};
  bool to_inside = false;
};

/// Finds all changes of side along the same ray, in order. The first one is that of
/// exact_first_crossing, with the same enclosure and cell. Enclosures are as narrow as there, and
/// neither of their ends ever decreases along the ray.
///
/// A ray from outside that is inside at one point only enters and leaves there: two crossings with
/// one enclosure. At the end of the data or of the ray it only enters, as nothing shows what
/// follows. A ray that only touches the isovalue from inside does not change its side.
///
/// @param most  the search ends after so many crossings
std::vector<GridCrossing> exact_crossings(const ExactGridSource& grid, const Ray& ray, double isovalue, double width,
                                          std::size_t most);

struct GridMaximumVerdict {
  bool has_value = false;  ///< false where the ray meets no data
  Enclosure value{};       ///< its ends are the same or neighbouring doubles
  Enclosure t{};           ///< of the smallest t at which it is reached
  Index3 cell{0, 0, 0};    ///< the first along the ray that reaches it
  ExactEffort effort{};
};

/// Finds the largest value along the same ray.
GridMaximumVerdict exact_largest_value(const ExactGridSource& grid, const Ray& ray, double width);

}  // namespace rhoray::render

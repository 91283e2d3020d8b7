#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/exact/enclosure.h"
#include "render/exact/exact_tet.h"
#include "render/traverse/ray.h"

namespace rhoray::render {

struct TetRayVerdict {
  bool is_hit = false;
  /// The ray comes from outside and is inside at this one point only, as far as there are data.
  bool touches = false;
  Enclosure t{};
  /// Of those that show the change: the one that the ray enters first, then the smallest id.
  std::uint64_t cell = 0;
  Road road = Road::filter;
  std::int64_t tets_exact = 0;  ///< number of tetrahedra cut in rational numbers
};

/// Finds where the side first changes along a ray through tetrahedra, decided exactly for the given
/// doubles. Inside is value >= isovalue.
///
/// A tetrahedron is a closed set. The parts of the ray in [t_min, t_max] that are in one of them,
/// with a length above zero, are joined where they meet or overlap. At the start of each joined
/// part the ray has the side that it finds there, so there is no surface where the ray enters the
/// mesh. Tetrahedra without volume, those that the ray only touches in a point, and those with a
/// vertex or a value that is not finite are ignored. Where tetrahedra overlap and disagree, the
/// first of their changes counts.
///
/// The verdict is correct when all tetrahedra that the ray touches are given. It is also correct
/// when only the active ones of a mesh without gaps, overlaps or cells without volume are given:
/// those whose values are on both sides. Then `touches` may be set for a ray that continues into a
/// tetrahedron whose values are all >= isovalue. It is correct when those with the isovalue itself
/// among their values are given too.
///
/// @param width  > 0, finite; the enclosure of t is at most this wide, or its ends are the same or
///   neighbouring doubles
TetRayVerdict exact_first_crossing(std::span<const ExactTet> tets, const Ray& ray, double isovalue, double width);

/// One change of side along a ray.
struct TetCrossing {
  Enclosure t{};
  std::uint64_t cell = 0;  ///< as in TetRayVerdict
  bool to_inside = false;
};

/// Finds all changes of side along the same ray, in order. The first one is that of
/// exact_first_crossing, with the same enclosure and cell. Enclosures are as narrow as there, and
/// neither of their ends ever decreases along the ray.
///
/// A ray from outside that is inside at one point only enters and leaves there: two crossings with
/// one enclosure. At the end of a joined part it only enters, as nothing shows what follows. A ray
/// that only touches the isovalue from inside does not change its side. Where tetrahedra overlap
/// and disagree, the first change behind the last one counts each time.
///
/// The result is correct when all tetrahedra that the ray touches are given. For a mesh as above it
/// is also correct when only those are given that have values on both sides, or the isovalue itself
/// among their values.
///
/// @param most  the search ends after so many crossings
std::vector<TetCrossing> exact_crossings(std::span<const ExactTet> tets, const Ray& ray, double isovalue, double width,
                                         std::size_t most);

struct TetMaximumVerdict {
  bool has_value = false;
  Enclosure value{};       ///< its ends are the same or neighbouring doubles
  Enclosure t{};           ///< as tight; of the smallest t at which it is reached
  std::uint64_t cell = 0;  ///< as for a crossing
};

/// Finds the largest value along the same ray, always in rational numbers except for tetrahedra
/// that are certainly missed. Correct when all tetrahedra that the ray touches are given, or those
/// of them that reach the largest value.
TetMaximumVerdict exact_largest_value(std::span<const ExactTet> tets, const Ray& ray);

}  // namespace rhoray::render

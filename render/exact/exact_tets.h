#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "render/exact/enclosure.h"
#include "render/traverse/ray.h"

namespace rhoray::render {

/// A tetrahedron with a value at each vertex, between which the field is linear. In any order of vertices.
struct ExactTet {
  std::array<Vec3, 4> point;
  std::array<double, 4> value;
  std::uint64_t id = 0;
};

struct TetRayVerdict {
  bool is_hit = false;
  bool touches = false;  ///< the ray comes from outside and is inside at this one point only, as far as there are data
  Enclosure t{};
  std::uint64_t cell = 0;  ///< of those that show the change: the one that the ray enters first, then the smallest id
  Road road = Road::filter;
  std::int64_t tets_exact = 0;  ///< how many tetrahedra were cut in rational numbers
};

/// Where the side first changes along a ray through tetrahedra, decided exactly for the doubles as given. Inside is
/// value >= isovalue.
///
/// A tetrahedron is a closed set. Those parts of the ray in [t_min, t_max] that lie in one of them, of some length,
/// join where they meet or overlap; at the start of each joined part the ray has the side that it finds there, so no
/// surface is seen where the ray comes into the mesh. Left out are tetrahedra without volume, those that the ray only
/// touches in a point, and those with a vertex or a value that is not finite. Where tetrahedra overlap and disagree,
/// the first of their changes counts.
///
/// The verdict is right when all tetrahedra that the ray touches are given, and also when only the active ones of a
/// mesh without gaps, overlaps or cells without volume are given: those whose values lie on both sides. Then `touches`
/// may be said of a ray that goes on into a tetrahedron whose values are all >= isovalue; it is right when also those
/// are given that have the isovalue itself among their values.
///
/// @param width  > 0, finite; the enclosure of t is at most this wide, or its ends are the same or neighbouring doubles
TetRayVerdict exact_first_crossing(std::span<const ExactTet> tets, const Ray& ray, double isovalue, double width);

struct TetMaximumVerdict {
  bool has_value = false;
  Enclosure value{};       ///< its ends are the same or neighbouring doubles
  Enclosure t{};           ///< as tight; of the smallest t where it is reached
  std::uint64_t cell = 0;  ///< as for a crossing
};

/// The largest value along the same ray, always in rational numbers but for tetrahedra that are missed for certain.
/// Right when all are given that the ray touches, or those of them that reach the largest value.
TetMaximumVerdict exact_largest_value(std::span<const ExactTet> tets, const Ray& ray);

}  // namespace rhoray::render

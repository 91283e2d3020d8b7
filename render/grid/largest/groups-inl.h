// Which rays are searched for their largest values together.
#if defined(RHORAY_WIDE_MAXIMUM_GROUPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_GROUPS_INL_H
#undef RHORAY_WIDE_MAXIMUM_GROUPS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_GROUPS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/largest/parts.h"
#include "render/traverse/frustum_walk.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// A frustum around two others with the same axes. Its lines pass through the outer ends of both:
/// what lies between the lines of one frustum between its ends lies between these.
HWY_INLINE Frustum frustum_around(const Frustum& one, const Frustum& other) {
  Frustum both = one;
  both.first = other.first < one.first ? other.first : one.first;
  both.last = other.last > one.last ? other.last : one.last;
  const double length = both.last - both.first;
  const auto line = [&](const Frustum::Line& a, const Frustum::Line& b, bool lower) {
    const auto chosen = [&](double w) { return (a.at(w) < b.at(w)) == lower ? a.at(w) : b.at(w); };
    const double slope = length > 0 ? (chosen(both.last) - chosen(both.first)) / length : 0;
    return Frustum::Line{chosen(both.first) - both.first * slope, slope};
  };
  for (int m = 0; m < 2; ++m) {
    both.low[m] = line(one.low[m], other.low[m], true);
    both.high[m] = line(one.high[m], other.high[m], false);
  }
  return both;
}

/// Adjacent groups are searched together where their frustum crosses no more blocks than this: one
/// for four rays. Times are the same from 40 to 250; with 16 the gain is half.
inline constexpr double most_across = 64;

/// Number of blocks that the widest part of a frustum crosses.
HWY_INLINE double blocks_across(const Frustum& frustum) {
  double largest = 0;
  for (const double w : {frustum.first, frustum.last}) {
    double blocks = 1;
    for (int m = 0; m < 2; ++m) blocks *= (frustum.high[m].at(w) - frustum.low[m].at(w)) * 0.25 + 1;
    largest = blocks > largest ? blocks : largest;
  }
  return largest;
}

/// Appends a group. The rays of a full group, eight pixels in a row, are reordered so that those of
/// a vector lie close together: four of one row, then four of the next.
/// @param first  index of the group's first ray in the chunk
HWY_INLINE void append(const RayGroup& group, std::size_t first, SearchedRays& rays) {
  const std::size_t at = rays.count;
  rays.octant = group.octant;
  rays.inside[at / RayGroup::size] = 0;
  const bool is_full = group.count == RayGroup::size;
  constexpr hn::CappedTag<double, 4> four;
  constexpr std::size_t step = hn::MaxLanes(four);
  const std::size_t padded = (group.count + 15) / 16 * 16;
  for (std::size_t to = 0; to < padded; to += step) {
    const std::size_t quad = to / 4;
    const std::size_t r = is_full ? (quad / 8 * 8 + quad % 4 * 2 + quad / 4 % 2) * 4 + to % 4 : to;
    const auto copy = [&](const double* x, double* y) HWY_ATTR { hn::Store(hn::Load(four, x + r), four, y + at + to); };
    for (int a = 0; a < 3; ++a) {
      copy(group.origin[a], rays.origin[a]), copy(group.direction[a], rays.direction[a]);
      copy(group.plane_origin[a], rays.plane_origin[a]), copy(group.inverse[a], rays.inverse[a]);
    }
    copy(group.t_in, rays.t_in), copy(group.t_out, rays.t_out);
    for (std::size_t i = 0; i < step; ++i) {
      rays.index[at + to + i] = static_cast<std::uint32_t>(first) + group.index[r + i];
    }
    rays.inside[at / RayGroup::size] |= (group.inside >> r & ((std::uint64_t{1} << step) - 1)) << to;
  }
  rays.count = at + group.count;
}

/// Calls search(lattice, frustum) for the rays of a chunk, as they are in `rays`, until every ray
/// that enters the lattice was in one search.
template <class Search>
HWY_INLINE void for_each_search(const RayArrays& chunk, std::size_t count, const int* leaf_count,
                                const std::array<int, 3>& node_count, RayGroup& group, SearchedRays& rays,
                                const Search& search) {
  Frustum around{};
  const auto finish = [&]() HWY_ATTR {
    if (rays.count != 0) search(MirroredLattice(rays.octant, node_count), around);
    rays.count = 0;
  };
  rays.count = 0;
  for (std::size_t first = 0; first < count; first += RayGroup::size) {
    const RayArrays part{{chunk.origin[0] + first, chunk.origin[1] + first, chunk.origin[2] + first},
                         {chunk.direction[0] + first, chunk.direction[1] + first, chunk.direction[2] + first},
                         chunk.t_min + first,
                         chunk.t_max + first,
                         nullptr};
    const std::size_t left = count - first;
    const auto visit = [&](const RayGroup&, const MirroredLattice&, const Frustum& frustum) HWY_ATTR {
      const bool is_full = group.count == RayGroup::size;
      // At most as many vectors as a word has bits.
      const bool has_room = (rays.count + group.count + float_lanes - 1) / float_lanes <= VectorLines::size;
      const bool fits = rays.count != 0 && is_full && has_room && rays.count % RayGroup::size == 0 &&
                        rays.octant == group.octant && around.major == frustum.major;
      Frustum together = frustum;
      if (fits) together = frustum_around(around, frustum);
      if (!fits || !(blocks_across(together) <= most_across)) finish(), together = frustum;
      around = together;
      append(group, first, rays);
    };
    for_each_group(part, left < RayGroup::size ? left : RayGroup::size, leaf_count, node_count, group, visit);
  }
  finish();
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// All crossings of rays with facets: for each ray the facets that it passes through, the nearest
// first.
#if defined(RHORAY_WIDE_FACET_LISTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_LISTS_INL_H
#undef RHORAY_WIDE_FACET_LISTS_INL_H
#else
#define RHORAY_WIDE_FACET_LISTS_INL_H
#endif

#include <bit>
#include <cmath>
#include <cstdint>

#include <hwy/highway.h>

#include "render/triangles/kernels/all_hits_parts.h"
#include "render/triangles/kernels/facet_group-inl.h"
#include "render/triangles/kernels/facet_hits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

HWY_INLINE void clear_lists(FacetLists& lists) {
  for (std::size_t lane = 0; lane < lanes; lane += float_lanes) hn::Store(hn::Zero(ints), ints, lists.count + lane);
  lists.overflowed = 0;
}

/// Inserts a facet into a lane's list that already has one, or that has room for only one.
/// @return  whether this moved the ray's end nearer
HWY_INLINE bool insert_into_list(FacetGroup& group, std::size_t lane, float depth, std::int32_t facet) {
  FacetLists& lists = *group.scratch.lists;
  auto place = static_cast<std::size_t>(lists.count[lane]);
  const auto is_before = [&](std::size_t other) HWY_ATTR {
    const float of_other = lists.depth[other][lane];
    return depth < of_other || (depth == of_other && facet < lists.facet[other][lane]);
  };
  if (place == lists.room) {
    lists.overflowed |= std::uint64_t{1} << lane;
    if (!is_before(--place)) return false;
  } else {
    ++lists.count[lane];
  }
  for (; place > 0 && is_before(place - 1); --place) {
    lists.depth[place][lane] = lists.depth[place - 1][lane];
    lists.facet[place][lane] = lists.facet[place - 1][lane];
  }
  lists.depth[place][lane] = depth, lists.facet[place][lane] = facet;
  if (static_cast<std::size_t>(lists.count[lane]) < lists.room) return false;
  group.scratch.depth[lane] = lists.depth[lists.room - 1][lane];
  return true;
}

/// Inserts a facet into the lists of some lanes from r on. Where a list is full, the ray is traced
/// only up to the last facet in it.
/// @return  whether this moved the end of any ray nearer
HWY_INLINE bool note_in_lists(FacetGroup& group, MaskF through, VecF depth, std::size_t r, std::uint32_t facet) {
  FacetLists& lists = *group.scratch.lists;
  const VecF end = hn::Load(floats, group.scratch.depth + r), begin = hn::Load(floats, group.lines.begin + r);
  const MaskF met = hn::And(through, hn::And(hn::Le(depth, end), hn::Ge(depth, begin)));
  const auto number = static_cast<std::int32_t>(facet);
  const VecI count = hn::Load(ints, lists.count + r);
  const MaskF is_first = hn::And(met, hn::RebindMask(floats, hn::Eq(count, hn::Zero(ints))));
  if (lists.room > 1 && !hn::AllFalse(floats, is_first)) {
    const auto is_first_i = hn::RebindMask(ints, is_first);
    hn::BlendedStore(depth, is_first, floats, lists.depth[0] + r);
    hn::BlendedStore(hn::Set(ints, number), is_first_i, ints, lists.facet[0] + r);
    hn::BlendedStore(hn::Set(ints, 1), is_first_i, ints, lists.count + r);
  }
  std::uint64_t bits = bits_of(floats, lists.room > 1 ? hn::AndNot(is_first, met) : met);
  if (bits == 0) return false;
  HWY_ALIGN float depths[float_lanes];
  hn::Store(depth, floats, depths);
  bool is_nearer = false;
  for (; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(bits));
    is_nearer |= insert_into_list(group, r + i, depths[i], number);
  }
  return is_nearer;
}

/// The largest size of a vector's three components.
HWY_INLINE double largest_size(const double* v) {
  const double x = std::abs(v[0]), y = std::abs(v[1]), z = std::abs(v[2]), larger = x < y ? y : x;
  return larger < z ? z : larger;
}

/// Removes facets from a ray's list that do not change its side: a ray that passes through an edge
/// hits both facets. Keeps at most as many as a CrossingList holds.
///
/// Another kernel traces the ray if the facets do not tell its side:
///   - It passes facets in different directions at one vertex, where they have no order. Hits are
///     at one vertex if their depths differ by at most facet_margin, far more than rounding.
///   - It is so nearly parallel to a facet that rounding hides in which direction it passes. It may
///     follow such a facet from one end to the other, with its other hits far away. facet_margin is
///     more than place_error over the size of the mesh. Of a flat cell, whose gradient is NaN, no
///     direction is known.
HWY_INLINE void keep_changes(const FacetGroup& group, std::size_t lane) {
  FacetLists& lists = *group.scratch.lists;
  const auto count = static_cast<std::size_t>(lists.count[lane]);
  const std::size_t ray = ray_of(lane);
  const double direction[3] = {group.rays.direction[0][ray], group.rays.direction[1][ray],
                               group.rays.direction[2][ray]};
  const double least_share = facet_margin * largest_size(direction);
  double side = 0;
  std::size_t kept = 0;
  float last_depth = -beyond;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t facet = lists.facet[i][lane];
    const double* gradient = group.surface.fields[facet].gradient;
    const double rise = gradient[0] * direction[0] + gradient[1] * direction[1] + gradient[2] * direction[2];
    const bool is_same = rise * side > 0;
    const float depth = lists.depth[i][lane], gap = depth - last_depth;
    const bool has_direction = std::abs(rise) > least_share * largest_size(gradient);  // false for NaN
    if (HWY_UNLIKELY(!has_direction || (!is_same && gap <= static_cast<float>(facet_margin)))) {
      kept = 0;
      lists.complete[lists.first + ray] = 0;
      break;
    }
    last_depth = depth;
    if (is_same) continue;
    side = rise > 0 ? 1 : -1;
    if (kept == CrossingList::most) {
      lists.overflowed |= std::uint64_t{1} << lane;
      break;
    }
    lists.depth[kept][lane] = depth, lists.facet[kept][lane] = facet;
    ++kept;
  }
  lists.count[lane] = static_cast<std::int32_t>(kept);
}

/// Completes the lists of a group's lanes, and writes the number of crossings.
/// @return  the largest number of any lane
HWY_INLINE std::size_t complete_lists(const FacetGroup& group) {
  FacetLists& lists = *group.scratch.lists;
  VecI most = hn::Zero(ints);
  for (std::size_t first = 0; first < lanes; first += float_lanes) {
    const auto several = hn::Gt(hn::Load(ints, lists.count + first), hn::Set(ints, 1));
    for (std::uint64_t bits = bits_of(ints, several); bits != 0; bits &= bits - 1)
      keep_changes(group, first + static_cast<std::size_t>(std::countr_zero(bits)));
    most = hn::Max(most, hn::Load(ints, lists.count + first));
  }
  for (std::uint64_t bits = lists.overflowed; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
    float light = 1;
    for (std::int32_t k = 0; k < lists.count[lane]; ++k) light *= lists.passing;
    if (!(light < lists.least_light)) lists.complete[lists.first + ray_of(lane)] = 0;
  }
  // Rays of other groups have zero crossings here, so combining keeps their numbers.
  std::uint8_t* written = lists.written->count + lists.first;
  for (std::size_t ray = 0; ray < lanes; ray += 4)
    for (std::size_t i = 0; i < 4; ++i)
      written[ray + i] = static_cast<std::uint8_t>(written[ray + i] | lists.count[lane_of(ray) + i]);
  return static_cast<std::size_t>(hn::GetLane(hn::MaxOfLanes(ints, most)));
}

/// Writes the crossings of these lanes.
HWY_INLINE void write_lists(FacetGroup& group, std::uint64_t lanes_alive, std::uint64_t visits) {
  FacetLists& lists = *group.scratch.lists;
  std::size_t most = complete_lists(group);
  most = most > 0 ? most : 1;  // the first are always written: they hold the cost of the rays
  for (std::size_t k = 0; k < most; ++k) {
    for (std::size_t first = 0; first < lanes; first += float_lanes) {
      const auto has = hn::Gt(hn::Load(ints, lists.count + first), hn::Set(ints, static_cast<std::int32_t>(k)));
      const VecI facet = hn::Load(ints, lists.facet[k] + first), none = hn::Set(ints, FacetScratch::no_facet);
      const VecF depth = hn::Load(floats, lists.depth[k] + first), nowhere = hn::Set(floats, -beyond);
      hn::Store(hn::IfThenElse(has, facet, none), ints, group.scratch.facet + first);
      hn::Store(hn::IfThenElse(hn::RebindMask(floats, has), depth, nowhere), floats, group.scratch.depth + first);
    }
    FacetHits<FacetSearch::first>(group, from(lists.written->hits[k], lists.first)).write(lanes_alive, visits);
  }
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// All crossings of rays with facets, in their order: of each ray the facets that it passes through, the nearest first.
#if defined(RHORAY_WIDE_FACET_LISTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_LISTS_INL_H
#undef RHORAY_WIDE_FACET_LISTS_INL_H
#else
#define RHORAY_WIDE_FACET_LISTS_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/kernels/wide/facet_group-inl.h"
#include "render/kernels/wide/facet_hits-inl.h"
#include "render/kernels/wide/facet_shells_parts.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

HWY_INLINE void clear_lists(FacetLists& lists) {
  for (std::size_t lane = 0; lane < lanes; ++lane) lists.count[lane] = 0;
  lists.overflowed = 0;
}

/// Puts a facet into the lists of some lanes from r on. Where a list is full, a ray is followed no farther than to the
/// last of it.
/// @return  whether that is now nearer for any
HWY_INLINE bool note_in_lists(FacetGroup& group, MaskF through, VecF depth, std::size_t r, std::uint32_t facet) {
  FacetLists& lists = *group.scratch.lists;
  const VecF end = hn::Load(floats, group.scratch.depth + r), begin = hn::Load(floats, group.lines.begin + r);
  const MaskF met = hn::And(through, hn::And(hn::Le(depth, end), hn::Ge(depth, begin)));
  std::uint64_t bits = bits_of(floats, met);
  if (bits == 0) return false;
  HWY_ALIGN float depths[float_lanes];
  hn::Store(depth, floats, depths);
  bool is_nearer = false;
  for (; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(bits));
    const std::size_t lane = r + i;
    float* of_lane = lists.depth[lane];
    std::int32_t* facets = lists.facet[lane];
    std::size_t place = lists.count[lane];
    const auto number = static_cast<std::int32_t>(facet);
    if (place == lists.room) {
      lists.overflowed |= std::uint64_t{1} << lane;
      --place;
      if (of_lane[place] < depths[i] || (of_lane[place] == depths[i] && facets[place] < number)) continue;
    } else {
      ++lists.count[lane];
    }
    for (; place > 0 &&
           (of_lane[place - 1] > depths[i] || (of_lane[place - 1] == depths[i] && facets[place - 1] > number));
         --place)
      of_lane[place] = of_lane[place - 1], facets[place] = facets[place - 1];
    of_lane[place] = depths[i], facets[place] = number;
    if (lists.count[lane] < lists.room) continue;
    group.scratch.depth[lane] = of_lane[lists.room - 1];
    is_nearer = true;
  }
  return is_nearer;
}

/// Leaves out of a ray's list what does not change its side: where it passes through an edge it meets both facets.
/// @return  how many are left; at most as many as a CrossingList holds
HWY_INLINE std::size_t keep_changes(const FacetGroup& group, std::size_t lane) {
  FacetLists& lists = *group.scratch.lists;
  const std::size_t ray = ray_of(lane);
  double side = 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lists.count[lane]; ++i) {
    const double* gradient = group.surface.fields[lists.facet[lane][i]].gradient;
    double rise = 0;
    for (int a = 0; a < 3; ++a) rise += gradient[a] * group.rays.direction[a][ray];
    // Written so that the facet of a flat cell, whose gradient is none, counts.
    if (rise * side > 0) continue;
    side = side == 0 ? (rise > 0 ? 1 : -1) : -side;
    if (kept == CrossingList::most) {
      lists.overflowed |= std::uint64_t{1} << lane;
      break;
    }
    lists.depth[lane][kept] = lists.depth[lane][i], lists.facet[lane][kept] = lists.facet[lane][i];
    ++kept;
  }
  return kept;
}

/// Writes the crossings of these lanes.
HWY_INLINE void write_lists(FacetGroup& group, std::uint64_t lanes_alive, std::uint64_t visits) {
  FacetLists& lists = *group.scratch.lists;
  std::size_t most = 1;  // the first crossings are written in any case: what the rays took stands there
  for (std::uint64_t bits = lanes_alive; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
    const std::size_t kept = keep_changes(group, lane), ray = ray_of(lane);
    lists.count[lane] = static_cast<std::uint8_t>(kept);
    most = kept > most ? kept : most;
    lists.written->count[ray] = static_cast<std::uint8_t>(kept);
    float light = 1;
    for (std::size_t k = 0; k < kept; ++k) light *= lists.passing;
    if ((lists.overflowed >> lane & 1) != 0 && !(light < lists.least_light)) lists.complete[ray] = 0;
  }
  for (std::size_t k = 0; k < most; ++k) {
    for (std::uint64_t bits = lanes_alive; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      const bool has = k < lists.count[lane];
      group.scratch.facet[lane] = has ? lists.facet[lane][k] : FacetScratch::no_facet;
      group.scratch.depth[lane] = has ? lists.depth[lane][k] : -beyond;
    }
    FacetHits<FacetSearch::first>(group, lists.written->hits[k]).write(lanes_alive, visits);
  }
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

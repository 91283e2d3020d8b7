// The search for the largest values on rays through meshes, compiled once per machine.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/tets/largest/lanes.cpp"  // relative to the repository root
// Comes first: this file is included again for each machine.
#include <hwy/foreach_target.h>

#include <bit>

#include <hwy/highway.h>

#include "render/tets/largest/cells-inl.h"
#include "render/traverse/on_machine.h"
#include "render/traverse/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

using Eights = hn::CappedTag<float, formats::ClusterShape::width>;
using VecE = hn::Vec<Eights>;
inline constexpr Eights eights{};

/// The search for one group of rays: visits regions of the tree in the order of their largest
/// values, the largest first.
class TetSearch {
 public:
  HWY_INLINE TetSearch(const TetMaximumField& field, const RayArrays& rays, const TetRays& group, TetScratch& scratch,
                       KernelCounters& counters)
      : field_(field), group_(group), scratch_(scratch), counters_(counters), cells_(field, rays, group, scratch) {
    const double size = field.range.hi - field.range.lo;
    lowest_ = field.range.lo, per_range_ = size > least_range ? 1 / size : 0;
  }

  void run() {
    scratch_.region_count = 0;
    open(field_.top_level, 0);
    while (scratch_.region_count != 0) {
      const TetRegion region = take();
      visit(region);
    }
    cells_.suspects.decide();
    counters_.cells_solved += cells_.looks * TetScratch::pack;
  }

 private:
  HWY_INLINE void visit(const TetRegion& region) {
    const std::uint64_t lanes = lanes_through(region);
    if (lanes == 0) return;
    const auto ray_count = static_cast<std::uint64_t>(std::popcount(lanes));
    for (std::size_t r = 0; r < TetScratch::lanes; r += float_lanes) {
      const VecC more = hn::IfThenElseZero(mask_of(codes, lanes >> r), hn::Set(codes, 1U));
      hn::Store(hn::Add(hn::Load(codes, scratch_.cost + r), more), codes, scratch_.cost + r);
    }
    if (region.level > 0) {
      counters_.macrocells_visited += ray_count;
      open(region.level - 1, region.entry);
    } else {
      counters_.cells_visited += ray_count;
      const std::uint64_t start = field_.time_phases ? ticks_now() : 0;
      cells_.look_into(region.entry, lanes);
      if (field_.time_phases) counters_.intersection_ticks += ticks_now() - start;
    }
  }

  HWY_INLINE bool comes_before(const TetRegion& a, const TetRegion& b) const {
    return a.bound > b.bound || (a.bound == b.bound && a.near < b.near);
  }

  HWY_INLINE void put(const TetRegion& region) {
    if (scratch_.region_count == TetScratch::region_capacity) return visit_at_once(region);
    std::size_t at = scratch_.region_count++;
    for (; at != 0 && comes_before(region, scratch_.regions[(at - 1) / 2]); at = (at - 1) / 2)
      scratch_.regions[at] = scratch_.regions[(at - 1) / 2];
    scratch_.regions[at] = region;
  }

  HWY_NOINLINE void visit_at_once(const TetRegion& region) { visit(region); }

  HWY_INLINE TetRegion take() {
    TetRegion* const regions = scratch_.regions;
    const TetRegion top = regions[0], last = regions[--scratch_.region_count];
    const std::size_t count = scratch_.region_count;
    std::size_t at = 0;
    for (std::size_t below = 1; below < count; below = 2 * at + 1) {
      if (below + 1 < count && comes_before(regions[below + 1], regions[below])) ++below;
      if (!comes_before(regions[below], last)) break;
      regions[at] = regions[below];
      at = below;
    }
    regions[at] = last;
    return top;
  }

  /// Puts those entries of a block into the queue that the group may hit.
  void open(int level, std::uint64_t block) {
    if (field_.is_single)
      open_with(static_cast<const formats::RangeBlock<float>*>(field_.ranges[level])[block], level, block);
    else
      open_with(static_cast<const formats::RangeBlock<double>*>(field_.ranges[level])[block], level, block);
  }

  template <class Ranges>
  HWY_INLINE void open_with(const Ranges& ranges, int level, std::uint64_t block) {
    constexpr std::size_t width = formats::ClusterShape::width;
    const formats::BoxBlock& box = field_.boxes[level][block];
    HWY_ALIGN float near_of[width];
    std::uint64_t met = 0;
    const auto margin = hn::Set(eights, group_.tree_margin);
    const auto w = static_cast<std::size_t>(group_.w);
    for (std::size_t i = 0; i < width; i += hn::Lanes(eights)) {
      const VecE w_low =
          hn::Max(hn::LoadU(eights, box.lo[w].data() + i), hn::Sub(hn::Set(eights, group_.first), margin));
      const VecE w_high =
          hn::Min(hn::LoadU(eights, box.hi[w].data() + i), hn::Add(hn::Set(eights, group_.last), margin));
      auto in = hn::Le(w_low, w_high);
      for (int m = 0; m < 2; ++m) {
        const auto axis = static_cast<std::size_t>(m == 0 ? group_.u : group_.v);
        const VecE low = hn::LoadU(eights, box.lo[axis].data() + i), high = hn::LoadU(eights, box.hi[axis].data() + i);
        const auto bound = [&](int l) HWY_ATTR {
          const float slope = group_.group_slope[l];
          return hn::Add(margin, hn::MulAdd(hn::Set(eights, slope), slope > 0 ? w_high : w_low,
                                            hn::Set(eights, group_.group_offset[l])));
        };
        in = hn::And(in, hn::Ge(bound(2 * m), hn::Neg(high)));
        in = hn::And(in, hn::Ge(bound(2 * m + 1), low));
      }
      hn::Store(group_.is_down ? hn::Neg(w_high) : w_low, eights, near_of + i);
      met |= bits_of(eights, in) << i;
    }
    for (; met != 0; met &= met - 1) {
      const auto e = static_cast<std::size_t>(std::countr_zero(met));
      if (!(ranges.lo[e] <= ranges.hi[e])) continue;
      const auto entry = static_cast<std::uint32_t>(block * width + e);
      const double share = (static_cast<double>(ranges.hi[e]) - lowest_) * per_range_;
      put({static_cast<float>(share) + 0x1p-23f, near_of[e], entry, level});
    }
  }

  /// Returns the lanes whose rays may hit an entry's box and may find more in it than they have
  /// reached.
  HWY_INLINE std::uint64_t lanes_through(const TetRegion& region) const {
    constexpr std::size_t width = formats::ClusterShape::width;
    const formats::BoxBlock& box = field_.boxes[region.level][region.entry / width];
    const std::size_t e = region.entry % width;
    const auto w = static_cast<std::size_t>(group_.w);
    const VecF w_low = hn::Set(floats, box.lo[w][e]), w_high = hn::Set(floats, box.hi[w][e]);
    const VecF bound = hn::Set(floats, region.bound), margin = hn::Set(floats, group_.tree_margin);
    std::uint64_t lanes = 0;
    for (std::size_t r = 0; r < TetScratch::lanes; r += float_lanes) {
      MaskF in = hn::Le(hn::Load(floats, scratch_.reached_share + r), bound);
      in = hn::And(in, hn::Le(hn::Sub(hn::Load(floats, scratch_.tree_begin + r), margin), w_high));
      in = hn::And(in, hn::Ge(hn::Add(hn::Load(floats, scratch_.tree_end + r), margin), w_low));
      for (int m = 0; m < 2; ++m) {
        const auto axis = static_cast<std::size_t>(m == 0 ? group_.u : group_.v);
        const VecF slope = hn::Load(floats, scratch_.tree_slope[m] + r),
                   shift = hn::Load(floats, scratch_.tree_shift[m] + r);
        const VecF a = hn::MulAdd(slope, w_low, shift), b = hn::MulAdd(slope, w_high, shift);
        in = hn::And(in, hn::Ge(hn::Add(hn::Max(a, b), margin), hn::Set(floats, box.lo[axis][e])));
        in = hn::And(in, hn::Le(hn::Sub(hn::Min(a, b), margin), hn::Set(floats, box.hi[axis][e])));
      }
      lanes |= bits_of(floats, in) << r;
    }
    return lanes & group_.alive;
  }

  const TetMaximumField& field_;
  const TetRays& group_;
  TetScratch& scratch_;
  KernelCounters& counters_;
  TetCells cells_;
  double lowest_, per_range_;
};

std::uint64_t tet_largest_values(const TetMaximumField& field, const RayArrays& rays, std::size_t count,
                                 TetScratch& scratch, KernelCounters& counters) {
  for (std::size_t r = 0; r < TetScratch::lanes; ++r) scratch.found[r] = {}, scratch.cost[r] = 0;
  scratch.suspect_count = 0;
  const MainAxes axes = main_axes(field, rays, count);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool down : {false, true}) {
      const std::uint64_t chosen = axes.along[axis] & (down ? axes.down : ~axes.down);
      if (chosen == 0) continue;
      const TetRays group(field, rays, count, axis, down, in_lanes(chosen), scratch);
      TetSearch(field, rays, group, scratch, counters).run();
    }
  return axes.left_out;
}

}  // namespace
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

TetLargestValues tet_largest_values_on(Machine machine) {
  RHORAY_RETURN_ON(machine, tet_largest_values);
}

}  // namespace rhoray::render::wide

#endif

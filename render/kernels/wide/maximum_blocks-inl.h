// Rays through blocks of 4 x 4 x 4 cells, side by side in single precision.
#if defined(RHORAY_WIDE_MAXIMUM_BLOCKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_BLOCKS_INL_H
#undef RHORAY_WIDE_MAXIMUM_BLOCKS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_BLOCKS_INL_H
#endif

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/maximum_cubic-inl.h"
#include "render/kernels/wide/maximum_looks-inl.h"
#include "render/kernels/wide/maximum_samples-inl.h"
#include "render/kernels/wide/maximum_state-inl.h"
#include "render/kernels/wide/maximum_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Looks for cells on rays through a block whose cubics may hold a larger value than was found.
///
/// Places are counted from the block's corner: they are less than 32, and rounding moves them by less than `margin`.
/// Values are off by less than 12 margins of the block's range (3 for a place that is off on all axes, as much for a
/// part that goes on beyond its cell, the rest where the neighbouring cell is the true one), and 2^-20 of it for the
/// interpolation itself. A value is reached for certain where the place lies three margins inside a cell.
class BlockWalk {
 public:
  BlockWalk(SearchState& state, CloseLooks& looks)
      : state_(state), looks_(looks), field_(state.field), scratch_(state.scratch) {}

  HWY_NOINLINE void look_into(const int* block) {
    int place[3] = {};
    state_.find_in_file(block, true, field_.blocks, place);
    const Range range = range_of(field_, field_.blocks, place);
    const float largest = float_not_below(range.hi);
    RaysAtBlock& at_block = scratch_.at_block;
    at_block.count = 0;
    for (std::size_t r = 0; r < state_.vectors * float_lanes; r += float_lanes) {
      const SearchState::Passing passing = state_.rays_through(block, 4, largest, r);
      if (hn::AllFalse(floats, passing.rays)) continue;
      store_chosen(ints, hn::Iota(ints, static_cast<std::int32_t>(r)), hn::RebindMask(ints, passing.rays),
                   at_block.ray + at_block.count);
      store_chosen(floats, passing.from, passing.rays, at_block.from + at_block.count);
      at_block.count += store_chosen(floats, passing.to, passing.rays, at_block.to + at_block.count);
    }
    if (at_block.count == 0) return;
    // Lanes beyond the last ray pass through nothing.
    for (std::size_t lane = at_block.count; lane < at_block.count + float_lanes; ++lane)
      at_block.ray[lane] = at_block.ray[0], at_block.from[lane] = 1, at_block.to[lane] = 0;

    const double unit = unit_for(range.hi - range.lo, in_float(field_.type));
    fetch_of_type(field_, place, range.hi, unit, scratch_.block);
    scratch_.at_hand.count = 0;
    for (std::size_t first = 0; first < at_block.count; first += float_lanes) walk_block(block, range, unit, first);
    looks_.keep_suspects(range.hi, unit, 4.0 * block[state_.frustum.major]);
  }

 private:
  /// What rays have reached, in a block's unit: no more than it is, and below the block's largest value where that is
  /// not reached.
  HWY_INLINE VecF reached_in_block(double highest, double unit, std::size_t first) const {
    const RaysAtBlock& at_block = scratch_.at_block;
    const VecF least = hn::Set(floats, -8.0F);
    if (in_float(field_.type)) {
      const VecF reached = hn::GatherIndex(floats, scratch_.lines.reached, hn::Load(ints, at_block.ray + first));
      const VecF from = hn::Set(floats, static_cast<float>(highest));
      const VecF below = hn::Sub(reached, from);
      const VecF lower = hn::NegMulAdd(hn::Abs(below), hn::Set(floats, 0x1p-22F), below);
      const VecF safe = hn::IfThenElse(hn::Eq(hn::Add(below, from), reached), below, lower);
      return hn::Max(hn::Mul(safe, hn::Set(floats, static_cast<float>(unit))), least);
    }
    HWY_ALIGN float result[16];
    for (std::size_t lane = 0; lane < float_lanes; ++lane) {
      const double value = scratch_.reached[at_block.ray[first + lane]];
      const double below = value - highest, scaled = below * unit;
      result[lane] = -8;
      if (!(scaled > -8)) continue;
      result[lane] = float_not_above(scaled);
      if (below + highest != value) result[lane] -= 0x1p-22F * (result[lane] < 0 ? -result[lane] : result[lane]);
    }
    return hn::Load(floats, result);
  }

  static constexpr float margin = 0x1p-18F;  ///< more than places from the block's corner are off

  /// Where rays are on a minor axis where a block begins, from its corner.
  HWY_INLINE VecF start_in_box(int m, std::size_t first, double low_w, double low) const {
    constexpr hn::RebindToSigned<Doubles> longs;
    HWY_ALIGN float start[float_lanes];
    for (std::size_t lane = 0; lane < float_lanes; lane += double_lanes) {
      const auto ray = hn::PromoteTo(longs, hn::LoadU(half_ints, scratch_.at_block.ray + first + lane));
      const VecD at_zero = hn::GatherIndex(doubles, scratch_.lines.exact_start[m], ray),
                 slope = hn::GatherIndex(doubles, scratch_.lines.exact_slope[m], ray);
      const VecD at_low = hn::MulAdd(slope, hn::Set(doubles, low_w), at_zero);
      hn::Store(hn::DemoteTo(half_floats, hn::Sub(at_low, hn::Set(doubles, low))), half_floats, start + lane);
    }
    return hn::Load(floats, start);
  }

  /// The samples of a block, in which a cell is where its lowest sample is.
  struct Cells {
    static constexpr float lowest = -4;  ///< less than any value with data

    const float* samples;
    const float* largest;
    std::int32_t stride_w, stride_u, stride_v;

    HWY_INLINE VecF bound(VecI cell) const { return hn::GatherIndex(floats, largest, cell); }
    HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
      VecF f[8];
      for (int c = 0; c < 8; ++c)
        f[c] =
            hn::GatherIndex(floats, samples + (c & 1) * stride_u + (c >> 1 & 1) * stride_v + (c >> 2) * stride_w, cell);
      return HWY_NAMESPACE::coefficients(f, p, q);
    }
  };

  /// The cells of a block along some rays.
  HWY_NOINLINE void walk_block(const int* block, const Range& range, double unit, std::size_t first) {
    const RaysAtBlock& at_block = scratch_.at_block;
    const GroupLines& lines = scratch_.lines;
    const int axes[3] = {state_.frustum.major, state_.frustum.minor[0], state_.frustum.minor[1]};
    CellBox box{.low_w = 4.0 * block[axes[0]],
                .last = {3, 3, 3},
                .first = 0,
                .stride = {},
                .highest = range.hi,
                .unit = unit,
                .error = static_cast<float>((range.hi - range.lo) * unit) * (12 * margin + 0x1p-20F),
                .margin = margin};
    // Mirrored axes are read backwards.
    std::int32_t lowest_sample = 0, lowest_cell = 0;
    for (int i = 0; i < 3; ++i) {
      constexpr std::int32_t step[3] = {1, 5, 25};
      const bool is_mirrored = state_.lattice.is_mirrored(axes[i]);
      box.stride[i] = is_mirrored ? -step[axes[i]] : step[axes[i]];
      if (is_mirrored) lowest_sample += 4 * step[axes[i]], lowest_cell += 3 * step[axes[i]];
    }
    const Cells cells{scratch_.block.sample + lowest_sample, scratch_.block.largest + lowest_cell, box.stride[0],
                      box.stride[1], box.stride[2]};

    const VecF low_w = hn::Set(floats, static_cast<float>(4 * block[axes[0]]));
    Ways ways;
    ways.ray = hn::Load(ints, at_block.ray + first);
    ways.from = hn::Sub(hn::Load(floats, at_block.from + first), low_w);
    ways.to = hn::Sub(hn::Load(floats, at_block.to + first), low_w);
    for (int m = 0; m < 2; ++m) {
      ways.slope[m] = hn::GatherIndex(floats, lines.slope[m], ways.ray);
      ways.inverse[m] = hn::GatherIndex(floats, lines.inverse[m], ways.ray);
      ways.start[m] = start_in_box(m, first, box.low_w, 4.0 * block[axes[m + 1]]);
    }
    ways.reached = reached_in_block(range.hi, unit, first);
    ways.reached_at =
        hn::Add(hn::Sub(hn::GatherIndex(floats, lines.reached_at, ways.ray), low_w), hn::Set(floats, state_.margin));
    const VecF passed = walk_cells(state_, looks_, box, cells, ways);
    count_cells(state_, passed, at_block.ray + first, at_block.count - first);
  }

  SearchState& state_;
  CloseLooks& looks_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

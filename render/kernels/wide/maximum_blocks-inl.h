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

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Looks for cells on rays through a block whose cubics may hold a larger value than was found.
///
/// Values in a block are off by less than 12 margins of its range (3 for a place that is off on all axes, as much for a
/// part that goes on beyond its cell, the rest where the neighbouring cell is the true one), and 2^-20 of it for the
/// interpolation itself. A value is reached for certain where the place lies three margins inside a cell.
class BlockWalk {
 public:
  BlockWalk(SearchState& state, CloseLooks& looks)
      : state_(state), looks_(looks), field_(state.field), scratch_(state.scratch) {}

  /// Rays of a vector that pass a region and can be changed by it.
  struct Passing {
    MaskF rays;
    VecF from, to;
  };
  HWY_INLINE Passing rays_through(const int* region, float edge, float largest, std::size_t r) const {
    const GroupLines& lines = scratch_.lines;
    const float low_w = static_cast<float>(region[state_.frustum.major]) * edge;
    Passing passing;
    passing.from = hn::Max(hn::Load(floats, lines.from + r), hn::Set(floats, low_w - state_.margin));
    passing.to = hn::Min(hn::Load(floats, lines.to + r), hn::Set(floats, low_w + edge + state_.margin));
    for (int m = 0; m < 2; ++m) {
      const float low = static_cast<float>(region[state_.frustum.minor[m]]) * edge;
      const VecF start = hn::Load(floats, lines.start[m] + r), inverse = hn::Load(floats, lines.inverse[m] + r);
      passing.from = hn::Max(passing.from, hn::Mul(hn::Sub(hn::Set(floats, low - state_.margin), start), inverse));
      passing.to = hn::Min(passing.to, hn::Mul(hn::Sub(hn::Set(floats, low + edge + state_.margin), start), inverse));
    }
    passing.rays =
        hn::And(hn::Le(passing.from, passing.to),
                SearchState::may_improve(hn::Set(floats, largest), passing.from, hn::Load(floats, lines.reached + r),
                                         hn::Load(floats, lines.reached_at + r)));
    return passing;
  }

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
      hn::CompressStore(hn::Iota(ints, static_cast<std::int32_t>(r)), hn::RebindMask(ints, passing.rays), ints,
                        at_block.ray + at_block.count);
      hn::CompressStore(passing.from, passing.rays, floats, at_block.from + at_block.count);
      at_block.count += hn::CompressStore(passing.to, passing.rays, floats, at_block.to + at_block.count);
    }
    if (at_block.count == 0) return;
    // Lanes beyond the last ray pass through nothing.
    for (std::size_t lane = at_block.count; lane < at_block.count + float_lanes; ++lane)
      at_block.ray[lane] = at_block.ray[0], at_block.from[lane] = 1, at_block.to[lane] = 0;

    const double unit = unit_for(range.hi - range.lo, in_float(field_.type));
    fetch_of_type(field_, place, range.hi, unit, scratch_.block);
    const float error = static_cast<float>((range.hi - range.lo) * unit) * (12 * state_.margin + 0x1p-20F);
    scratch_.at_hand.count = 0;
    for (std::size_t first = 0; first < at_block.count; first += float_lanes)
      walk_block(block, range.hi, unit, error, first);
    looks_.keep_suspects(range.hi, unit);
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

  /// The cells of a block along some rays.
  HWY_NOINLINE void walk_block(const int* block, double highest, double unit, float error_float, std::size_t first) {
    const RaysAtBlock& at_block = scratch_.at_block;
    const GroupLines& lines = scratch_.lines;
    BlockSuspects& at_hand = scratch_.at_hand;
    const int w = state_.frustum.major, u = state_.frustum.minor[0], v = state_.frustum.minor[1];
    VecF reached = reached_in_block(highest, unit, first);

    const VecF one = hn::Set(floats, 1.0F), three = hn::Set(floats, 3.0F), zero = hn::Zero(floats);
    const VecF never = hn::Set(floats, std::numeric_limits<float>::infinity());
    const VecF error = hn::Set(floats, error_float);
    const VecI ray = hn::Load(ints, at_block.ray + first);
    VecF reached_at = hn::GatherIndex(floats, lines.reached_at, ray);
    VecF from = hn::Load(floats, at_block.from + first);
    const VecF to = hn::Load(floats, at_block.to + first);
    const VecF low_w = hn::Set(floats, static_cast<float>(4 * block[w]));
    const VecF low_u = hn::Set(floats, static_cast<float>(4 * block[u]));
    const VecF low_v = hn::Set(floats, static_cast<float>(4 * block[v]));
    const VecF start_u = hn::Sub(hn::GatherIndex(floats, lines.start[0], ray), low_u);
    const VecF start_v = hn::Sub(hn::GatherIndex(floats, lines.start[1], ray), low_v);
    const VecF slope_u = hn::GatherIndex(floats, lines.slope[0], ray);
    const VecF slope_v = hn::GatherIndex(floats, lines.slope[1], ray);
    const VecF inverse_u = hn::GatherIndex(floats, lines.inverse[0], ray);
    const VecF inverse_v = hn::GatherIndex(floats, lines.inverse[1], ray);

    // Mirrored axes are read backwards.
    const int step[3] = {1, 5, 25};
    std::int32_t stride[3], lowest_sample = 0, lowest_cell = 0;
    for (int a = 0; a < 3; ++a) {
      const bool is_mirrored = state_.lattice.is_mirrored(a);
      stride[a] = is_mirrored ? -step[a] : step[a];
      if (is_mirrored) lowest_sample += 4 * step[a], lowest_cell += 3 * step[a];
    }
    const float* samples = scratch_.block.sample + lowest_sample;
    const float* largest = scratch_.block.largest + lowest_cell;
    const VecI stride_w = hn::Set(ints, stride[w]), stride_u = hn::Set(ints, stride[u]),
               stride_v = hn::Set(ints, stride[v]);

    const auto clamped = [&](VecF x) HWY_ATTR { return hn::Min(hn::Max(hn::Floor(x), zero), three); };
    VecF p_w = hn::Sub(from, low_w), p_u = hn::MulAdd(slope_u, from, start_u), p_v = hn::MulAdd(slope_v, from, start_v);
    VecF cell_w = clamped(p_w), cell_u = clamped(p_u), cell_v = clamped(p_v);
    p_w = hn::Sub(p_w, cell_w), p_u = hn::Sub(p_u, cell_u), p_v = hn::Sub(p_v, cell_v);
    VecI cell =
        hn::Add(hn::Add(hn::Mul(hn::ConvertTo(ints, cell_w), stride_w), hn::Mul(hn::ConvertTo(ints, cell_u), stride_u)),
                hn::Mul(hn::ConvertTo(ints, cell_v), stride_v));
    const auto next = [&](VecF c, VecF at) HWY_ATTR { return hn::IfThenElse(hn::Lt(c, three), at, never); };
    VecF next_w = next(cell_w, hn::Add(hn::Add(low_w, cell_w), one));
    VecF next_u = next(cell_u, hn::Mul(hn::Sub(hn::Add(cell_u, one), start_u), inverse_u));
    VecF next_v = next(cell_v, hn::Mul(hn::Sub(hn::Add(cell_v, one), start_v), inverse_v));

    MaskF active = hn::Le(from, to), raised = hn::Lt(zero, zero);
    VecF cells = hn::Zero(floats);
    for (;;) {
      const VecF leave = hn::Min(hn::Min(next_w, to), hn::Min(next_u, next_v));
      const VecF q_w = hn::Sub(hn::Sub(leave, low_w), cell_w),
                 q_u = hn::Sub(hn::MulAdd(slope_u, leave, start_u), cell_u),
                 q_v = hn::Sub(hn::MulAdd(slope_v, leave, start_v), cell_v);
      const VecF bound = hn::Add(hn::GatherIndex(floats, largest, cell), error);
      const MaskF wanted = hn::And(active, SearchState::may_improve(bound, from, reached, reached_at));
      cells = hn::Add(cells, hn::IfThenElseZero(active, one));
      if (!hn::AllFalse(floats, wanted)) {
        const Coefficients b =
            coefficients(samples, stride[u], stride[v], stride[w], cell, {p_u, p_v, p_w}, {q_u, q_v, q_w});
        // Without data all coefficients are no numbers, or far below the block's values.
        const VecF hull = b.largest();
        const VecF highest_here = hn::Add(hn::IfThenElseZero(hn::Ge(hull, hn::Set(floats, -4.0F)), hull), error);
        const MaskF suspect = hn::And(wanted, SearchState::may_improve(highest_here, from, reached, reached_at));
        if (!hn::AllFalse(floats, suspect)) {
          hn::CompressStore(ray, hn::RebindMask(ints, suspect), ints, at_hand.ray + at_hand.count);
          hn::CompressStore(from, suspect, floats, at_hand.from + at_hand.count);
          hn::CompressStore(leave, suspect, floats, at_hand.to + at_hand.count);
          at_hand.count += hn::CompressStore(highest_here, suspect, floats, at_hand.bound + at_hand.count);

          // A value that is reached for certain: at a point well inside the cell and well inside the ray.
          const VecF s = b.likely_maximum();
          const MaskF inside = hn::And(
              hn::And(is_inside(p_u, q_u, s), is_inside(p_v, q_v, s)),
              hn::And(is_inside(p_w, q_w, s), hn::Ge(hn::Sub(leave, from), hn::Set(floats, 128 * state_.margin))));
          const VecF value = hn::Sub(b.at(s), error);
          const MaskF has_data =
              hn::Le(hn::Abs(hn::Add(hn::Add(b.b0, b.b1), hn::Add(b.b2, b.b3))), hn::Set(floats, 16.0F));
          const MaskF rises = hn::And(hn::And(suspect, has_data), hn::And(inside, hn::Gt(value, reached)));
          reached = hn::IfThenElse(rises, value, reached);
          const VecF place = hn::MulAdd(s, hn::Sub(leave, from), from);
          reached_at = hn::IfThenElse(rises, hn::Add(place, hn::Set(floats, state_.margin)), reached_at);
          raised = hn::Or(raised, rises);
        }
      }
      active = hn::And(active, hn::Lt(leave, to));
      if (hn::AllFalse(floats, active)) break;
      const VecF step_w = hn::IfThenElseZero(hn::Le(next_w, leave), one),
                 step_u = hn::IfThenElseZero(hn::Le(next_u, leave), one),
                 step_v = hn::IfThenElseZero(hn::Le(next_v, leave), one);
      cell = hn::Add(cell, hn::Add(hn::IfThenElseZero(hn::RebindMask(ints, hn::Le(next_w, leave)), stride_w),
                                   hn::Add(hn::IfThenElseZero(hn::RebindMask(ints, hn::Le(next_u, leave)), stride_u),
                                           hn::IfThenElseZero(hn::RebindMask(ints, hn::Le(next_v, leave)), stride_v))));
      cell_w = hn::Add(cell_w, step_w), cell_u = hn::Add(cell_u, step_u), cell_v = hn::Add(cell_v, step_v);
      p_w = hn::Sub(q_w, step_w), p_u = hn::Sub(q_u, step_u), p_v = hn::Sub(q_v, step_v);
      next_w = next(cell_w, hn::Add(hn::Add(low_w, cell_w), one));
      next_u = next(cell_u, hn::Mul(hn::Sub(hn::Add(cell_u, one), start_u), inverse_u));
      next_v = next(cell_v, hn::Mul(hn::Sub(hn::Add(cell_v, one), start_v), inverse_v));
      from = leave;
    }
    count_cells(cells, first);
    if (!hn::AllFalse(floats, raised)) raise(raised, reached, reached_at, highest, unit, first);
  }

  HWY_INLINE MaskF is_inside(VecF p, VecF q, VecF s) const {
    const VecF half = hn::Set(floats, 0.5F);
    return hn::Le(hn::Abs(hn::Sub(hn::MulAdd(s, hn::Sub(q, p), p), half)), hn::Set(floats, 0.5F - 3 * state_.margin));
  }

  HWY_INLINE void count_cells(VecF cells, std::size_t first) {
    HWY_ALIGN float counted[16];
    hn::Store(cells, floats, counted);
    const RaysAtBlock& at_block = scratch_.at_block;
    const std::size_t rays = at_block.count - first < float_lanes ? at_block.count - first : float_lanes;
    for (std::size_t lane = 0; lane < rays; ++lane)
      scratch_.cost[scratch_.group.index[at_block.ray[first + lane]]] += 1 + static_cast<std::uint32_t>(counted[lane]);
  }

  /// Takes over what rays have reached in a block.
  HWY_INLINE void raise(MaskF raised, VecF reached, VecF reached_at, double highest, double unit, std::size_t first) {
    HWY_ALIGN float values[16], places[16];
    hn::Store(reached, floats, values);
    hn::Store(reached_at, floats, places);
    for (std::uint64_t bits = bits_of(floats, raised); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      // Single precision has lost more than this rounding: the error holds for both.
      const double value = highest + static_cast<double>(values[lane]) / unit;
      state_.set_reached(static_cast<std::size_t>(scratch_.at_block.ray[first + static_cast<std::size_t>(lane)]), value,
                         places[lane]);
    }
    state_.find_lowest_reached();
  }

  SearchState& state_;
  CloseLooks& looks_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

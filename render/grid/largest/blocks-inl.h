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

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "render/grid/largest/candidates-inl.h"
#include "render/grid/largest/columns-inl.h"
#include "render/grid/largest/cubic-inl.h"
#include "render/grid/largest/samples-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/grid/largest/walk-inl.h"
#include "render/grid/largest/words-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Finds cells on rays through a block whose cubics may hold a larger value than was found.
///
/// Positions are relative to the block's corner: they are less than 32, and rounding moves them by
/// less than `margin`. Values are off by less than 12 margins of the block's range: 3 for a
/// position that is off on all axes, as much for a part that extends beyond its cell, the rest
/// where the neighbouring cell is the true one. The interpolation itself adds 2^-20 of the range. A
/// value is certainly reached where the position lies three margins inside a cell.
class BlockWalk {
 public:
  BlockWalk(SearchState& state, CandidateRefinement& looks)
      : state_(state), looks_(looks), field_(state.field), scratch_(state.scratch), order_(order_of(state)) {
#if RHORAY_HAS_WORD_TABLES
    planes_ = PlanePlaces(order_.lowest_sample, order_.stride);
#endif
    using formats::ElementType;
    const ElementType type = field_.type;
    may_use_words_ =
        field_.has_squares && !field_.has_gaps &&
        (type == ElementType::U8 || type == ElementType::I8 || type == ElementType::U16 || type == ElementType::I16);
  }

  HWY_NOINLINE void look_into(const int* block) {
    int place[3] = {};
    state_.find_in_file(block, true, field_.blocks, place);
    const Range range = range_of(field_, field_.blocks, place);
    const std::uint64_t vectors = state_.vectors_through(block, 4, float_not_below(range.hi));
    if (vectors == 0) return;
    scratch_.at_block.count = 0;
#if RHORAY_HAS_WORD_TABLES
    if (has_words(place)) {
      // Done first, because it takes a while and finding the rays does not depend on it.
      const WordTable cells = find_words(place, range.hi);
      const Columns columns(cells, planes_);
      const CellBox box = box_of(block, range, 1, cells);
      const VecF error = hn::Set(floats, box.error);
      put_rays(block, vectors, range.hi, 1, 2 * WordTable::lowest,
               [&](const SearchState::PartsInBox& parts, VecF reached) HWY_ATTR {
                 return hn::Ge(hn::Add(columns.largest_on(parts.from, parts.to, parts.start, parts.slope), error),
                               reached);
               });
      return walk_block(box, cells);
    }
#endif
    const double unit = unit_for(range.hi - range.lo, in_float(field_.type));
    put_rays(block, vectors, range.hi, unit, 2 * Cells::lowest,
             [](const SearchState::PartsInBox&, VecF) HWY_ATTR { return hn::FirstN(floats, float_lanes); });
    if (scratch_.at_block.count == 0) return;
    const Cells cells = find_cells(place, range.hi, unit);
    walk_block(box_of(block, range, unit, cells), cells);
  }

  /// Prefetches a block's range and, where samples lie in squares, its samples.
  HWY_INLINE void ask_for(const int* block) const {
    int place[3];
    if (!state_.find_in_file(block, true, field_.blocks, place)) return;
    hwy::Prefetch(static_cast<const char*>(field_.blocks.first) +
                  2 * field_.sample_bytes * place_of(field_.blocks, place));
    if (!has_words(place)) return;
    const SampleSource& source = field_.source;
    const std::size_t size = field_.sample_bytes;
    const SquarePlaces at(source, place);
    for (const int z : {0, 2, 4}) {
      const char* here = static_cast<const char*>(source.samples) + size * layer_address(source, place, z);
      hwy::Prefetch(here + size * (at.near[0] + at.near[1]));
      hwy::Prefetch(here + size * (at.far[0] + at.near[1]));
      hwy::Prefetch(here + size * (at.near[0] + at.far[1]));
      hwy::Prefetch(here + size * (at.far[0] + at.far[1]));
    }
  }

 private:
  /// True for blocks whose samples can be read as squares of words; blocks in which the lattice
  /// ends need four samples.
  HWY_INLINE bool has_words(const int* place) const {
    bool is_whole = may_use_words_;
    for (int a = 0; a < 2; ++a) is_whole = is_whole && 4 * place[a] + 4 <= field_.source.count[a];
    return is_whole;
  }

  /// Adds those rays of some vectors that pass a block and that it may change.
  /// @param least       less than any value of the block, in its unit
  /// @param may_change  may_change(parts in the block, what was reached in its unit): returns which
  ///                    lanes
  template <class MayChange>
  HWY_INLINE void put_rays(const int* block, std::uint64_t vectors, double highest, double unit, float least,
                           const MayChange& may_change) const {
    const double low[3] = {4.0 * block[0], 4.0 * block[1], 4.0 * block[2]};
    const SearchState::Bounds bounds = state_.bounds_of(block, 4, float_not_below(highest));
    for (std::uint64_t bits = vectors; bits != 0; bits &= bits - 1) {
      const std::size_t r = static_cast<std::size_t>(std::countr_zero(bits)) * float_lanes;
      const SearchState::Passing passing = state_.rays_through(bounds, r);
      if (hn::AllFalse(floats, passing.rays)) continue;
      const SearchState::PartsInBox parts = state_.parts_in_box(r, passing.from, passing.to, low);
      const VecF reached = reached_in_block(highest, unit, least, r);
      const MaskF chosen = hn::And(passing.rays, may_change(parts, reached));
      constexpr float last[3] = {3, 3, 3};
      state_.count_cells(r, chosen, parts, last);
      // Also without rays: a branch would be unpredictable.
      state_.put_at_box(r, chosen, parts, low[state_.frustum.major], reached);
    }
    if (scratch_.at_block.count != 0) state_.close_box();
  }

  /// What the rays of a vector have reached, in a block's unit: no more than the true value, and
  /// below the block's largest value where that is not reached.
  /// @param least  less than any value of the block, in its unit
  HWY_INLINE VecF reached_in_block(double highest, double unit, float least, std::size_t r) const {
    if (in_float(field_.type)) {
      const VecF reached = hn::Load(floats, scratch_.lines.reached + r);
      const VecF from = hn::Set(floats, static_cast<float>(highest));
      const VecF below = hn::Sub(reached, from);
      const VecF lower = hn::NegMulAdd(hn::Abs(below), hn::Set(floats, 0x1p-22F), below);
      const VecF safe = hn::IfThenElse(hn::Eq(hn::Add(below, from), reached), below, lower);
      return hn::Max(hn::Mul(safe, hn::Set(floats, static_cast<float>(unit))), hn::Set(floats, least));
    }
    HWY_ALIGN float result[16];
    for (std::size_t lane = 0; lane < float_lanes; ++lane) {
      const double value = scratch_.reached[r + lane];
      const double below = value - highest, scaled = below * unit;
      result[lane] = least;
      if (!(scaled > static_cast<double>(least))) continue;
      result[lane] = float_not_above(scaled);
      if (below + highest != value) result[lane] -= 0x1p-22F * (result[lane] < 0 ? -result[lane] : result[lane]);
    }
    return hn::Load(floats, result);
  }

  /// More than positions from the block's corner are off.
  static constexpr float margin = 0x1p-18F;

  /// Strides of samples (x, y, z), stored at x + 5 y + 25 z, along the axes w, u, v of the mirrored
  /// lattice.
  struct Order {
    std::int32_t stride[3];
    std::int32_t lowest_sample = 0, lowest_cell = 0;  ///< index of the lowest corner and cell
  };

  /// Mirrored axes are read backwards.
  HWY_INLINE static Order order_of(const SearchState& state) {
    const int axes[3] = {state.frustum.major, state.frustum.minor[0], state.frustum.minor[1]};
    Order order;
    for (int i = 0; i < 3; ++i) {
      constexpr std::int32_t step[3] = {1, 5, 25};
      const bool is_mirrored = state.lattice.is_mirrored(axes[i]);
      order.stride[i] = is_mirrored ? -step[axes[i]] : step[axes[i]];
      if (is_mirrored) order.lowest_sample += 4 * step[axes[i]], order.lowest_cell += 3 * step[axes[i]];
    }
    return order;
  }

  /// The samples of a block; a cell's index is that of its lowest sample.
  struct Cells {
    static constexpr bool is_plain = false, is_below = false;
    static constexpr float lowest = -4;  ///< less than any value with data

    const float* samples;
    const float* largest;
    std::int32_t first, stride[3];

    HWY_INLINE VecF bound(VecI cell) const { return hn::GatherIndex(floats, largest, cell); }
    HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
      VecF f[8];
      for (int c = 0; c < 8; ++c)
        f[c] = hn::GatherIndex(floats, samples + (c & 1) * stride[1] + (c >> 1 & 1) * stride[2] + (c >> 2) * stride[0],
                               cell);
      return HWY_NAMESPACE::coefficients(f, p, q);
    }
  };

  HWY_INLINE Cells find_cells(const int* place, double highest, double unit) const {
    fetch_of_type(field_, place, highest, unit, scratch_.block);
    return {.samples = scratch_.block.sample + order_.lowest_sample,
            .largest = scratch_.block.largest + order_.lowest_cell,
            .first = 0,
            .stride = {order_.stride[0], order_.stride[1], order_.stride[2]}};
  }

#if RHORAY_HAS_WORD_TABLES
  HWY_INLINE WordTable find_words(const int* place, double highest) const {
    using formats::ElementType;
    WordTable table;
    table.first = WordTable::both * order_.lowest_sample + 0x10000 * order_.stride[1];
    for (int i = 0; i < 3; ++i) table.stride[i] = WordTable::both * order_.stride[i];
    switch (field_.type) {
      case ElementType::U8:
        fetch_words<std::uint8_t>(field_.source, place, highest, table);
        break;
      case ElementType::I8:
        fetch_words<std::int8_t>(field_.source, place, highest, table);
        break;
      case ElementType::U16:
        fetch_words<std::uint16_t>(field_.source, place, highest, table);
        break;
      default:
        fetch_words<std::int16_t>(field_.source, place, highest, table);
    }
    return table;
  }
#endif

  template <class AnyCells>
  HWY_INLINE CellBox box_of(const int* block, const Range& range, double unit, const AnyCells& cells) const {
    return {.low_w = 4.0 * block[state_.frustum.major],
            .last = {3, 3, 3},
            .first = cells.first,
            .stride = {cells.stride[0], cells.stride[1], cells.stride[2]},
            .highest = range.hi,
            .unit = unit,
            .error = static_cast<float>((range.hi - range.lo) * unit) * (12 * margin + 0x1p-20F),
            .margin = margin,
            .is_come_to = state_.is_come_to(4.0 * block[state_.frustum.major])};
  }

  /// Walks the cells of a block along the rays at it.
  template <class AnyCells>
  HWY_NOINLINE void walk_block(const CellBox& box, const AnyCells& cells) {
    const RaysAtBlock& at_block = scratch_.at_block;
    if (at_block.count != 0) looks_.open_box(box.highest, box.unit, box.low_w);
    for (std::size_t first = 0; first < at_block.count; first += float_lanes) {
      Ways ways = ways_at_box(at_block, first);
      const std::size_t rays = at_block.count - first;
      const Spread& spread = spreads[rays < float_lanes ? rays : float_lanes];
      spread_out(spread, ways);
      walk_cells(state_, looks_, box, cells, ways);
    }
  }

  SearchState& state_;
  CandidateRefinement& looks_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
  Order order_;
#if RHORAY_HAS_WORD_TABLES
  PlanePlaces planes_;
#endif
  bool may_use_words_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

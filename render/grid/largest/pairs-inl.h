// Two vectors of rays at a time at a slab of blocks: which cells they pass, and the window of
// samples around them.
#if defined(RHORAY_WIDE_MAXIMUM_PAIRS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_PAIRS_INL_H
#undef RHORAY_WIDE_MAXIMUM_PAIRS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_PAIRS_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/largest/layers-inl.h"
#include "render/grid/largest/parts.h"
#include "render/grid/largest/planes-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

/// Two vectors of rays at a slab.
struct SlabPair {
  std::size_t vector, second;              ///< equal where there is only one
  std::uint32_t rays;                      ///< rays that the slab may change
  int first[2], last[2];                   ///< cells on the minor axes
  std::int32_t lowest, highest;            ///< lowest and highest sample
  std::uint32_t may[LayerValues::layers];  ///< rays for which a layer must be walked
};

/// The surroundings of some pairs.
struct SlabPart {
  int first[2], last[2];  ///< cells on the minor axes
  PlaneWindow window;
  bool is_at_end;  ///< contains the lattice's last cells on an axis
};

HWY_INLINE WordScale scale_of(const SlabPair* pair, std::size_t count) {
  std::int32_t lowest = pair[0].lowest, highest = pair[0].highest;
  for (std::size_t i = 1; i < count; ++i) {
    lowest = pair[i].lowest < lowest ? pair[i].lowest : lowest;
    highest = pair[i].highest > highest ? pair[i].highest : highest;
  }
  return {lowest, highest};
}

/// The samples of a window that a pair's rays pass: of a narrow window eight rows of eight, eight
/// of sixteen, or all.
/// @param vectors  number of vectors that hold them; 0 for a wide window
HWY_INLINE RowsOfWindow rows_of(const SlabPair& pair, const SlabPart& part, int& vectors) {
  const bool is_narrow = part.window.is_narrow();
  const int edge = part.window.edge(), half = PlaneWindow::narrow / 2;
  const auto first_of = [&](int m, int multiple) {
    const int first = (pair.first[m] - part.window.first[m]) & -multiple, samples = 4 * part.window.bricks[m];
    return first > samples - half ? (samples > half ? samples - half : 0) : first;
  };
  const auto fits = [&](int m, int first) { return pair.last[m] + 1 - part.window.first[m] - first < half; };
  int column = first_of(0, 1), row = first_of(1, 2);
  vectors = 2;
  if (!fits(0, column)) vectors = 4, column = 0;
  if (!fits(1, row)) vectors = 8, column = 0, row = 0;
  if (!is_narrow) vectors = 0, column = 0, row = 0;
  RowsOfWindow rows;
  rows.first_word = static_cast<std::size_t>(row * edge);
  rows.first_column = static_cast<std::uint16_t>(column);
  for (int m = 0; m < 2; ++m) {
    const int first = part.window.first[m] + (m == 0 ? column : row), cells = part.last[m] + 1 - first;
    rows.low[m] = first;
    rows.cells[m] = cells < edge ? cells : edge;
  }
  rows.is_at_end = part.is_at_end;
  return rows;
}

/// What a pair's rays meet at a slab.
/// @param low_w     where it begins on the major axis
/// @param has_rise  what rays gain in planes is known
/// @param clear     as in values_between
HWY_INLINE LayerValues values_of(const SlabPair& pair, const SlabPart& part, const LineParts& lines, double low_w,
                                 const MaximumPlanes& planes, bool has_rise, int clear) {
  int vectors;
  const RowsOfWindow rows = rows_of(pair, part, vectors);
  const auto find = [&]<class AnyRows>() HWY_ATTR {
    return values_between<AnyRows>(lines, pair.vector, pair.second, low_w, planes, rows, clear);
  };
  const auto find_in_rows = [&]<bool knows_rise>() HWY_ATTR {
    return vectors == 2   ? find.template operator()<Rows<2, knows_rise>>()
           : vectors == 4 ? find.template operator()<Rows<4, knows_rise>>()
                          : find.template operator()<Rows<8, knows_rise>>();
  };
  return vectors == 0 ? find.template operator()<WideRows>()
         : has_rise   ? find_in_rows.template operator()<true>()
                      : find_in_rows.template operator()<false>();
}

/// The pairs of a search at one slab.
class PairsAtSlab {
 public:
  static constexpr std::size_t most = SearchedRays::size / float_lanes / 2;
  static_assert(2 * most <= float_lanes);

  /// @param axes  the major one and the minor ones
  PairsAtSlab(const SearchState& state, const int* axes) : state_(state), axes_{axes[0], axes[1], axes[2]} {}

  /// Finds the cells that the rays of each vector may pass in a slab, on the minor axes; where they
  /// pass none, the first is behind the last.
  HWY_INLINE void move_to(int slab) {
    const VectorLines& around = state_.scratch.around;
    const auto low_w = static_cast<float>(4 * slab);
    const auto first = static_cast<float>(state_.frustum.first), last = static_cast<float>(state_.frustum.last);
    const VecF near = hn::Set(floats, low_w > first ? low_w : first),
               far = hn::Set(floats, low_w + 4 < last ? low_w + 4 : last);
    const VecF beside = hn::Set(floats, 8 * state_.margin);
    const MaskF used = hn::FirstN(floats, state_.vectors);
    for (int m = 0; m < 2; ++m) {
      const int a = axes_[1 + m];
      const int lowest =
          state_.lattice.is_mirrored(a) ? static_cast<int>(state_.lattice.plane(a, state_.field.leaf_count[a])) : 0;
      end_[m] = lowest + state_.field.leaf_count[a] - 1;
      const VecF least = hn::Set(floats, static_cast<float>(lowest)),
                 most = hn::Set(floats, static_cast<float>(end_[m]));
      const auto cell_at = [&](VecF place, VecF otherwise) HWY_ATTR {
        return hn::ConvertTo(ints, hn::IfThenElse(used, hn::Min(hn::Max(place, least), most), otherwise));
      };
      const VecF low = hn::MulAdd(hn::Load(floats, around.low_slope[m]), near, hn::Load(floats, around.low[m]));
      const VecF high = hn::MulAdd(hn::Load(floats, around.high_slope[m]), far, hn::Load(floats, around.high[m]));
      hn::Store(cell_at(hn::Sub(low, beside), most), ints, first_cell_[m]);
      hn::Store(cell_at(hn::Add(high, beside), least), ints, last_cell_[m]);
    }
  }

  HWY_INLINE SlabPair pair_of(std::size_t vector, std::size_t second) const {
    SlabPair pair;
    pair.vector = vector, pair.second = second;
    for (int m = 0; m < 2; ++m) {
      const std::int32_t *first = first_cell_[m], *last = last_cell_[m];
      pair.first[m] = first[vector] < first[second] ? first[vector] : first[second];
      pair.last[m] = last[vector] > last[second] ? last[vector] : last[second];
    }
    return pair;
  }

  /// Shrinks a pair's cells to those that some of its rays may pass.
  HWY_INLINE void shrink_to(std::uint32_t rays, int slab, SlabPair& pair) const {
    const GroupLines& lines = state_.scratch.lines;
    const VecF low_w = hn::Set(floats, static_cast<float>(4 * slab)), edge = hn::Set(floats, 4.0F);
    const MaskF near{static_cast<__mmask16>(rays)}, far{static_cast<__mmask16>(rays >> 16)};
    const VecF highest = hn::Set(floats, 0x1p20F), beside = hn::Set(floats, 8 * state_.margin);
    for (int m = 0; m < 2; ++m) {
      VecF least = highest, most = hn::Neg(highest);
      const auto add = [&](std::size_t vector, MaskF chosen) HWY_ATTR {
        const std::size_t r = vector * float_lanes;
        const VecF slope = hn::Load(floats, lines.slope[m] + r);
        const VecF low = hn::MulAdd(slope, low_w, hn::Load(floats, lines.start[m] + r));
        least = hn::IfThenElse(chosen, hn::Min(least, low), least);
        most = hn::IfThenElse(chosen, hn::Max(most, hn::MulAdd(slope, edge, low)), most);
      };
      add(pair.vector, near);
      if (pair.second != pair.vector) add(pair.second, far);
      const int first = static_cast<int>(hn::GetLane(hn::MinOfLanes(floats, hn::Sub(least, beside))));
      const int last = static_cast<int>(hn::GetLane(hn::MaxOfLanes(floats, hn::Add(most, beside))));
      pair.first[m] = first > pair.first[m] ? first : pair.first[m];
      pair.last[m] = last < pair.last[m] ? last : pair.last[m];
    }
  }

  /// One of a pair's vectors.
  HWY_INLINE SlabPair half_of(const SlabPair& pair, bool is_second) const {
    const int shift = is_second ? 16 : 0;
    const std::size_t vector = is_second ? pair.second : pair.vector;
    SlabPair half = pair_of(vector, vector);
    half.lowest = pair.lowest, half.highest = pair.highest;
    half.rays = pair.rays >> shift & 0xffff;
    for (std::size_t k = 0; k < LayerValues::layers; ++k) half.may[k] = pair.may[k] >> shift & 0xffff;
    return half;
  }

  HWY_INLINE SlabPart part_around(const SlabPair* pair, std::size_t count) const {
    SlabPart part;
    for (int m = 0; m < 2; ++m) {
      part.first[m] = pair[0].first[m], part.last[m] = pair[0].last[m];
      for (std::size_t i = 1; i < count; ++i) {
        part.first[m] = pair[i].first[m] < part.first[m] ? pair[i].first[m] : part.first[m];
        part.last[m] = pair[i].last[m] > part.last[m] ? pair[i].last[m] : part.last[m];
      }
    }
    part.window = PlaneWindow(state_.lattice, axes_ + 1, part.first, part.last);
    part.is_at_end = part.last[0] == end_[0] || part.last[1] == end_[1];
    return part;
  }

  /// Calls act(pairs, count, part around them) for as many pairs at once as fit in a window. Pairs
  /// are put into a wide window, where looking up takes longer, only if the first of them does not
  /// fit in a narrow one.
  template <class Act>
  void in_windows(const SlabPair* pair, std::size_t count, const Act& act) {
    const SlabPart part = part_around(pair, count);
    if (part.window.is_narrow() || (part.window.fits() && (count == 1 || !part_around(pair, 1).window.is_narrow()))) {
      act(pair, count, part);
    } else if (count > 1) {
      in_windows(pair, count / 2, act);
      in_windows(pair + count / 2, count - count / 2, act);
    } else {
      for (const bool is_second : {false, true}) {
        const SlabPair half = half_of(*pair, is_second);
        act(&half, std::size_t{1}, part_around(&half, 1));
      }
    }
  }

  /// The blocks that any ray may pass, in the mirrored lattice.
  HWY_INLINE void find_blocks(int* first, int* last) const {
    for (int m = 0; m < 2; ++m) {
      first[m] = hn::GetLane(hn::MinOfLanes(ints, hn::Load(ints, first_cell_[m]))) >> 2;
      last[m] = hn::GetLane(hn::MaxOfLanes(ints, hn::Load(ints, last_cell_[m]))) >> 2;
    }
  }

 private:
  const SearchState& state_;
  int axes_[3];
  int end_[2];  ///< the lattice's last cells
  /// Of each vector.
  HWY_ALIGN std::int32_t first_cell_[2][float_lanes], last_cell_[2][float_lanes];
};

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// Slabs of the lattice in which most blocks may hold a larger value than was found, mainly in
// noise: all rays of a group walk through them at once.
#if defined(RHORAY_WIDE_MAXIMUM_SLABS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_SLABS_INL_H
#undef RHORAY_WIDE_MAXIMUM_SLABS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_SLABS_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include <hwy/highway.h>

#include "render/grid/largest/candidates-inl.h"
#include "render/grid/largest/cubic-inl.h"
#include "render/grid/largest/samples-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/grid/largest/walk-inl.h"
#include "render/traverse/frustum_walk.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Samples of a box of blocks as 16-bit integers: the distance of each below the box's largest
/// value. They are stored in words of two: a sample and the one beyond it on the third axis. So
/// four corners of a cell lie in two adjacent words. Mirrored like the lattice.
struct Window {
  int first[3];  ///< in the mirrored lattice, in cells
  int count[3];  ///< samples

  HWY_INLINE std::int32_t stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? count[0] : count[0] * count[1]; }
  HWY_INLINE bool has_room() const {
    for (const int n : count)
      if (n > MaximumWindow::longest) return false;
    return static_cast<std::size_t>(stride(2)) * static_cast<std::size_t>(count[2]) <= MaximumWindow::capacity;
  }
};

/// @tparam major the major axis
template <int major>
struct WindowCells {
  static constexpr bool is_plain = true, is_below = true;

  const std::int32_t* words;
  std::int32_t stride_y;

  HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
    VecF below[8];
    read_four(words, cell, below);
    read_four(words + stride_y, cell, below + 2);
    return HWY_NAMESPACE::coefficients(below, in_file_order(p), in_file_order(q));
  }

 private:
  HWY_INLINE static Point in_file_order(const Point& p) {
    if constexpr (major == 0) return {p.w, p.u, p.v};
    if constexpr (major == 1) return {p.u, p.w, p.v};
    return p;
  }

  /// Reads two corners and the two beyond them on the third axis.
  HWY_INLINE static void read_four(const std::int32_t* from, VecI cell, VecF* below) {
    VecI near, far;  // two words
#if HWY_TARGET <= HWY_AVX2
    constexpr hn::RebindToSigned<Doubles> longs;
    const auto two_words = [&](hn::Vec<decltype(half_ints)> at) HWY_ATTR {
      const void* first = from;
      return hn::BitCast(ints, hn::GatherOffset(longs, static_cast<const std::int64_t*>(first),
                                                hn::ShiftLeft<2>(hn::PromoteTo(longs, at))));
    };
    const VecI low = two_words(hn::LowerHalf(half_ints, cell)), high = two_words(hn::UpperHalf(half_ints, cell));
    near = hn::ConcatEven(ints, high, low), far = hn::ConcatOdd(ints, high, low);
#else
    HWY_ALIGN std::int32_t at[float_lanes], words_near[float_lanes], words_far[float_lanes];
    hn::Store(cell, ints, at);
    for (std::size_t lane = 0; lane < float_lanes; ++lane) {
      std::memcpy(words_near + lane, from + at[lane], 4);
      std::memcpy(words_far + lane, from + at[lane] + 1, 4);
    }
    near = hn::Load(ints, words_near), far = hn::Load(ints, words_far);
#endif
    const VecI low_half = hn::Set(ints, 0xffff);
    const auto upper = [](VecI pairs) HWY_ATTR {
      constexpr hn::RebindToUnsigned<Ints> unsigned_ints;
      return hn::BitCast(ints, hn::ShiftRight<16>(hn::BitCast(unsigned_ints, pairs)));
    };
    below[0] = hn::ConvertTo(floats, hn::And(near, low_half)), below[1] = hn::ConvertTo(floats, hn::And(far, low_half));
    below[4] = hn::ConvertTo(floats, upper(near)), below[5] = hn::ConvertTo(floats, upper(far));
  }
};

#if HWY_TARGET != HWY_SCALAR
/// Stores four words each to the rows of a window.
template <class D>
HWY_INLINE void store_rows(D tag, hn::Vec<D> words, std::int32_t* const* rows, std::ptrdiff_t at) {
  if constexpr (hn::MaxLanes(tag) <= 4) {
    hn::StoreU(words, tag, rows[0] + at);
  } else {
    constexpr hn::Half<D> half;
    store_rows(half, hn::LowerHalf(half, words), rows, at);
    store_rows(half, hn::UpperHalf(half, words), rows + hn::MaxLanes(half) / 4, at);
  }
}

/// Reads the samples of a window from a volume in which squares of 4 x 4 samples are contiguous; on
/// the first axis the window consists of whole squares. @tparam T integers of at most 16 bits
template <class T>
HWY_NOINLINE void fill_by_squares(const MaximumField& field, const MirroredLattice& lattice, const Window& window,
                                  double highest, MaximumWindow& memory) {
  const SampleSource& source = field.source;
  constexpr hn::CappedTag<std::int32_t, 16> square;
  constexpr hn::Rebind<T, decltype(square)> stored_square;
  constexpr int rows_at_once = static_cast<int>(hn::MaxLanes(square)) / 4;
  const auto top = hn::Set(square, static_cast<std::int32_t>(highest));
  const int* n = window.count;
  const auto sample_at = [&](int a, int i) {
    const int at = window.first[a] + i;
    return lattice.is_mirrored(a) ? static_cast<int>(lattice.plane(a, at)) : at;
  };
  std::uint64_t address[MaximumWindow::longest];  // on the third axis
  for (int z = 0; z < n[2]; ++z) address[z] = source.address[2][sample_at(2, z)];
  const bool is_down = lattice.is_mirrored(0), rises = !lattice.is_mirrored(1);
  const int low = sample_at(1, rises ? 0 : n[1] - 1), high = sample_at(1, rises ? n[1] - 1 : 0);
  const std::ptrdiff_t stride = window.stride(2);
  for (int y = low & ~3; y <= high; y += rows_at_once) {
    if (y + rows_at_once <= low) continue;
    // Rows of the volume beyond the window go to its end and are not used.
    std::int32_t* rows[rows_at_once];
    for (int j = 0; j < rows_at_once; ++j) {
      const int row = rises ? y + j - low : high - y - j;
      const bool is_inside = row >= 0 && row < n[1];
      rows[j] = memory.words + (is_inside ? window.stride(1) * row : static_cast<int>(MaximumWindow::capacity));
    }
    for (int x = 0; x < n[0]; x += 4) {
      const T* from = static_cast<const T*>(source.samples) + source.address[0][sample_at(0, is_down ? x + 3 : x)] +
                      source.address[1][y];
      const auto below = [&](int z) HWY_ATTR {
        return hn::Sub(top, hn::PromoteTo(square, hn::LoadU(stored_square, from + address[z])));
      };
      auto near = below(0);
      for (int z = 0; z + 1 < n[2]; ++z) {
        const auto far = below(z + 1);
        const auto words = hn::Or(near, hn::ShiftLeft<16>(far));
        store_rows(square, is_down ? hn::Reverse4(square, words) : words, rows, x + stride * z);
        near = far;
      }
    }
  }
}

#endif

/// The same for any volume.
template <class T>
HWY_NOINLINE void fill(const MaximumField& field, const MirroredLattice& lattice, const Window& window, double highest,
                       MaximumWindow& memory) {
  const SampleSource& source = field.source;
  constexpr hn::CappedTag<std::int32_t, 4> row;
  constexpr hn::Rebind<T, decltype(row)> stored_row;
  const auto top = static_cast<std::int32_t>(highest);
  const int* n = window.count;
  std::uint64_t address[3][MaximumWindow::longest];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < n[a]; ++i) {
      const int at = window.first[a] + i;
      address[a][i] = source.address[a][lattice.is_mirrored(a) ? static_cast<int>(lattice.plane(a, at)) : at];
    }
  // On the first axis read four samples of the volume at once, as far as there are four.
  const bool is_down = lattice.is_mirrored(0);
  const int in_rows = source.has_whole_rows && hn::MaxLanes(row) == 4 ? n[0] / 4 * 4 : 0;
  for (int y = 0; y < n[1]; ++y) {
    const T* from = static_cast<const T*>(source.samples) + address[1][y];
    std::int32_t* to = memory.words + window.stride(1) * y;
    for (int i = 0; i < in_rows; i += 4) {
      const int x = is_down ? n[0] - 4 - i : i;
      const T* four = from + address[0][is_down ? x + 3 : x];
      const auto below = [&](int z) HWY_ATTR {
        const auto stored = hn::PromoteTo(row, hn::LoadU(stored_row, four + address[2][z]));
        return hn::Sub(hn::Set(row, top), stored);
      };
      auto near = below(0);
      for (int z = 0; z + 1 < n[2]; ++z) {
        const auto far = below(z + 1);
        const auto words = hn::Or(near, hn::ShiftLeft<16>(far));
        hn::StoreU(is_down ? hn::Reverse(row, words) : words, row, to + x + window.stride(2) * z);
        near = far;
      }
    }
    for (int i = in_rows; i < n[0]; ++i) {
      const int x = is_down ? n[0] - 1 - i : i;
      const T* one = from + address[0][x];
      for (int z = 0; z + 1 < n[2]; ++z) {
        const std::int32_t near = top - one[address[2][z]], far = top - one[address[2][z + 1]];
        to[x + window.stride(2) * z] = static_cast<std::int32_t>(static_cast<std::uint32_t>(near | far << 16));
      }
    }
  }
}

/// Values are off by less than 12 margins of the window's range, as in blocks (BlockWalk), and by
/// 2^-20 of it for the interpolation. Positions are relative to the slab's corner, so the margin is
/// smaller than elsewhere: positions are less than 128 and rounded by 2^-18 at most in start and
/// sum, and by 16 units of rounding of the slope.
class SlabSweep {
 public:
  SlabSweep(SearchState& state, CandidateRefinement& looks)
      : state_(state), looks_(looks), field_(state.field), scratch_(state.scratch) {
    using formats::ElementType;
    const ElementType type = state.field.type;
    const bool is_short =
        type == ElementType::U8 || type == ElementType::I8 || type == ElementType::U16 || type == ElementType::I16;
    may_sweep_ = is_short && !state.field.has_gaps;
    for (std::uint64_t& word : scratch_.slabs.swept) word = 0;
    for (int slab = 0; slab < state.lattice.node_count[state.frustum.major]; ++slab) {
      scratch_.slabs.blocks[slab] = 0;
      scratch_.slabs.next[slab] = std::numeric_limits<int>::max();
    }
  }

  /// True where nothing is left to do in a slab of nodes.
  HWY_INLINE bool is_swept(int slab) const {
    return (scratch_.slabs.swept[static_cast<std::size_t>(slab) / 64] >> slab % 64 & 1) != 0;
  }

  /// Sweeps a slab of nodes where it pays off: where nearly all of its blocks are of this bucket or
  /// above.
  HWY_NOINLINE bool sweep(int slab, const RegionQueue& queue, int bucket) {
    if (!may_sweep_ || bucket > scratch_.slabs.next[slab]) return false;
    if (!sweep_box(slab, queue.least_of(bucket))) {
      scratch_.slabs.next[slab] = bucket - buckets_between;
      return false;
    }
    scratch_.slabs.swept[static_cast<std::size_t>(slab) / 64] |= std::uint64_t{1} << slab % 64;
    return true;
  }

  /// The same for a slab in which a block is about to be searched; considered for one block of
  /// eight.
  HWY_INLINE bool sweep_around_block(int slab, const RegionQueue& queue, int bucket) {
    return ++scratch_.slabs.blocks[slab] % 8 == 0 && sweep(slab, queue, bucket);
  }

 private:
  /// A slab with too many low blocks is considered again when the search has come down this far.
  static constexpr int buckets_between = 8;

  /// In a slab that is swept, at most one of this many blocks may be below the bucket.
  static constexpr int blocks_per_low = 20;

  static constexpr float margin = 0x1p-15F;  ///< more than positions from the slab's corner are off

  /// The cells of a slab that rays of the group may pass, mirrored, from first to last; false where
  /// there are none. On the volume's first axis they are those of whole blocks.
  HWY_INLINE bool find_cells(int slab, int (&first)[3], int (&last)[3]) const {
    const Frustum& frustum = state_.frustum;
    const MirroredLattice& lattice = state_.lattice;
    const int w = frustum.major;
    const double low = 16.0 * slab, high = low + 16;
    const double near = low < frustum.first ? frustum.first : low, far = high > frustum.last ? frustum.last : high;
    if (near > far) return false;
    const double from[] = {frustum.low[0].at(near), frustum.low[1].at(near), near};
    const double to[] = {frustum.high[0].at(far), frustum.high[1].at(far), far == high ? 16 * slab + 15 : far};
    for (int i = 0; i < 3; ++i) {
      const int a = i < 2 ? frustum.minor[i] : w;
      // The lattice may end within its last block.
      const int lowest = lattice.is_mirrored(a) ? static_cast<int>(lattice.plane(a, field_.leaf_count[a])) : 0;
      const int highest = lowest + field_.leaf_count[a] - 1;
      // From far away, ends may exceed the range of int. So they are limited to a block outside the
      // lattice; widening to whole blocks leaves them outside.
      first[a] = floored_within(from[i], lowest - 4, highest + 4);
      last[a] = floored_within(to[i], lowest - 4, highest + 4);
      if (a == 0) first[a] &= ~3, last[a] |= 3;
      first[a] = first[a] < lowest ? lowest : first[a], last[a] = last[a] > highest ? highest : last[a];
      if (first[a] > last[a]) return false;
    }
    return true;
  }

  /// The range of the blocks that a window touches; nothing where too few of them reach `least`.
  template <class T>
  HWY_INLINE std::optional<Range> range_of_high(const Window& window, double least) {
    int first[3], last[3], count = 1;
    for (int a = 0; a < 3; ++a) {
      first[a] = state_.lattice.block(a, window.first[a] >> 2);
      last[a] = state_.lattice.block(a, (window.first[a] + window.count[a] - 2) >> 2);
      if (state_.lattice.is_mirrored(a)) {
        const int swapped = first[a];
        first[a] = last[a], last[a] = swapped;
      }
      count *= last[a] - first[a] + 1;
    }
    Range range{std::numeric_limits<double>::infinity(), nothing};
    int low_left = count / blocks_per_low;
    const int* stored = field_.blocks.count;
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j) {
        scratch_.regions += static_cast<std::uint64_t>(last[0] - first[0] + 1);
        for (int i = first[0]; i <= last[0]; ++i) {
          const Range here =
              stored_range<T>(field_.blocks.first, (static_cast<std::ptrdiff_t>(k) * stored[1] + j) * stored[0] + i);
          range.lo = here.lo < range.lo ? here.lo : range.lo;
          range.hi = here.hi > range.hi ? here.hi : range.hi;
          low_left -= here.hi < least;
        }
        if (low_left < 0) return std::nullopt;
      }
    return range;
  }

  HWY_INLINE bool sweep_box(int slab, double least) {
    int first[3], last[3];
    if (!find_cells(slab, first, last)) return false;
    Window window;
    for (int a = 0; a < 3; ++a) window.first[a] = first[a], window.count[a] = last[a] - first[a] + 2;
    if (!window.has_room()) return false;
    using formats::ElementType;
    switch (field_.type) {
      case ElementType::U8:
        return sweep_window<std::uint8_t>(window, least);
      case ElementType::I8:
        return sweep_window<std::int8_t>(window, least);
      case ElementType::U16:
        return sweep_window<std::uint16_t>(window, least);
      default:
        return sweep_window<std::int16_t>(window, least);
    }
  }

  template <class T>
  HWY_INLINE void fill_any(bool by_squares, const Window& window, double highest) {
#if HWY_TARGET != HWY_SCALAR
    if (by_squares) return fill_by_squares<T>(field_, state_.lattice, window, highest, scratch_.window);
#else
    (void)by_squares;
#endif
    fill<T>(field_, state_.lattice, window, highest, scratch_.window);
  }

  /// Extends a window by adjacent samples on the first axis: from a multiple of four on, in the
  /// volume.
  HWY_INLINE Window of_whole_squares(Window window) const {
    const int beyond = -window.count[0] & 3;
    window.count[0] += beyond;
    if (state_.lattice.is_mirrored(0)) window.first[0] -= beyond;
    return window;
  }

  template <class T>
  HWY_NOINLINE bool sweep_window(const Window& touched, double least) {
    const std::optional<Range> of_blocks = range_of_high<T>(touched, least);
    if (!of_blocks) return false;
    const Range& range = *of_blocks;
    const bool by_squares = HWY_TARGET != HWY_SCALAR && field_.has_squares;
    const Window window = by_squares ? of_whole_squares(touched) : touched;
    if (!window.has_room()) return false;
    put_rays(window, range.hi);
    if (scratch_.at_block.count == 0) return true;
    fill_any<T>(by_squares, window, range.hi);
    switch (state_.frustum.major) {
      case 0:
        walk<0>(window, range);
        break;
      case 1:
        walk<1>(window, range);
        break;
      default:
        walk<2>(window, range);
    }
    return true;
  }

  /// Adds rays that have a part in the slab and may be changed there.
  HWY_INLINE void put_rays(const Window& window, double highest) {
    const GroupLines& lines = scratch_.lines;
    const double low[3] = {static_cast<double>(window.first[0]), static_cast<double>(window.first[1]),
                           static_cast<double>(window.first[2])};
    const VecF low_w = hn::Set(floats, static_cast<float>(window.first[state_.frustum.major]));
    const VecF end_w = hn::Add(low_w, hn::Set(floats, static_cast<float>(window.count[state_.frustum.major] - 1)));
    const int axes[3] = {state_.frustum.major, state_.frustum.minor[0], state_.frustum.minor[1]};
    float last[3];
    for (int i = 0; i < 3; ++i) last[i] = static_cast<float>(window.count[axes[i]] - 2);
    scratch_.at_block.count = 0;
    for (std::size_t r = 0; r < state_.vectors * float_lanes; r += float_lanes) {
      const VecF from = hn::Max(hn::Load(floats, lines.from + r), low_w);
      const VecF to = hn::Min(hn::Load(floats, lines.to + r), end_w);
      VecD parts[parts_of_floats];
      for (std::size_t part = 0; part < parts_of_floats; ++part) {
        const VecD below =
            hn::Sub(hn::Load(doubles, scratch_.reached + r + part * double_lanes), hn::Set(doubles, highest));
        parts[part] =
            hn::Max(hn::NegMulAdd(hn::Abs(below), hn::Set(doubles, 0x1p-22), below), hn::Set(doubles, -0x1p20));
      }
      const VecF reached = as_floats(parts);
      const MaskF passing = hn::And(hn::Lt(from, to), SearchState::may_improve(hn::Zero(floats), from, reached,
                                                                               hn::Load(floats, lines.reached_at + r)));
      if (hn::AllFalse(floats, passing)) continue;
      const SearchState::PartsInBox in_window = state_.parts_in_box(r, from, to, low);
      state_.count_cells(r, passing, in_window, last);
      state_.put_at_box(r, passing, in_window, low[state_.frustum.major], reached);
    }
    if (scratch_.at_block.count != 0) state_.close_box();
  }

  template <int major>
  HWY_NOINLINE void walk(const Window& window, const Range& range) {
    const RaysAtBlock& at_block = scratch_.at_block;
    constexpr int axes[3] = {major, major == 0 ? 1 : 0, major == 2 ? 1 : 2};
    CellBox box{.low_w = static_cast<double>(window.first[major]),
                .last = {},
                .first = 0,
                .stride = {},
                .highest = range.hi,
                .unit = 1,
                .error = static_cast<float>(range.hi - range.lo) * (12 * margin + 0x1p-20F),
                .margin = margin,
                .is_come_to = state_.is_come_to(static_cast<double>(window.first[major]))};
    for (int i = 0; i < 3; ++i) {
      box.last[i] = static_cast<float>(window.count[axes[i]] - 2);
      box.stride[i] = window.stride(axes[i]);
    }
    const WindowCells<major> cells{scratch_.window.words, window.stride(1)};
    looks_.open_box(box.highest, box.unit, box.low_w);
    for (std::size_t first = 0; first < at_block.count; first += float_lanes) {
      const Ways ways = ways_at_box(at_block, first);
      walk_cells(state_, looks_, box, cells, ways);
    }
  }

  SearchState& state_;
  CandidateRefinement& looks_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
  bool may_sweep_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

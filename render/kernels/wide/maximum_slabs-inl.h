// Slabs of the lattice in which most blocks may hold a larger value than was found, noise above all: all rays of a
// group walk through them at once.
#if defined(RHORAY_WIDE_MAXIMUM_SLABS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_SLABS_INL_H
#undef RHORAY_WIDE_MAXIMUM_SLABS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_SLABS_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "render/kernels/wide/frustum_walk.h"
#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/maximum_cubic-inl.h"
#include "render/kernels/wide/maximum_looks-inl.h"
#include "render/kernels/wide/maximum_samples-inl.h"
#include "render/kernels/wide/maximum_state-inl.h"
#include "render/kernels/wide/maximum_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Samples of a box of blocks as whole numbers of 16 bits: how far each lies below the box's largest value. Stored in
/// words of two, a sample and the one beyond it on the third axis, so that four corners of a cell lie in two words side
/// by side. Mirrored as the lattice is.
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

/// @tparam major  the major axis
template <int major>
struct WindowCells {
  static constexpr float lowest = -0x1p17F;  ///< less than any value

  const std::int32_t* words;
  std::int32_t stride_y;

  /// The highest value of the window is 0.
  HWY_INLINE static VecF bound(VecI) { return hn::Zero(floats); }

  HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
    VecF below[8];
    read_four(words, cell, below);
    read_four(words + stride_y, cell, below + 2);
    const Coefficients b = HWY_NAMESPACE::coefficients(below, in_file_order(p), in_file_order(q));
    return {hn::Neg(b.b0), hn::Neg(b.b1), hn::Neg(b.b2), hn::Neg(b.b3)};
  }

 private:
  HWY_INLINE static Point in_file_order(const Point& p) {
    if constexpr (major == 0) return {p.w, p.u, p.v};
    if constexpr (major == 1) return {p.u, p.w, p.v};
    return p;
  }

  /// Two corners, and the two beyond them on the third axis.
  HWY_INLINE static void read_four(const std::int32_t* from, VecI cell, VecF* below) {
    VecI near, far;  // two words
#if HWY_TARGET <= HWY_AVX2
    constexpr hn::RebindToSigned<Doubles> longs;
    constexpr hn::Rebind<std::int32_t, Doubles> half_ints;
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
    const auto upper = [](VecI words) HWY_ATTR {
      constexpr hn::RebindToUnsigned<Ints> unsigned_ints;
      return hn::BitCast(ints, hn::ShiftRight<16>(hn::BitCast(unsigned_ints, words)));
    };
    below[0] = hn::ConvertTo(floats, hn::And(near, low_half)), below[1] = hn::ConvertTo(floats, hn::And(far, low_half));
    below[4] = hn::ConvertTo(floats, upper(near)), below[5] = hn::ConvertTo(floats, upper(far));
  }
};

/// @tparam T  whole numbers of at most 16 bits
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
  // On the first axis four samples of the file at once, as far as there are so many.
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

/// Values are off by less than 12 margins of the window's range, as in blocks (BlockWalk), and by 2^-20 of it for the
/// interpolation. Places are counted from the slab's corner, so that the margin is smaller than elsewhere: places are
/// less than 128 and rounded by 2^-18 at most in start and sum, and by 16 units of rounding of the slope.
class SlabSweep {
 public:
  SlabSweep(SearchState& state, CloseLooks& looks)
      : state_(state), looks_(looks), field_(state.field), scratch_(state.scratch) {
    using formats::ElementType;
    const ElementType type = state.field.type;
    const bool is_short =
        type == ElementType::U8 || type == ElementType::I8 || type == ElementType::U16 || type == ElementType::I16;
    may_sweep_ = is_short && !state.field.has_gaps;
    for (std::uint64_t& word : scratch_.slabs.asked) word = 0;
    for (std::uint64_t& word : scratch_.slabs.swept) word = 0;
  }

  /// Nothing is left to be looked at in a slab of nodes. It was swept before, or is now, where most of its blocks reach
  /// a value; that is asked once.
  HWY_NOINLINE bool covers(int slab, const RegionQueue& queue, int bucket) {
    if (!may_sweep_) return false;
    const auto word = static_cast<std::size_t>(slab) / 64;
    const std::uint64_t bit = std::uint64_t{1} << slab % 64;
    if ((scratch_.slabs.asked[word] & bit) != 0) return (scratch_.slabs.swept[word] & bit) != 0;
    scratch_.slabs.asked[word] |= bit;
    if (!sweep(slab, queue, bucket)) return false;
    scratch_.slabs.swept[word] |= bit;
    return true;
  }

 private:
  static constexpr float margin = 0x1p-15F;  ///< more than places from the slab's corner are off

  /// Blocks that rays of the group may pass in a slab, mirrored; false where the file has none.
  HWY_INLINE bool find_blocks(int slab, int (&first)[3], int (&last)[3]) const {
    const Frustum& frustum = state_.frustum;
    const MirroredLattice& lattice = state_.lattice;
    const int w = frustum.major;
    const int block_count[3] = {4 * lattice.node_count[0], 4 * lattice.node_count[1], 4 * lattice.node_count[2]};
    first[w] = 4 * slab, last[w] = 4 * slab + 3;
    const int nearest = floored(frustum.first / 4), furthest = floored(frustum.last / 4);
    first[w] = first[w] < nearest ? nearest : first[w], last[w] = last[w] > furthest ? furthest : last[w];
    if (first[w] > last[w]) return false;
    const SlabRectangle near = rectangle_in_slab(frustum, first[w], 4, block_count),
                        far = rectangle_in_slab(frustum, last[w], 4, block_count);
    for (int m = 0; m < 2; ++m) {
      const int a = frustum.minor[m];
      first[a] = near.first[m] < far.first[m] ? near.first[m] : far.first[m];
      last[a] = near.last[m] > far.last[m] ? near.last[m] : far.last[m];
    }
    for (int a = 0; a < 3; ++a) {
      const int count = field_.blocks.count[a];
      const int lowest = lattice.is_mirrored(a) ? block_count[a] - count : 0, highest = lowest + count - 1;
      first[a] = first[a] < lowest ? lowest : first[a], last[a] = last[a] > highest ? highest : last[a];
      if (first[a] > last[a]) return false;
    }
    return true;
  }

  HWY_INLINE bool sweep(int slab, const RegionQueue& queue, int bucket) {
    int first[3], last[3];
    if (!find_blocks(slab, first, last)) return false;
    Window window;
    for (int a = 0; a < 3; ++a) {
      window.first[a] = 4 * first[a];
      int end = 4 * last[a] + 4;
      // The file may end within its last block.
      if (state_.lattice.is_mirrored(a)) {
        const int lowest = static_cast<int>(state_.lattice.plane(a, field_.leaf_count[a]));
        window.first[a] = window.first[a] < lowest ? lowest : window.first[a];
      } else if (end > field_.leaf_count[a]) {
        end = field_.leaf_count[a];
      }
      window.count[a] = end - window.first[a] + 1;
    }
    if (!window.has_room()) return false;

    int block[3], blocks = 0, high_ones = 0;
    Range range{std::numeric_limits<double>::infinity(), nothing};
    for (block[2] = first[2]; block[2] <= last[2]; ++block[2])
      for (block[1] = first[1]; block[1] <= last[1]; ++block[1])
        for (block[0] = first[0]; block[0] <= last[0]; ++block[0]) {
          int place[3] = {};
          state_.find_in_file(block, true, field_.blocks, place);
          const Range here = range_of(field_, field_.blocks, place);
          range.lo = here.lo < range.lo ? here.lo : range.lo, range.hi = here.hi > range.hi ? here.hi : range.hi;
          ++blocks, high_ones += queue.bucket_of(here.hi) >= bucket;
        }
    scratch_.regions += static_cast<std::uint64_t>(blocks);
    if (2 * high_ones < blocks) return false;
    put_rays(window, range.hi);
    if (scratch_.at_block.count == 0) return true;
    fill_of_type(window, range.hi);
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

  /// Rays that have a part in the slab and may be changed there.
  HWY_INLINE void put_rays(const Window& window, double highest) {
    const GroupLines& lines = scratch_.lines;
    SlabRays& slab = scratch_.slabs;
    RaysAtBlock& at_block = scratch_.at_block;
    const int low_w = window.first[state_.frustum.major];
    for (std::size_t r = 0; r < state_.vectors * float_lanes; r += double_lanes) {
      for (int m = 0; m < 2; ++m) {
        const VecD at_low =
            hn::MulAdd(hn::Load(doubles, lines.exact_slope[m] + r), hn::Set(doubles, static_cast<double>(low_w)),
                       hn::Load(doubles, lines.exact_start[m] + r));
        const VecD start =
            hn::Sub(at_low, hn::Set(doubles, static_cast<double>(window.first[state_.frustum.minor[m]])));
        hn::Store(hn::DemoteTo(half_floats, start), half_floats, slab.start[m] + r);
      }
      const VecD below = hn::Sub(hn::Load(doubles, scratch_.reached + r), hn::Set(doubles, highest));
      const VecD lower =
          hn::Max(hn::NegMulAdd(hn::Abs(below), hn::Set(doubles, 0x1p-22), below), hn::Set(doubles, -0x1p20));
      hn::Store(hn::DemoteTo(half_floats, lower), half_floats, slab.reached + r);
    }
    const VecF low = hn::Set(floats, static_cast<float>(low_w));
    const VecF length = hn::Set(floats, static_cast<float>(window.count[state_.frustum.major] - 1));
    at_block.count = 0;
    for (std::size_t r = 0; r < state_.vectors * float_lanes; r += float_lanes) {
      const VecF from = hn::Max(hn::Sub(hn::Load(floats, lines.from + r), low), hn::Zero(floats));
      const VecF to = hn::Min(hn::Sub(hn::Load(floats, lines.to + r), low), length);
      const MaskF passing = hn::And(hn::Lt(from, to), SearchState::may_improve(hn::Zero(floats), hn::Add(from, low),
                                                                               hn::Load(floats, slab.reached + r),
                                                                               hn::Load(floats, lines.reached_at + r)));
      hn::CompressStore(hn::Iota(ints, static_cast<std::int32_t>(r)), hn::RebindMask(ints, passing), ints,
                        at_block.ray + at_block.count);
      hn::CompressStore(from, passing, floats, at_block.from + at_block.count);
      at_block.count += hn::CompressStore(to, passing, floats, at_block.to + at_block.count);
    }
    // Lanes beyond the last ray pass through nothing.
    for (std::size_t lane = at_block.count; lane < at_block.count + float_lanes; ++lane)
      at_block.ray[lane] = at_block.ray[0], at_block.from[lane] = 1, at_block.to[lane] = 0;
  }

  template <int major>
  HWY_NOINLINE void walk(const Window& window, const Range& range) {
    const RaysAtBlock& at_block = scratch_.at_block;
    const GroupLines& lines = scratch_.lines;
    const SlabRays& slab = scratch_.slabs;
    constexpr int axes[3] = {major, major == 0 ? 1 : 0, major == 2 ? 1 : 2};
    CellBox box{.low_w = static_cast<double>(window.first[major]),
                .last = {},
                .first = 0,
                .stride = {},
                .highest = range.hi,
                .unit = 1,
                .error = static_cast<float>(range.hi - range.lo) * (12 * margin + 0x1p-20F),
                .margin = margin};
    for (int i = 0; i < 3; ++i) {
      box.last[i] = static_cast<float>(window.count[axes[i]] - 2);
      box.stride[i] = window.stride(axes[i]);
    }
    const WindowCells<major> cells{scratch_.window.words, window.stride(1)};
    const VecF low_w = hn::Set(floats, static_cast<float>(window.first[major]));
    for (std::size_t first = 0; first < at_block.count; first += float_lanes) {
      Ways ways;
      ways.ray = hn::Load(ints, at_block.ray + first);
      ways.from = hn::Load(floats, at_block.from + first);
      ways.to = hn::Load(floats, at_block.to + first);
      for (int m = 0; m < 2; ++m) {
        ways.start[m] = hn::GatherIndex(floats, slab.start[m], ways.ray);
        ways.slope[m] = hn::GatherIndex(floats, lines.slope[m], ways.ray);
        ways.inverse[m] = hn::GatherIndex(floats, lines.inverse[m], ways.ray);
      }
      ways.reached = hn::GatherIndex(floats, slab.reached, ways.ray);
      ways.reached_at =
          hn::Add(hn::Sub(hn::GatherIndex(floats, lines.reached_at, ways.ray), low_w), hn::Set(floats, state_.margin));
      const VecF passed = walk_cells(state_, looks_, box, cells, ways);
      count_cells(state_, passed, at_block.ray + first, at_block.count - first);
    }
    looks_.keep_suspects(box.highest, box.unit, box.low_w);
  }

  HWY_INLINE void fill_of_type(const Window& window, double highest) {
    using formats::ElementType;
    switch (field_.type) {
      case ElementType::U8:
        return fill<std::uint8_t>(field_, state_.lattice, window, highest, scratch_.window);
      case ElementType::I8:
        return fill<std::int8_t>(field_, state_.lattice, window, highest, scratch_.window);
      case ElementType::U16:
        return fill<std::uint16_t>(field_, state_.lattice, window, highest, scratch_.window);
      default:
        return fill<std::int16_t>(field_, state_.lattice, window, highest, scratch_.window);
    }
  }

  SearchState& state_;
  CloseLooks& looks_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
  bool may_sweep_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

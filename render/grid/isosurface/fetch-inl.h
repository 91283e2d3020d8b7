// The samples of one block minus an isovalue, and which of its cells have corners on both sides.
#if defined(RHORAY_WIDE_FETCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FETCH_INL_H
#undef RHORAY_WIDE_FETCH_INL_H
#else
#define RHORAY_WIDE_FETCH_INL_H
#endif

#include <cstdint>
#include <limits>
#include <type_traits>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "render/grid/block_samples.h"
#include "render/grid/brick_samples.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Value - isovalue as a float of the same side: like `minus` of render/cell/trilinear.h, for
/// magnitudes that need no other unit.
HWY_INLINE float side_keeping_difference(double value, double isovalue) {
  const double difference = value - isovalue;
  const float rounded = static_cast<float>(difference), least = -std::numeric_limits<float>::denorm_min();
  return difference < 0 && rounded > least ? least : rounded;
}

/// Types for which the difference to an isovalue that is a float is rounded once in single
/// precision. It is the same number as the difference taken in double and then rounded.
template <class T>
inline constexpr bool is_exact_in_float = std::is_integral_v<T> && sizeof(T) <= 2;

/// The cells of a block that the lattice has.
HWY_INLINE std::uint64_t existing_cells(const SampleSource& source, const int* block) {
  std::uint64_t bits = 1;
  for (int a = 0; a < 3; ++a) bits *= spread_bits(range_bits(0, source.count[a] - 2 - 4 * block[a]), a);
  return bits;
}

/// Converts bits of samples (x + 5 y + 25 z, in two words together) at the lowest corners of the
/// block's cells to bits of cells.
HWY_INLINE std::uint64_t cells_of_samples(unsigned __int128 bits) {
  std::uint64_t cells = 0;
  for (int z = 0; z < 4; ++z) {
    const auto layer = static_cast<std::uint64_t>(bits >> (25 * z));
#if HWY_TARGET <= HWY_AVX2
    cells |= _pext_u64(layer, 15 * (1 | 1 << 5 | 1 << 10 | 1 << 15)) << (16 * z);
#else
    for (int y = 0; y < 4; ++y) cells |= (layer >> (5 * y) & 15) << (4 * y + 16 * z);
#endif
  }
  return cells;
}

/// One bit for each sample of a block.
template <class Test>
HWY_INLINE unsigned __int128 samples_that(const BlockSamples& samples, Test&& test) {
  std::uint64_t words[2] = {};
  for (std::size_t i = 0; i < 128; i += float_lanes)
    words[i / 64] |= bits_of(floats, test(hn::Load(floats, samples.difference + i))) << i % 64;
  return static_cast<unsigned __int128>(words[1]) << 64 | words[0];
}

/// At the lowest corner of each cell: the conjunction of the bits of all its corners.
HWY_INLINE unsigned __int128 of_all_corners(unsigned __int128 samples) {
  samples &= samples >> 1;
  samples &= samples >> 5;
  return samples & samples >> 25;
}

/// Finds the cells that have corners on both sides, and those whose lowest corner is inside.
/// Samples of at least `least_inside` are inside.
/// @param present  cells that the lattice has
HWY_INLINE void find_active_cells(std::uint64_t present, float least_inside, BlockSamples& samples) {
  const VecF least = hn::Set(floats, least_inside);
  const unsigned __int128 inside = samples_that(samples, [=](VecF f) HWY_ATTR { return hn::Ge(f, least); });
  const unsigned __int128 active = ~of_all_corners(inside) & ~of_all_corners(~inside);
  samples.present = present;
  samples.active = cells_of_samples(active) & present;
  samples.inside = cells_of_samples(inside);
  samples.range = std::numeric_limits<float>::quiet_NaN();
}

/// Finds the range of a block's samples. The range of differences near the smallest numbers counts
/// as infinite, because rounding is then not proportional to it.
HWY_INLINE void find_range(const SampleSource& source, BlockSamples& samples) {
  VecF low = hn::Zero(floats), high = low;
  for (std::size_t i = 0; i < 128; i += float_lanes) {
    const VecF f = hn::Load(floats, samples.difference + i);
    low = hn::Min(low, f), high = hn::Max(high, f);
  }
  const float range = hn::GetLane(hn::Sub(hn::MaxOfLanes(floats, high), hn::MinOfLanes(floats, low)));
  samples.range = !source.has_gaps && range >= 0x1p-70f ? range : std::numeric_limits<float>::infinity();
}

/// Removes cells that touch samples that are NaN or infinite: they have no data.
HWY_INLINE void leave_out_gaps(BlockSamples& samples) {
  const VecF infinite = hn::Set(floats, std::numeric_limits<float>::infinity());
  samples.present &= cells_of_samples(
      of_all_corners(samples_that(samples, [=](VecF f) HWY_ATTR { return hn::Lt(hn::Abs(f), infinite); })));
  samples.active &= samples.present;
}

/// Reads four contiguous samples of a type that is exact in float.
template <class T>
HWY_INLINE void fetch_row_in_float(const T* from, float isovalue, float* to) {
  if constexpr (is_exact_in_float<T>) {
    constexpr hn::CappedTag<float, 4> row;
    constexpr hn::Rebind<T, decltype(row)> stored;
    constexpr hn::Rebind<std::int32_t, decltype(row)> whole;
    for (std::size_t i = 0; i < 4; i += hn::MaxLanes(row))
      hn::StoreU(hn::Sub(hn::ConvertTo(row, hn::PromoteTo(whole, hn::LoadU(stored, from + i))), hn::Set(row, isovalue)),
                 row, to + i);
  }
}

/// The same for isovalues that are no floats: side_keeping_difference of each sample.
template <class T>
HWY_INLINE void fetch_row(const T* from, double isovalue, float* to) {
  if constexpr (is_exact_in_float<T>) {
    constexpr hn::CappedTag<double, 4> row;
    constexpr hn::Rebind<T, decltype(row)> stored;
    constexpr hn::Rebind<std::int32_t, decltype(row)> whole;
    constexpr hn::Rebind<float, decltype(row)> rounded;
    const auto least = hn::Set(row, -static_cast<double>(std::numeric_limits<float>::denorm_min()));
    for (std::size_t i = 0; i < 4; i += hn::MaxLanes(row)) {
      const auto difference =
          hn::Sub(hn::PromoteTo(row, hn::PromoteTo(whole, hn::LoadU(stored, from + i))), hn::Set(row, isovalue));
      const auto of_side = hn::IfThenElse(hn::Lt(difference, hn::Zero(row)), hn::Min(difference, least), difference);
      hn::StoreU(hn::DemoteTo(rounded, of_side), rounded, to + i);
    }
  }
}

/// Reads the samples of a block whose bricks are whole, minus an isovalue that is a float, of a
/// type that is exact in float: layer by layer, from vectors of 16 samples.
template <class T>
HWY_INLINE void fetch_bricks(const SampleSource& source, const int* first, float isovalue, float* to) {
  constexpr hn::Rebind<T, Floats> stored;
  const T* samples = static_cast<const T*>(source.samples);
  // Samples 0 to 15 of a layer of 5 x 5: every fifth belongs to the next brick.
  HWY_ALIGN constexpr std::int32_t from[16] = {0, 1, 2, 3, 0, 4, 5, 6, 7, 4, 8, 9, 10, 11, 8, 12};
  const auto order = hn::IndicesFromVec(floats, hn::Load(ints, from));
  const MaskF of_next = mask_of(floats, 1 << 4 | 1 << 9 | 1 << 14);
  const VecF less = hn::Set(floats, isovalue);
  const auto layer_of = [&](const T* at) HWY_ATTR {
    return hn::Sub(hn::ConvertTo(floats, hn::PromoteTo(ints, hn::LoadU(stored, at))), less);
  };
  for (int k = 0; k < 5; ++k) {
    const std::uint64_t z = source.address[2][first[2] + k], y = source.address[1][first[1]] + z;
    const T *here = samples + source.address[0][first[0]] + y, *next = samples + source.address[0][first[0] + 4] + y;
    const std::uint64_t behind = source.address[1][first[1] + 4] - source.address[1][first[1]];
    float* layer = to + 25 * k;
    const VecF of_here = hn::TableLookupLanes(layer_of(here), order);
    hn::StoreU(hn::IfThenElse(of_next, hn::TableLookupLanes(layer_of(next), order), of_here), floats, layer);
    fetch_row_in_float(here + 12, isovalue, layer + 15);
    layer[19] = static_cast<float>(next[12]) - isovalue;
    fetch_row_in_float(here + behind, isovalue, layer + 20);
    layer[24] = static_cast<float>(next[behind]) - isovalue;
  }
}

/// Values minus an isovalue, as side_keeping_difference computes them.
/// @param is_single  the isovalue is a number of single precision
HWY_INLINE VecF less_isovalue(VecF values, double isovalue, bool is_single) {
  if (is_single) return hn::Sub(values, hn::Set(floats, static_cast<float>(isovalue)));
  VecD parts[parts_of_floats];
  const VecD least = hn::Set(doubles, -static_cast<double>(std::numeric_limits<float>::denorm_min()));
  for (std::size_t part = 0; part < parts_of_floats; ++part) {
    const VecD difference = hn::Sub(as_doubles(values, part), hn::Set(doubles, isovalue));
    parts[part] = hn::IfThenElse(hn::Lt(difference, hn::Zero(doubles)), hn::Min(difference, least), difference);
  }
  return as_floats(parts);
}

/// Reads the samples of a block of stored bricks, minus the isovalue.
template <class T>
HWY_INLINE void fetch_from_bricks(const SampleSource& source, const int* first, double isovalue, float* to) {
  HWY_ALIGN T values[128] = {};
  read_block_from_bricks(source, first, values);
  if constexpr (std::is_same_v<T, float>)
    for (std::size_t i = 0; i < 128; i += float_lanes)
      hn::Store(less_isovalue(hn::Load(floats, values + i), isovalue, false), floats, to + i);
  else
    for (std::size_t i = 0; i < BlockSamples::size; ++i) to[i] = side_keeping_difference(values[i], isovalue);
  for (std::size_t i = BlockSamples::size; i < 128; ++i) to[i] = 0;
}

/// Reads the samples of a block, minus the isovalue.
template <class T>
HWY_INLINE void fetch_differences(const SampleSource& source, const int* block, double isovalue, BlockSamples& out) {
  const T* samples = static_cast<const T*>(source.samples);
  const int first[3] = {4 * block[0], 4 * block[1], 4 * block[2]};
  if constexpr (std::is_floating_point_v<T>) {
    if (source.bricks.slots != nullptr) {
      fetch_from_bricks<T>(source, first, isovalue, out.difference);
      return;
    }
  }
  const bool is_whole =
      first[0] + 4 < source.count[0] && first[1] + 4 < source.count[1] && first[2] + 4 < source.count[2];
  const auto isovalue_float = static_cast<float>(isovalue);
  const bool in_float = is_exact_in_float<T> && static_cast<double>(isovalue_float) == isovalue;
  if constexpr (is_exact_in_float<T> && float_lanes == 16) {
    if (in_float && is_whole && source.has_whole_bricks) {
      fetch_bricks<T>(source, first, isovalue_float, out.difference);
      for (std::size_t i = BlockSamples::size; i < 128; ++i) out.difference[i] = 0;
      return;
    }
  }
  if (is_exact_in_float<T> && is_whole && source.has_whole_rows) {
    const std::uint64_t* x = source.address[0] + first[0];
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 5; ++j) {
        const T* from = samples + source.address[1][first[1] + j] + source.address[2][first[2] + k];
        float* to = out.difference + 5 * j + 25 * k;
        if (in_float)
          fetch_row_in_float(from + x[0], isovalue_float, to);
        else
          fetch_row(from + x[0], isovalue, to);
        to[4] = in_float ? static_cast<float>(from[x[4]]) - isovalue_float
                         : side_keeping_difference(static_cast<double>(from[x[4]]), isovalue);
      }
  } else {
    const auto place = [&](int axis, int i) {
      const int at = first[axis] + i, last = source.count[axis] - 1;
      return source.address[axis][at < last ? at : last];
    };
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 5; ++j) {
        const T* from = samples + place(1, j) + place(2, k);
        for (int i = 0; i < 5; ++i)
          out.difference[i + 5 * j + 25 * k] =
              side_keeping_difference(static_cast<double>(from[place(0, i)]), isovalue);
      }
  }
  for (std::size_t i = BlockSamples::size; i < 128; ++i) out.difference[i] = 0;
}

/// @param block  position among the volume's blocks, not mirrored
template <class T>
HWY_NOINLINE void fetch_block(const SampleSource& source, const int* block, double isovalue, BlockSamples& out) {
  fetch_differences<T>(source, block, isovalue, out);
  find_active_cells(existing_cells(source, block), 0, out);
  if (std::is_floating_point_v<T> && source.has_gaps) leave_out_gaps(out);
}

/// Types whose values all are numbers of single precision.
template <class T>
inline constexpr bool is_single = is_exact_in_float<T> || std::is_same_v<T, float>;

/// Reads the unchanged samples of such types, for use with several isovalues. Does nothing for
/// other types.
template <class T>
HWY_NOINLINE void fetch_values(const SampleSource& source, const int* block, BlockSamples& out) {
  if constexpr (is_single<T>) fetch_differences<T>(source, block, 0, out);
}

/// Prefetches the samples of a block if they are stored in few pieces: in eight bricks.
template <class T>
HWY_NOINLINE void ask_for_block(const SampleSource& source, const int* block) {
  if (!source.has_whole_bricks) return;
  constexpr std::size_t in_line = 64 / sizeof(T), in_brick = 64, in_layer = 16;
  const T* samples = static_cast<const T*>(source.samples);
  std::uint64_t at[3][2];
  for (int a = 0; a < 3; ++a)
    for (int end = 0; end < 2; ++end) {
      const int i = 4 * (block[a] + end), last = source.count[a] - 1;
      at[a][end] = source.address[a][i < last ? i : last];
    }
  for (std::size_t brick = 0; brick < 8; ++brick) {
    const T* first = samples + at[0][brick & 1] + at[1][brick >> 1 & 1] + at[2][brick >> 2];
    const std::size_t needed = brick < 4 ? in_brick : in_layer;
    for (std::size_t i = 0; i < needed; i += in_line) hwy::Prefetch(first + i);
  }
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

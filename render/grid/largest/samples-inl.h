// How the search for largest values reads a field: ranges of regions, samples of blocks, corners of
// cells.
#if defined(RHORAY_WIDE_MAXIMUM_SAMPLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_SAMPLES_INL_H
#undef RHORAY_WIDE_MAXIMUM_SAMPLES_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_SAMPLES_INL_H
#endif

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <hwy/highway.h>

#include "render/grid/brick_samples.h"
#include "render/grid/largest/parts.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

inline constexpr double nothing = -std::numeric_limits<double>::infinity();

struct Range {
  double lo, hi;
};

template <class T>
HWY_INLINE Range stored_range(const void* first, std::ptrdiff_t at) {
  const T* ranges = static_cast<const T*>(first) + 2 * at;
  return {static_cast<double>(ranges[0]), static_cast<double>(ranges[1])};
}

HWY_INLINE std::size_t place_of(const StoredRanges& level, const int* region) {
  return (static_cast<std::size_t>(region[2]) * static_cast<std::size_t>(level.count[1]) +
          static_cast<std::size_t>(region[1])) *
             static_cast<std::size_t>(level.count[0]) +
         static_cast<std::size_t>(region[0]);
}

/// The range of a region of the volume; hi is -infinity where nothing in it has data.
HWY_INLINE Range range_of(const MaximumField& field, const StoredRanges& level, const int* region) {
  using formats::ElementType;
  const auto at = static_cast<std::ptrdiff_t>(place_of(level, region));
  const Range range = [&]() HWY_ATTR {
    switch (field.type) {
      case ElementType::U8:
        return stored_range<std::uint8_t>(level.first, at);
      case ElementType::I8:
        return stored_range<std::int8_t>(level.first, at);
      case ElementType::U16:
        return stored_range<std::uint16_t>(level.first, at);
      case ElementType::I16:
        return stored_range<std::int16_t>(level.first, at);
      case ElementType::U32:
        return stored_range<std::uint32_t>(level.first, at);
      case ElementType::I32:
        return stored_range<std::int32_t>(level.first, at);
      case ElementType::F32:
        return stored_range<float>(level.first, at);
      default:
        return stored_range<double>(level.first, at);
    }
  }();
  return range.lo <= range.hi ? range : Range{nothing, nothing};
}

/// A power of two that scales a block's range to about 1.
HWY_INLINE double unit_for(double range, bool in_float) {
  const auto exponent = static_cast<int>(std::bit_cast<std::uint64_t>(range) >> 52) - 1023;
  if (range == 0) return 1;
  const int largest = in_float ? 126 : 1022;
  const int wanted = -exponent < largest ? (-exponent > -largest ? -exponent : -largest) : largest;
  return std::bit_cast<double>(static_cast<std::uint64_t>(wanted + 1023) << 52);
}

/// Types whose values, and the differences between those of a block, single precision holds as
/// accurately as it holds the samples.
template <class T>
inline constexpr bool fits_float = sizeof(T) <= 2 || std::is_same_v<T, float>;

HWY_INLINE bool in_float(formats::ElementType type) {
  using formats::ElementType;
  return type != ElementType::U32 && type != ElementType::I32 && type != ElementType::F64;
}

inline constexpr hn::CappedTag<float, 4> row_of_floats{};
inline constexpr hn::Rebind<std::int32_t, decltype(row_of_floats)> row_of_ints{};

template <class T>
HWY_INLINE hn::Vec<decltype(row_of_floats)> load_row(const T* from) {
  if constexpr (std::is_same_v<T, float>)
    return hn::LoadU(row_of_floats, from);
  else
    return hn::ConvertTo(row_of_floats,
                         hn::PromoteTo(row_of_ints, hn::LoadU(hn::Rebind<T, decltype(row_of_floats)>(), from)));
}

/// Finds each cell's largest sample, stored at the index of its lowest corner. Cells that touch a
/// sample without data count as if they reached the block's largest. Reason: single precision does
/// not tell for certain which cell a ray is in, and a cell without data says nothing about its
/// neighbour.
HWY_INLINE void find_largest(bool has_gaps, MaximumBlock& block) {
  const auto larger_of = [&](const float* from, std::size_t further, std::size_t count) HWY_ATTR {
    for (std::size_t i = 0; i < count; i += float_lanes)
      hn::Store(hn::Max(hn::Load(floats, from + i), hn::LoadU(floats, from + i + further)), floats, block.largest + i);
  };
  if (has_gaps) {
    HWY_ALIGN float filled[160];
    for (std::size_t i = 0; i < 160; i += float_lanes) {
      const VecF sample = hn::Load(floats, block.sample + i);
      const MaskF is_number = hn::Le(hn::Abs(sample), hn::Set(floats, std::numeric_limits<float>::max()));
      hn::Store(hn::IfThenElseZero(is_number, sample), floats, filled + i);
    }
    larger_of(filled, 1, 128);
  } else {
    larger_of(block.sample, 1, 128);
  }
  larger_of(block.largest, 5, 128);
  larger_of(block.largest, 25, 96);
}

/// Reads samples as (sample - highest) * unit, rounded once, and finds each cell's largest.
/// @param place  position of the block in the volume
template <class T>
HWY_NOINLINE void fetch(const MaximumField& field, const int* place, double highest, double unit, MaximumBlock& block) {
  const SampleSource& source = field.source;
  const T* samples = static_cast<const T*>(source.samples);
  if constexpr (std::is_floating_point_v<T>) {
    if (source.bricks.slots != nullptr) {
      const int first[3] = {4 * place[0], 4 * place[1], 4 * place[2]};
      T values[BlockSamples::size];
      read_block_from_bricks(source, first, values);
      for (std::size_t i = 0; i < BlockSamples::size; ++i)
        block.sample[i] = static_cast<float>((static_cast<double>(values[i]) - highest) * unit);
      find_largest(field.has_gaps, block);
      return;
    }
  }
  std::uint64_t address[3][5];
  bool is_whole = source.has_whole_rows;
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 5; ++i) {
      const int at = 4 * place[a] + i, last = source.count[a] - 1;
      is_whole = is_whole && at <= last;
      address[a][i] = source.address[a][at < last ? at : last];
    }
  const auto each_row = [&](auto&& read) HWY_ATTR {
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 5; ++j) read(samples + address[1][j] + address[2][k], block.sample + 5 * j + 25 * k);
  };
  if constexpr (fits_float<T>) {
    if (is_whole) {
      const float highest_float = static_cast<float>(highest), unit_float = static_cast<float>(unit);
      const auto highest_row = hn::Set(row_of_floats, highest_float), unit_row = hn::Set(row_of_floats, unit_float);
      each_row([&](const T* row, float* to) HWY_ATTR {
        for (std::size_t i = 0; i < 4; i += hn::MaxLanes(row_of_floats))
          hn::StoreU(hn::Mul(hn::Sub(load_row(row + address[0][0] + i), highest_row), unit_row), row_of_floats, to + i);
        to[4] = (static_cast<float>(row[address[0][4]]) - highest_float) * unit_float;
      });
      find_largest(field.has_gaps, block);
      return;
    }
  }
  each_row([&](const T* row, float* to) HWY_ATTR {
    for (int i = 0; i < 5; ++i) to[i] = static_cast<float>((static_cast<double>(row[address[0][i]]) - highest) * unit);
  });
  find_largest(field.has_gaps, block);
}

HWY_INLINE void fetch_of_type(const MaximumField& field, const int* place, double highest, double unit,
                              MaximumBlock& block) {
  using formats::ElementType;
  switch (field.type) {
    case ElementType::U8:
      return fetch<std::uint8_t>(field, place, highest, unit, block);
    case ElementType::I8:
      return fetch<std::int8_t>(field, place, highest, unit, block);
    case ElementType::U16:
      return fetch<std::uint16_t>(field, place, highest, unit, block);
    case ElementType::I16:
      return fetch<std::int16_t>(field, place, highest, unit, block);
    case ElementType::U32:
      return fetch<std::uint32_t>(field, place, highest, unit, block);
    case ElementType::I32:
      return fetch<std::int32_t>(field, place, highest, unit, block);
    case ElementType::F32:
      return fetch<float>(field, place, highest, unit, block);
    default:
      return fetch<double>(field, place, highest, unit, block);
  }
}

/// Reads the corners of some candidates' cells. Integers are kept as they are, to be converted side
/// by side.
template <class T>
HWY_NOINLINE void read_corners(const SampleSource& source, const CandidateList& looks, std::size_t first,
                               std::size_t end, LookCorners& corners) {
  const T* samples = static_cast<const T*>(source.samples);
  for (std::size_t i = first; i < end; ++i) {
    const std::uint64_t* x = source.address[0] + looks.cell[0][i];
    const std::uint64_t* y = source.address[1] + looks.cell[1][i];
    const std::uint64_t* z = source.address[2] + looks.cell[2][i];
    for (int c = 0; c < 8; ++c) {
      const std::uint64_t at = x[c & 1] + y[c >> 1 & 1] + z[c >> 2];
      const bool is_in_brick = std::is_floating_point_v<T> && source.bricks.slots != nullptr;
      const T sample = is_in_brick ? sample_in_brick<T>(source, at) : samples[at];
      if constexpr (sizeof(T) <= 2)
        corners.small[c][i] = sample;
      else
        corners.other[c][i] = static_cast<double>(sample);
    }
  }
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

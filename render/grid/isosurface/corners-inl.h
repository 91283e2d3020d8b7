// Corners of cells read directly from a volume's samples, one cell per lane.
#if defined(RHORAY_WIDE_CORNERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_CORNERS_INL_H
#undef RHORAY_WIDE_CORNERS_INL_H
#else
#define RHORAY_WIDE_CORNERS_INL_H
#endif

#include <bit>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

#include "render/grid/block_samples.h"
#include "render/grid/brick_samples.h"
#include "render/grid/isosurface/fetch-inl.h"
#include "render/grid/isosurface/scattered.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Reads the corners of the cells of some lanes, minus the isovalue: the same numbers as
/// fetch_block.
/// @param lanes   bits of the lanes to read; numbers of the others keep their value
/// @param upward  per axis, from a cell's lowest corner to the others: 1, or -1 where the rays see
///                it mirrored
template <class T>
HWY_NOINLINE void load_corners(const SampleSource& source, const int* upward, double isovalue, std::uint64_t lanes,
                               CornersScratch& cells) {
  const T* samples = static_cast<const T*>(source.samples);
  const auto isovalue_float = static_cast<float>(isovalue);
  const bool in_float = is_exact_in_float<T> && static_cast<double>(isovalue_float) == isovalue;
  for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
    std::uint64_t address[3][2];
    for (int a = 0; a < 3; ++a) {
      const std::uint64_t* at = source.address[a] + cells.lowest[a][lane];
      address[a][0] = at[0], address[a][1] = at[upward[a]];
    }
    for (int c = 0; c < 8; ++c) {
      const std::uint64_t at = address[0][c & 1] + address[1][c >> 1 & 1] + address[2][c >> 2];
      const bool is_in_brick = std::is_floating_point_v<T> && source.bricks.slots != nullptr;
      const T sample = is_in_brick ? sample_in_brick<T>(source, at) : samples[at];
      if constexpr (is_exact_in_float<T>) cells.stored[c][lane] = sample;
      if (!in_float) cells.difference[c][lane] = side_keeping_difference(static_cast<double>(sample), isovalue);
    }
  }
  if constexpr (is_exact_in_float<T>)
    if (in_float)
      for (int c = 0; c < 8; ++c)
        hn::Store(hn::Sub(hn::ConvertTo(floats, hn::Load(ints, cells.stored[c])), hn::Set(floats, isovalue_float)),
                  floats, cells.difference[c]);
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

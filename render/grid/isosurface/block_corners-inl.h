// Corners of cells from the kept samples of blocks, each lane from its own block.
#if defined(RHORAY_WIDE_BLOCK_CORNERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_BLOCK_CORNERS_INL_H
#undef RHORAY_WIDE_BLOCK_CORNERS_INL_H
#else
#define RHORAY_WIDE_BLOCK_CORNERS_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/block_samples.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Offsets of the corners of cells among the samples of a mirrored block.
class BlockCorners {
 public:
  explicit HWY_INLINE BlockCorners(const MirroredLattice& lattice) {
    for (int a = 0; a < 3; ++a) {
      const int stride = a == 0 ? 1 : a == 1 ? 5 : 25;
      stride_[a] = lattice.is_mirrored(a) ? -stride : stride;
      if (lattice.is_mirrored(a)) lowest_sample_ += 4 * stride;
    }
  }

  /// The corners of the cells of the lanes in `asked`; other lanes get those of some cell.
  /// @param cell     in the mirrored block, 0 to 3 each
  /// @param samples  offset of the samples of the lane's block among those of all blocks
  /// @param blocks   the first of all blocks
  HWY_INLINE Corners of(const VecF* cell, VecI samples, const BlockSamples* blocks, MaskF asked) const {
    VecF place = hn::Set(floats, static_cast<float>(lowest_sample_));
    for (int a = 0; a < 3; ++a) place = hn::MulAdd(cell[a], hn::Set(floats, static_cast<float>(stride_[a])), place);
    const VecI index = hn::Add(hn::ConvertTo(ints, place), samples);
    const VecI first = hn::IfThenElse(hn::RebindMask(ints, asked), index, hn::Set(ints, lowest_sample_));
    const float* from_first = blocks[0].difference;
    Corners corners;
#if HWY_TARGET <= HWY_AVX2
    // Read both corners of an edge along x at once, as a number of twice the size.
    constexpr hn::Rebind<std::int64_t, Doubles> offsets;
    const bool is_mirrored = stride_[0] < 0;
    const auto from = [&](auto half) HWY_ATTR { return hn::ShiftLeft<2>(hn::PromoteTo(offsets, half)); };
    const auto low = from(hn::LowerHalf(half_ints, first)), high = from(hn::UpperHalf(half_ints, first));
    for (int edge = 0; edge < 4; ++edge) {
      const int offset = (edge & 1 ? stride_[1] : 0) + (edge & 2 ? stride_[2] : 0) - (is_mirrored ? 1 : 0);
      const auto* pairs = reinterpret_cast<const double*>(from_first + offset);
      const VecF low_pairs = hn::BitCast(floats, hn::GatherOffset(doubles, pairs, low));
      const VecF high_pairs = hn::BitCast(floats, hn::GatherOffset(doubles, pairs, high));
      corners.f[2 * edge + is_mirrored] = hn::ConcatEven(floats, high_pairs, low_pairs);
      corners.f[2 * edge + !is_mirrored] = hn::ConcatOdd(floats, high_pairs, low_pairs);
    }
#else
    for (int c = 0; c < 8; ++c) {
      const int offset = (c & 1 ? stride_[0] : 0) + (c & 2 ? stride_[1] : 0) + (c & 4 ? stride_[2] : 0);
      corners.f[c] = hn::GatherIndex(floats, from_first + offset, first);
    }
#endif
    return corners;
  }

 private:
  int stride_[3];          ///< from a cell's lower to its upper sample, by mirrored axis
  int lowest_sample_ = 0;  ///< of the mirrored block
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

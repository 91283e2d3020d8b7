// Bounds from the blocks of a slab for the rays that pass it.
#if defined(RHORAY_WIDE_MAXIMUM_SLAB_BLOCKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_SLAB_BLOCKS_INL_H
#undef RHORAY_WIDE_MAXIMUM_SLAB_BLOCKS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_SLAB_BLOCKS_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/grid/largest/parts.h"
#include "render/grid/largest/words-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

/// The ranges of adjacent blocks, in the mirrored lattice.
template <class T>
class BlockRanges {
 public:
  /// @param axes  the major one and the minor ones
  HWY_INLINE BlockRanges(const StoredRanges& stored, const MirroredLattice& lattice, const int* axes, int slab,
                         const int* first) {
    const std::ptrdiff_t stride[3] = {1, stored.count[0],
                                      static_cast<std::ptrdiff_t>(stored.count[0]) * stored.count[1]};
    const int at[3] = {slab, first[0], first[1]};
    std::ptrdiff_t place = 0;
    for (int i = 0; i < 3; ++i) place += stride[axes[i]] * lattice.block(axes[i], at[i]);
    first_ = static_cast<const T*>(stored.first) + 2 * place;
    for (int m = 0; m < 2; ++m) step_[m] = (lattice.is_mirrored(axes[1 + m]) ? -2 : 2) * stride[axes[1 + m]];
  }

  /// Smallest and largest sample of a block, given relative to the first block.
  HWY_INLINE const T* at(int i, int j) const { return first_ + i * step_[0] + j * step_[1]; }

 private:
  const T* first_;
  std::ptrdiff_t step_[2];
};

/// The largest value of each block of a rectangle.
struct SlabBlocks {
  static constexpr int most_columns = float_lanes, most_rows = 16;

  HWY_ALIGN std::int32_t largest[most_rows][most_columns];
  std::int32_t lowest;  ///< smallest value of all blocks
  int first[2];         ///< in the mirrored lattice

  template <class T>
  HWY_INLINE SlabBlocks(const BlockRanges<T>& ranges, const int* first_block, const int* last_block)
      : lowest(std::numeric_limits<std::int32_t>::max()), first{first_block[0], first_block[1]} {
    for (int j = 0; j <= last_block[1] - first[1]; ++j)
      for (int i = 0; i <= last_block[0] - first[0]; ++i) {
        const T* range = ranges.at(i, j);
        largest[j][i] = range[1];
        lowest = range[0] < lowest ? range[0] : lowest;
      }
  }

  /// The largest value of the blocks from one to another.
  HWY_INLINE std::int32_t largest_between(const int* from, const int* to) const {
    const VecI none = hn::Set(ints, std::numeric_limits<std::int32_t>::min());
    VecI most = none;
    for (int j = from[1]; j <= to[1]; ++j) most = hn::Max(most, hn::Load(ints, largest[j - first[1]]));
    const auto columns = mask_of(ints, (2u << (to[0] - first[0])) - (1u << (from[0] - first[0])));
    return hn::GetLane(hn::MaxOfLanes(ints, hn::IfThenElse(columns, most, none)));
  }
};

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

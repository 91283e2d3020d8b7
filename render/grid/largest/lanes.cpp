// The search for the largest values on rays, compiled once per machine.

#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/grid/largest/lanes.cpp"  // relative to the repository root
// Comes first: this file is included again for each machine.
#include <hwy/foreach_target.h>

#include <bit>
#include <cstddef>
#include <limits>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "render/grid/largest/blocks-inl.h"
#include "render/grid/largest/candidates-inl.h"
#include "render/grid/largest/groups-inl.h"
#include "render/grid/largest/parts.h"
#include "render/grid/largest/samples-inl.h"
#include "render/grid/largest/slabs-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/grid/largest/sweep-inl.h"
#include "render/traverse/frustum_walk.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"
#include "render/traverse/on_machine.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

/// The search for one group of rays: regions in the order of their largest value, the largest
/// first.
class Search {
 public:
  Search(const MaximumField& field, const RayArrays& rays, MaximumScratch& scratch, const MirroredLattice& lattice,
         const Frustum& frustum)
      : state_(field, rays, scratch, lattice, frustum),
        looks_(state_),
        blocks_(state_, looks_),
        slabs_(state_, looks_),
        field_(field),
        scratch_(scratch) {}

  void run() {
#if RHORAY_HAS_WORD_TABLES
    PlaneSweep planes(state_, looks_);
    if (planes.fits()) {
      planes.run();
      return finish();
    }
#endif
    put_nodes();
    RegionQueue& queue = scratch_.queue;
    unsigned taken = 0;
    for (int bucket; (bucket = queue.highest_bucket()) >= 0 && bucket >= queue.bucket_of(state_.lowest_reached);) {
      const RegionQueue::Region region = queue.take(bucket);
      ask_for_next();
      // Finding it anew takes longer than some regions that it would have saved.
      if (++taken % 16 == 0 && state_.has_risen) state_.find_lowest_reached();
      if (region.largest < state_.lowest_reached) continue;
      const int at[3] = {region.at[0], region.at[1], region.at[2]};
      const int slab = at[state_.frustum.major] / (region.is_block ? 4 : 1);
      if (slabs_.is_swept(slab)) continue;
      if (!region.is_block) {
        if (!slabs_.sweep(slab, queue, bucket)) open_node(at, region.largest);
      } else if (!slabs_.sweep_around_block(slab, queue, bucket)) {
        blocks_.look_into(at);
      }
    }
    finish();
  }

 private:
  void finish() {
    looks_.decide();
    for (std::size_t r = 0; r < scratch_.rays.count; ++r)
      scratch_.cost[scratch_.rays.index[r]] += static_cast<std::uint32_t>(scratch_.visits[r]);
  }

  /// Prefetches what the region that is likely to be taken next needs.
  HWY_INLINE void ask_for_next() const {
    const int bucket = scratch_.queue.highest_bucket();
    if (bucket < 0) return;
    const RegionQueue::Region& region = scratch_.queue.first_in(bucket);
    const int at[3] = {region.at[0], region.at[1], region.at[2]};
    if (region.is_block)
      blocks_.ask_for(at);
    else
      ask_for_blocks(at);
  }

  /// Prefetches the ranges of a node's blocks.
  HWY_INLINE void ask_for_blocks(const int* node) const {
    int first[3];
    for (int a = 0; a < 3; ++a) {
      first[a] = 4 * state_.lattice.node(a, node[a]);
      if (first[a] < 0 || first[a] + 4 > field_.blocks.count[a]) return;
    }
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 4; ++j) {
        const int block[3] = {first[0], first[1] + j, first[2] + k};
        hwy::Prefetch(static_cast<const char*>(field_.blocks.first) +
                      2 * field_.sample_bytes * place_of(field_.blocks, block));
      }
  }

  HWY_INLINE void put_nodes() {
    const int w = state_.frustum.major, u = state_.frustum.minor[0], v = state_.frustum.minor[1];
    const int count = state_.lattice.node_count[w];
    const int first = floored_within(state_.frustum.first / 16, 0, count - 1),
              last = floored_within(state_.frustum.last / 16, 0, count - 1);
    const auto each_node = [&](auto&& act) HWY_ATTR {
      for (int slab = last; slab >= first; --slab) {
        const SlabRectangle cells = rectangle_in_slab(state_.frustum, slab, 16, state_.lattice.node_count);
        for (int j = cells.last[1]; j >= cells.first[1]; --j)
          for (int i = cells.last[0]; i >= cells.first[0]; --i) {
            int node[3], place[3];
            node[w] = slab, node[u] = i, node[v] = j;
            if (!state_.find_in_file(node, false, field_.nodes, place)) continue;
            const double largest =
                field_.nodes.first ? range_of(field_, field_.nodes, place).hi : std::numeric_limits<double>::max();
            if (largest > nothing) act(static_cast<const int*>(node), largest);
          }
      }
    };
    double lowest = std::numeric_limits<double>::infinity(), highest = nothing;
    each_node([&](const int*, double largest) HWY_ATTR {
      ++scratch_.regions;
      lowest = largest < lowest ? largest : lowest, highest = largest > highest ? largest : highest;
    });
    scratch_.queue.clear(lowest, highest);
    each_node([&](const int* node, double largest) HWY_ATTR {
      if (!scratch_.queue.put(largest, node, false)) open_node(node, largest);
    });
  }

  HWY_NOINLINE void open_node(const int* node, double largest) {
    const SearchState::Bounds bounds = state_.bounds_of(node, 16, float_not_below(largest));
    bool any = false;
    for (std::uint64_t bits = state_.vectors_through(node, 16, float_not_below(largest)); bits != 0 && !any;
         bits &= bits - 1)
      any = !hn::AllFalse(
          floats, state_.rays_through(bounds, static_cast<std::size_t>(std::countr_zero(bits)) * float_lanes).rays);
    if (!any) return;
    switch (field_.type) {
      case formats::ElementType::U8:
        return put_blocks<std::uint8_t>(node);
      case formats::ElementType::I8:
        return put_blocks<std::int8_t>(node);
      case formats::ElementType::U16:
        return put_blocks<std::uint16_t>(node);
      case formats::ElementType::I16:
        return put_blocks<std::int16_t>(node);
      case formats::ElementType::U32:
        return put_blocks<std::uint32_t>(node);
      case formats::ElementType::I32:
        return put_blocks<std::int32_t>(node);
      case formats::ElementType::F32:
        return put_blocks<float>(node);
      default:
        return put_blocks<double>(node);
    }
  }

  /// Adds the blocks of a node that the frustum meets.
  template <class T>
  HWY_INLINE void put_blocks(const int* node) {
    const int w = state_.frustum.major, u = state_.frustum.minor[0], v = state_.frustum.minor[1];
    const int block_count[3] = {4 * state_.lattice.node_count[0], 4 * state_.lattice.node_count[1],
                                4 * state_.lattice.node_count[2]};
    // Offset of a block in the volume, on an axis: `zero` for the lattice's block 0, and so on
    // upwards or downwards by `step`. Blocks from begin to before end exist.
    const int* const count = field_.blocks.count;
    const std::ptrdiff_t stride[3] = {1, count[0], static_cast<std::ptrdiff_t>(count[0]) * count[1]};
    std::ptrdiff_t zero = 0, step[3];
    int begin[3], end[3];
    for (int a = 0; a < 3; ++a) {
      const int place = state_.lattice.block(a, 0);
      const bool is_mirrored = state_.lattice.is_mirrored(a);
      begin[a] = is_mirrored ? place - count[a] + 1 : 0, end[a] = is_mirrored ? place + 1 : count[a];
      zero += stride[a] * place, step[a] = is_mirrored ? -stride[a] : stride[a];
    }
    const T* const ranges = static_cast<const T*>(field_.blocks.first);
    for (int s = 3; s >= 0; --s) {
      int block[3];
      block[w] = 4 * node[w] + s;
      if (block[w] < begin[w] || block[w] >= end[w]) continue;
      const SlabRectangle cells = rectangle_in_slab(state_.frustum, block[w], 4, block_count);
      const auto first = [&](int m, int axis) HWY_ATTR {
        const int low = 4 * node[axis] > begin[axis] ? 4 * node[axis] : begin[axis];
        return cells.first[m] > low ? cells.first[m] : low;
      };
      const auto last = [&](int m, int axis) HWY_ATTR {
        const int high = 4 * node[axis] + 4 < end[axis] ? 4 * node[axis] + 3 : end[axis] - 1;
        return cells.last[m] < high ? cells.last[m] : high;
      };
      for (block[v] = last(1, v); block[v] >= first(1, v); --block[v])
        for (block[u] = last(0, u); block[u] >= first(0, u); --block[u]) {
          const T* const range = ranges + 2 * (zero + block[w] * step[w] + block[v] * step[v] + block[u] * step[u]);
          ++scratch_.regions;
          const auto largest = static_cast<double>(range[1]);
          if (!(range[0] <= range[1]) || !(largest > nothing) || largest < state_.lowest_reached) continue;
          if (!scratch_.queue.put(largest, block, true)) blocks_.look_into(block);
        }
    }
  }

  SearchState state_;
  CandidateRefinement looks_;
  BlockWalk blocks_;
  SlabSweep slabs_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
};

void largest_values(const MaximumField& field, const RayArrays& rays, std::size_t count, MaximumScratch& scratch) {
  const auto search = [&](const MirroredLattice& lattice, const Frustum& frustum)
                          HWY_ATTR { Search(field, rays, scratch, lattice, frustum).run(); };
  for_each_search(rays, count, field.leaf_count, field.node_count, scratch.group, scratch.rays, search);
}

}  // namespace
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rhoray::render::wide {

LargestValues largest_values_on(Machine machine) {
  RHORAY_RETURN_ON(machine, largest_values);
}

}  // namespace rhoray::render::wide
#endif
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/traverse/ray_group.h"

namespace rhoray::render::wide {

/// The positions of the rays of a group, each on its own path through an occupancy's trees.
struct alignas(64) BlockSearchScratch {
  /// Where the ray enters its block, or where it starts in it.
  double t[RayGroup::size];
  std::int64_t block[3][RayGroup::size];  ///< mirrored
  /// Bound on the error of all positions of the ray, in blocks.
  double error[RayGroup::size];
  /// Lowest corner of the block, in cells of the mirrored lattice.
  float corner[3][RayGroup::size];
  /// Bits of a node's children at coordinates 0 to 3 of an axis and behind them
  std::int64_t ahead[3][8];
};

/// Cells of several rays side by side, as stored in the volume.
struct alignas(64) CornersScratch {
  std::int32_t lowest[3][16];  ///< sample at the cell's lowest corner, as the rays see it
  std::int32_t stored[8][16];
  float difference[8][16];  ///< minus the isovalue
};

/// Rays of an octant that wait to become a group; some of them have been started.
struct WaitingRays {
  RayGroup rays;  ///< index: position in the batch
  BlockSearchScratch places;
  std::int32_t visits[RayGroup::size];
  std::uint64_t inside, has_side;  ///< the side that the rays are on, as in GroupWalk
  std::uint64_t starting;          ///< rays that start in a crossing, as in GroupWalk
  /// Rays that have a position; of these, the rays that have yet to look for a block there
  std::uint64_t under_way, new_there;

  void clear() {
    rays.count = 0, rays.is_in_order = false;
    inside = has_side = starting = under_way = new_there = 0;
  }
};

/// What the kernel keeps for scattered rays.
struct ScatteredScratch {
  ScatteredScratch() {
    for (unsigned octant = 0; octant < 8; ++octant) waiting[octant].clear(), waiting[octant].rays.octant = octant;
  }

  BlockSearchScratch search;
  CornersScratch corners;
  RayGroup joining;        ///< rays about to be added to the waiting ones
  WaitingRays waiting[8];  ///< by octant
};

}  // namespace rhoray::render::wide

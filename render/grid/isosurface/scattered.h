#pragma once

#include <cstddef>
#include <cstdint>

#include "render/traverse/ray_group.h"

namespace rhoray::render::wide {

/// Where the rays of a group are, each on its own way through an occupancy's trees.
struct alignas(64) BlockSearchScratch {
  double t[RayGroup::size];               ///< when the ray enters its block, or where it starts in it
  std::int64_t block[3][RayGroup::size];  ///< mirrored
  double error[RayGroup::size];           ///< more than any of the ray's places is off by, in blocks
  float corner[3][RayGroup::size];        ///< lowest corner of the block, in cells of the mirrored lattice
  std::int64_t ahead[3][8];               ///< bits of a node's children at 0 to 3 of an axis, and of those behind
};

/// Cells of rays side by side, as the volume has them.
struct alignas(64) CornersScratch {
  std::int32_t lowest[3][16];  ///< sample at the cell's lowest corner, as the rays see it
  std::int32_t stored[8][16];
  float difference[8][16];  ///< less the isovalue
};

/// Rays of an octant that wait to be a group, some of them under way.
struct WaitingRays {
  RayGroup rays;  ///< index: place in the batch
  BlockSearchScratch places;
  std::int32_t visits[RayGroup::size];
  std::uint64_t inside, has_side;      ///< the side that they are on, as GroupWalk has it
  std::uint64_t starting;              ///< likewise
  std::uint64_t under_way, new_there;  ///< those that have a place; of these, those that are to look for a block there

  void clear() {
    rays.count = 0, rays.is_in_order = false;
    inside = has_side = starting = under_way = new_there = 0;
  }
};

/// What the kernel keeps for rays that go their own ways.
struct ScatteredScratch {
  ScatteredScratch() {
    for (unsigned octant = 0; octant < 8; ++octant) waiting[octant].clear(), waiting[octant].rays.octant = octant;
  }

  BlockSearchScratch search;
  CornersScratch corners;
  RayGroup joining;        ///< rays on their way to those that wait
  WaitingRays waiting[8];  ///< by octant
};

}  // namespace rhoray::render::wide

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "formats/packed_file.h"
#include "render/grid/block_samples.h"
#include "render/grid/isosurface/scattered.h"
#include "render/grid/reference/resumed.h"
#include "render/query/batch_arrays.h"
#include "render/query/kernels.h"
#include "render/traverse/ray_group.h"

/// What the sources of the wide isosurface kernel hand to the part that is compiled once per machine.
namespace rhoray::render::wide {

/// How a cell is searched.
enum class Search { preview, bracketed, certified };

/// One surface of one volume.
struct Surface {
  SampleSource source;
  formats::ElementType type;
  int leaf_count[3];
  std::array<int, 3> node_count;
  const std::uint64_t* nodes;
  const std::uint64_t* super_nodes;
  double isovalue;
  bool time_phases;
};

/// Which blocks a group's rays may pass, in single precision with a margin: a ray passes plane k of an axis of the
/// mirrored lattice on its way at k inverse_slope + near, or later, and at k inverse_slope + far, or sooner.
struct alignas(64) BlockFilter {
  float near[3][RayGroup::size], far[3][RayGroup::size];
  float first[RayGroup::size], last[RayGroup::size];  ///< the part of the way inside the lattice
};

/// A block that some rays of the group are still to pass.
struct BlockAhead {
  static constexpr int place_bits[3] = {3, 2, 2};  ///< of a block's position, that tell where its samples are kept
  static constexpr std::size_t most = 24;          ///< in a list

  int block[3];                                       ///< mirrored
  std::uint64_t rays;                                 ///< that may pass it
  std::uint64_t taken;                                ///< of which it is the next one
  std::int32_t samples = -1;                          ///< where its samples begin among all kept; -1: not fetched
  std::uint64_t present = 0, active = 0, inside = 0;  ///< of BlockSamples, mirrored
  float range = 0;                                    ///< certified: of BlockSamples
};

/// Blocks in the order in which rays pass them.
template <class Block>
struct ListOfBlocks {
  static constexpr std::size_t capacity = Block::most;

  Block block[capacity];
  std::size_t count;
  std::uint64_t rays;  ///< that may pass one of them
  std::uint64_t places[1 << (Block::place_bits[0] + Block::place_bits[1] + Block::place_bits[2] -
                             6)];  ///< where their samples are kept
};
using BlocksAhead = ListOfBlocks<BlockAhead>;

/// Crossings of which the cell is known and the place in it is still to be refined, each in its ray's lane.
struct alignas(64) PendingHits {
  float corner[8][RayGroup::size];                        ///< of the cell, less the isovalue
  float in[3][RayGroup::size], out[3][RayGroup::size];    ///< where the ray enters and leaves the cell
  float way_in[RayGroup::size], way_out[RayGroup::size];  ///< from where it entered the block
  float low[RayGroup::size], high[RayGroup::size];        ///< the piece on which the cubic is monotone and changes side
  float way_error[RayGroup::size];                        ///< certified
  float cell[3][RayGroup::size];                          ///< in the mirrored lattice
  std::int32_t root_count[RayGroup::size];
  std::uint64_t rays;  ///< that have one
};

/// A ray of a batch that is left to another kernel; nothing that was written for it counts.
struct DoubtfulRay {
  std::uint32_t index;
  ResumedAt from;  ///< certified: where it is in doubt; else its start
};
struct DoubtfulRays {
  DoubtfulRay ray[RayGroup::size * 20];  ///< of a chunk, and of the groups that its scattered rays complete
  std::size_t count = 0;
};

/// What a thread keeps for the kernel.
struct alignas(64) IsosurfaceScratch {
  static constexpr std::size_t kept_blocks = 128;
  static constexpr std::uint64_t no_block = ~std::uint64_t{0};

  RayGroup group;
  float slope[3][RayGroup::size];          ///< along each axis, while the ray goes by 1 along its fastest one
  float inverse_slope[3][RayGroup::size];  ///< never_passed where the ray passes no plane
  double way_per_t[RayGroup::size], t_per_way[RayGroup::size];  ///< the way counted along the ray's fastest axis
  float position_error[RayGroup::size];  ///< certified: what double precision may have put the ray's points off by
  float steepest[RayGroup::size];        ///< certified: of inverse slopes, the largest of axes that are not slow
  double t_block[RayGroup::size];        ///< when each ray entered the last block that it passed
  std::int32_t visits[RayGroup::size];   ///< blocks and cells
  BlockFilter filter;
  BlocksAhead ahead;
  PendingHits pending;
  std::uint64_t block_key[kept_blocks];
  BlockSamples blocks[kept_blocks];
  ScatteredScratch scattered;
  std::uint64_t slow[3];  ///< certified: rays to which an axis is slow (error_of_ways)
  DoubtfulRays doubtful;
  std::shared_ptr<const Occupancy> occupancy;  ///< whose blocks are kept
  FewRays few;                                 ///< of the doubtful ones
};

/// What is compiled once per machine. Hits are written; what is no hit is left as it is, but for its cost. Rays in
/// doubt are added to those of the scratch memory.
struct CrossingKernels {
  /// Answers at most 64 rays of a batch, from `first` on, a multiple of 64. Rays that go their own ways may be left
  /// waiting.
  void (*answer)(const Surface& surface, const RayArrays& rays, std::size_t first, std::size_t count,
                 const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters);
  /// Answers those that wait.
  void (*answer_waiting)(const Surface& surface, const RayArrays& rays, const HitArrays& hits,
                         IsosurfaceScratch& scratch, KernelCounters& counters);
};

/// `baseline` is what the processor has of SSE4, or else one lane.
CrossingKernels crossing_kernels_on(Machine machine, Search search);

}  // namespace rhoray::render::wide

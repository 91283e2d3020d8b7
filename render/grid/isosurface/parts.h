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
#include "render/query/machine.h"
#include "render/traverse/ray_group.h"

/// The interface between the sources of the SIMD isosurface kernel and the part that is compiled
/// once per machine.
namespace rhoray::render::wide {

/// How a cell is searched.
enum class Search { preview, bracketed, certified };

/// One surface of one volume.
struct IsosurfaceQuery {
  SampleSource source;
  int leaf_count[3];
  std::array<int, 3> node_count;
  const std::uint64_t* nodes;
  const std::uint64_t* super_nodes;
  double isovalue;
  bool time_phases;
};

/// Which blocks a group's rays may pass, in single precision with a margin. A ray passes plane k of
/// an axis of the mirrored lattice not before k inverse_slope + near, and not after k inverse_slope
/// + far, measured along its way.
struct alignas(64) BlockFilter {
  float near[3][RayGroup::size], far[3][RayGroup::size];
  float first[RayGroup::size], last[RayGroup::size];  ///< the part of the way inside the lattice
};

/// A block that some rays of the group have yet to pass.
struct BlockAhead {
  /// Of a block's position; they select the slot in which its samples are kept
  static constexpr int place_bits[3] = {3, 2, 2};
  static constexpr std::size_t most = 24;  ///< most blocks in a list

  int block[3];         ///< mirrored
  std::uint64_t rays;   ///< rays that may pass it
  std::uint64_t taken;  ///< rays for which it is the next block
  /// Offset of its samples among all kept samples; -1: not fetched
  std::int32_t samples = -1;
  std::uint64_t present = 0, active = 0, inside = 0;  ///< as in BlockSamples, mirrored
  float range = 0;                                    ///< certified: as in BlockSamples
};

/// Blocks in the order in which rays pass them.
template <class Block>
struct ListOfBlocks {
  static constexpr std::size_t capacity = Block::most;

  Block block[capacity];
  std::size_t count;
  std::uint64_t rays;  ///< rays that may pass one of them
  std::uint64_t places[1 << (Block::place_bits[0] + Block::place_bits[1] + Block::place_bits[2] -
                             6)];  ///< slots in which their samples are kept, a bit each
};
using BlocksAhead = ListOfBlocks<BlockAhead>;

/// Crossings whose cell is known and whose position in it is still to be refined, each in its ray's
/// lane.
struct alignas(64) PendingHits {
  float corner[8][RayGroup::size];  ///< of the cell, minus the isovalue
  /// Where the ray enters and leaves the cell.
  float in[3][RayGroup::size], out[3][RayGroup::size];
  /// Measured from where it entered the block.
  float way_in[RayGroup::size], way_out[RayGroup::size];
  /// The piece on which the cubic is monotone and changes side.
  float low[RayGroup::size], high[RayGroup::size];
  float way_error[RayGroup::size];  ///< certified
  float cell[3][RayGroup::size];    ///< in the mirrored lattice
  std::int32_t root_count[RayGroup::size];
  std::uint64_t rays;  ///< rays that have a pending crossing
};

/// A ray of a batch that is left to another kernel; everything written for it so far is invalid.
struct DoubtfulRay {
  std::uint32_t index;
  ResumedAt from;  ///< certified: where the doubt begins; else the start of the ray
};
struct DoubtfulRays {
  /// Those of a chunk, and of the groups that its scattered rays complete.
  DoubtfulRay ray[RayGroup::size * 20];
  std::size_t count = 0;
};

/// What a thread keeps for the kernel.
struct alignas(64) IsosurfaceScratch {
  static constexpr std::size_t kept_blocks = 128;
  static constexpr std::uint64_t no_block = ~std::uint64_t{0};

  RayGroup group;
  /// Along each axis, while the ray moves by 1 along its fastest one.
  float slope[3][RayGroup::size];
  float inverse_slope[3][RayGroup::size];  ///< never_passed where the ray passes no plane
  /// The way of a ray is the distance that it has moved, measured along its fastest axis.
  double way_per_t[RayGroup::size], t_per_way[RayGroup::size];
  /// Certified: error bound of the ray's points due to double precision.
  float position_error[RayGroup::size];
  /// Certified: the largest inverse slope among axes that are not slow.
  float steepest[RayGroup::size];
  /// t at which each ray entered the last block that it passed.
  double t_block[RayGroup::size];
  std::int32_t visits[RayGroup::size];  ///< blocks and cells visited
  BlockFilter filter;
  BlocksAhead ahead;
  PendingHits pending;
  std::uint64_t block_key[kept_blocks];
  BlockSamples blocks[kept_blocks];
  ScatteredScratch scattered;
  std::uint64_t slow[3];  ///< certified: rays for which an axis is slow (error_of_ways)
  DoubtfulRays doubtful;
  std::shared_ptr<const Occupancy> occupancy;  ///< the one whose blocks are kept
  FewRays few;                                 ///< for the doubtful rays
};

/// The functions that are compiled once per machine. They write hits; where there is no hit,
/// everything but the cost keeps its value. Doubtful rays are appended to those of the scratch
/// memory.
struct CrossingKernels {
  /// Traces at most 64 rays of a batch, starting at `first`, a multiple of 64. Scattered rays may
  /// be left waiting.
  void (*answer)(const IsosurfaceQuery& surface, const RayArrays& rays, std::size_t first, std::size_t count,
                 const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters);
  /// Traces the waiting rays.
  void (*answer_waiting)(const IsosurfaceQuery& surface, const RayArrays& rays, const HitArrays& hits,
                         IsosurfaceScratch& scratch, KernelCounters& counters);
};

/// `baseline` uses SSE4 where the processor has it, or else one lane.
CrossingKernels crossing_kernels_on(Machine machine, Search search);

}  // namespace rhoray::render::wide

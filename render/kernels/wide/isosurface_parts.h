#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "formats/packed_file.h"
#include "render/kernels/kernels.h"
#include "render/kernels/wide/batch_arrays.h"
#include "render/kernels/wide/block_samples.h"
#include "render/kernels/wide/ray_group.h"

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
  const std::uint64_t* summits;
  double isovalue;
  bool time_phases;
};

/// Rays that pass one block, packed side by side: where they enter it in its mirrored coordinates, 0 to 4, and how they
/// go on while they move by 1 along their fastest axis.
struct alignas(64) RaysInBlock {
  static constexpr std::size_t capacity = RayGroup::size + 16;

  float entry[3][capacity];
  float slope[3][capacity];
  float inverse_slope[3][capacity];
  float end[capacity];             ///< the way until the ray leaves the block, or ends
  float position_error[capacity];  ///< certified: what double precision may have put the ray's points off by
  std::int32_t ray[capacity];
  std::size_t count;
};

/// Crossings of which the cell is known and the place in it is still to be refined, side by side.
struct alignas(64) PendingHits {
  static constexpr std::size_t capacity = RayGroup::size + 16;

  float corner[8][capacity];                  ///< of the cell, less the isovalue
  float in[3][capacity], out[3][capacity];    ///< where the ray enters and leaves the cell
  float way_in[capacity], way_out[capacity];  ///< from where it entered the block
  float low[capacity], high[capacity];        ///< the piece of the way on which the cubic is monotone and changes side
  float margin[capacity], way_error[capacity];  ///< certified: of values, and of the way
  std::int32_t root_count[capacity];
  std::int32_t ray[capacity];
  std::int64_t cell[capacity];  ///< id
  std::size_t count;
};

/// What a thread keeps for the kernel.
struct alignas(64) IsosurfaceScratch {
  static constexpr std::size_t kept_blocks = 128;
  static constexpr std::uint64_t no_block = ~std::uint64_t{0};

  RayGroup group;
  float slope[3][RayGroup::size];          ///< along each axis, while the ray goes by 1 along its fastest one
  float inverse_slope[3][RayGroup::size];  ///< never_passed where the ray passes no plane
  double way_per_t[RayGroup::size], t_per_way[RayGroup::size];  ///< the way counted along the ray's fastest axis
  float position_error[RayGroup::size];
  double t_block[RayGroup::size];      ///< when each ray entered the last block that it passed
  std::int32_t state[RayGroup::size];  ///< of each ray: see RayState
  RaysInBlock rays_in_block;
  PendingHits pending;
  std::uint64_t block_key[kept_blocks];
  BlockSamples blocks[kept_blocks];
  std::shared_ptr<const Occupancy> occupancy;  ///< whose blocks are kept
  FewRays doubtful;                            ///< certified: what the reference is asked about
};

/// What is known of a ray while it goes from block to block, in one number.
struct RayState {
  static constexpr std::int32_t inside = 1;     ///< the side that it is on
  static constexpr std::int32_t has_side = 2;   ///< it has met data
  static constexpr std::int32_t one_visit = 4;  ///< from here on: blocks and cells visited
};

/// Answers at most 64 rays. Hits are written; what is no hit is left as it is, but for its cost.
/// @return  certified: the rays of which not every decision is proven; nothing that was written for them counts
using FirstCrossings = std::uint64_t (*)(const Surface& surface, const RayArrays& rays, std::size_t count,
                                         const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters);

/// `baseline` is what the processor has of SSE4, or else one lane.
FirstCrossings first_crossings_on(Machine machine, Search search);

}  // namespace rhoray::render::wide

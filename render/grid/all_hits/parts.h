#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "formats/base/checks.h"
#include "render/grid/isosurface/parts.h"
#include "render/query/crossing_arrays.h"

/// The interface between the sources of the SIMD kernel for transparent isosurfaces and the part
/// that is compiled once per machine.
namespace rhoray::render::wide {

inline constexpr int most_surfaces = AllHitsQuery::most_surfaces;

/// One or two surfaces of one volume.
struct TransparentSurfaces {
  IsosurfaceQuery surface[most_surfaces];  ///< they differ in isovalue and occupancy
  /// Share of light that passes n crossings, by n.
  float passing[most_surfaces][CrossingList::most + 1];
  /// A ray with no more crossings in all than this certainly goes on: there is light and room.
  std::int32_t surely_lit;
  float least_inside[most_surfaces];  ///< smallest float that is not below the isovalue
  bool is_single[most_surfaces];      ///< whether that is the isovalue
  int count;
  float least_light;
  bool only_places;  ///< as in AllHitsQuery
};

/// Words of the union of all surfaces' occupancies.
template <int surfaces>
struct UnionBits {
  const std::uint64_t* of[surfaces];

  template <class Index>
  RHORAY_INLINE std::uint64_t operator[](Index i) const {
    std::uint64_t word = of[0][i];
    for (int s = 1; s < surfaces; ++s) word |= of[s][i];
    return word;
  }
};

/// A block that some rays of the group have yet to pass.
struct AllHitsBlock {
  /// More bits than BlockAhead: rays that go on behind their first crossings come to more blocks
  /// before the next group does.
  static constexpr int place_bits[3] = {3, 3, 3};
  static constexpr std::size_t most = 48;

  int block[3];        ///< mirrored
  std::uint64_t rays;  ///< rays that may pass a cell that must be searched
  std::uint64_t by;    ///< rays that may pass only other cells
  /// Of these, rays that may pass cells outside, or inside.
  std::uint64_t by_side[most_surfaces][2];
  std::uint64_t taken;  ///< rays for which it is the next block
  // The numbers that lanes take from the block, each separately:
  float corner[3];              ///< lowest, in the mirrored lattice
  std::int32_t samples;         ///< offset of its samples among those that are kept
  bool is_seen[most_surfaces];  ///< whether it has a bit of the surface
  /// As in BlockSamples, mirrored, in two words.
  std::int32_t active[most_surfaces][2], inside[most_surfaces][2];
  float normal[3], ground;  ///< height above the slabs' origin; mirrored
  float low, high, error;   ///< as in BlockSlabs
};

/// Blocks that rays may come to, in order, whose samples have been prefetched.
struct BlocksExpected {
  static constexpr std::size_t most = 4;

  int block[most][3];
  std::size_t first = 0, count = 0;

  RHORAY_INLINE void add(const int* added) {
    int* to = block[(first + count++) % most];
    for (int a = 0; a < 3; ++a) to[a] = added[a];
  }
  /// Removes and returns the first block; valid until another one is added.
  RHORAY_INLINE const int* take() {
    const int* taken = block[first];
    first = (first + 1) % most, --count;
    return taken;
  }
};

/// The field in a block as far as planes can bound it. A height is the product of the normal and a
/// position in the block, 0 to 4 each, not mirrored.
struct BlockSlabs {
  float normal[3];  ///< in values per cell
  float size;       ///< sum of its magnitudes
  /// A way that stays below this height has no change of side and lies outside.
  float below[most_surfaces];
  /// A way that stays above this height has no change of side and lies inside.
  float above[most_surfaces];
  /// The smallest and the largest of these, over the surfaces present in the block.
  float low, high;
  /// Of the samples, or of means of them, minus an isovalue: more than all rounding.
  float error;
};

/// What is kept of a block in addition to its samples.
struct alignas(64) SeenBlock {
  std::uint64_t active[most_surfaces], inside[most_surfaces];  ///< as in BlockSamples
  BlockSlabs slabs;
};

/// Results of searching as many cells as a vector has lanes: a bit for each.
struct CandidateMask {
  std::uint64_t looked, begins_inside;
};

/// Cells that a pack of rays has ahead in its blocks, and what was found in them.
struct alignas(64) CellsAhead {
  /// Between nine planes, three along each axis, a way has at most ten parts.
  static constexpr std::size_t most = 10 * 16;
  static constexpr std::size_t capacity = most + 16;  ///< plus one vector
  static constexpr std::int32_t nowhere = -1;

  /// The ray, and the cell's index in its block: x + 4 y + 16 z.
  std::int32_t lane[capacity], bit[capacity];
  CandidateMask looks[most_surfaces][capacity];  ///< one per vector of cells
  std::size_t count;
  // Used where it must be decided crossing by crossing whether rays end:
  std::int32_t changes[most_surfaces][capacity];
  /// Index of the first of these, if any, among the ray's crossings.
  std::int32_t place[most_surfaces][capacity];
};

/// Crossings of a group with one surface whose positions in the cells are still to be refined, one
/// after another.
struct alignas(64) FoundCrossings {
  /// At this count they are written before more are sought.
  static constexpr std::size_t full = 128;
  /// Plus what a pack of rays may find in its blocks, at most three changes in each cell, plus two
  /// vectors.
  static constexpr std::size_t capacity = full + 3 * CellsAhead::most + 32;

  float corner[8][capacity];                  ///< of the cell, like its block's samples
  float in[3][capacity], out[3][capacity];    ///< where the ray enters and leaves the cell
  float way_in[capacity], way_out[capacity];  ///< measured from where it entered the block
  /// The piece on which the cubic is monotone and changes side.
  float low[capacity], high[capacity];
  float cell[3][capacity];   ///< in the mirrored lattice
  double t_block[capacity];  ///< t at which the ray entered the block
  /// Ray: index in the group; place: index among its ray's crossings, below 0: no crossing.
  std::int32_t ray[capacity], place[capacity];
  std::int32_t root_count[capacity];
  std::size_t count = 0;
};

/// What a thread keeps for the kernel.
struct alignas(64) GridAllHitsScratch {
  static constexpr std::size_t kept_blocks = 512;

  IsosurfaceScratch ways;  ///< of a group; its blocks are not used
  ListOfBlocks<AllHitsBlock> ahead;
  FoundCrossings found[most_surfaces];
  CellsAhead cells;
  float start[3][RayGroup::size];  ///< of each ray, in the mirrored lattice
  /// Of positions on the ray in single precision, in cells.
  float place_error[RayGroup::size];
  std::int32_t count[most_surfaces][RayGroup::size];  ///< crossings of each ray so far
  /// Where all values are floats, the blocks of the first surface hold the samples themselves, for
  /// all surfaces. Otherwise the blocks of each surface hold the samples minus its isovalue.
  BlockSamples blocks[most_surfaces][kept_blocks];
  SeenBlock seen[kept_blocks];
  std::uint64_t block_key[kept_blocks];
  /// Those whose blocks are kept.
  std::array<std::shared_ptr<const Occupancy>, most_surfaces> occupancies;
};

/// The function that is compiled once per machine: records the crossings of at most 64 rays of a
/// batch, starting at `first`. First hits must be misses before.
using FindAllHits = void (*)(const TransparentSurfaces& shells, const RayArrays& rays, std::size_t first,
                             std::size_t count, const CrossingArrays* lists, std::uint8_t* complete,
                             GridAllHitsScratch& scratch, KernelCounters& counters);

/// `baseline` uses SSE4 where the processor has it, or else one lane.
FindAllHits find_all_hits_on(Machine machine);

}  // namespace rhoray::render::wide

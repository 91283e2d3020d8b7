#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "formats/base/checks.h"
#include "render/grid/isosurface/parts.h"
#include "render/query/crossing_arrays.h"

/// What the sources of the wide kernel for clear isosurfaces hand to the part that is compiled once per machine.
namespace rhoray::render::wide {

inline constexpr int most_surfaces = AllHitsQuery::most_surfaces;

/// One or two surfaces of one volume.
struct TransparentSurfaces {
  Surface surface[most_surfaces];                        ///< that differ in isovalue and occupancy
  float passing[most_surfaces][CrossingList::most + 1];  ///< so many of its crossings
  std::int32_t surely_lit;  ///< a ray with no more crossings than these, whichever, goes on: there is light and room
  float least_inside[most_surfaces];  ///< the least number of single precision that is not below the isovalue
  bool is_single[most_surfaces];      ///< whether that is the isovalue
  int count;
  float least_light;
  bool only_places;  ///< as AllHitsQuery has it
};

/// Words of the occupancies of all surfaces together.
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

/// A block that some rays of the group are still to pass.
struct AllHitsBlock {
  /// Rays that go on behind their first crossings come to more blocks than others, before the next group does.
  static constexpr int place_bits[3] = {3, 3, 3};
  static constexpr std::size_t most = 48;

  int block[3];                             ///< mirrored
  std::uint64_t rays;                       ///< that may pass a cell of it in which something is to be seen
  std::uint64_t by;                         ///< that may pass others only
  std::uint64_t by_side[most_surfaces][2];  ///< of these, those that may pass any outside, or inside
  std::uint64_t taken;                      ///< of which it is the next one
  // What lanes take from it, each number by itself:
  float corner[3];              ///< lowest, in the mirrored lattice
  std::int32_t samples;         ///< where its samples begin among those that are kept
  bool is_seen[most_surfaces];  ///< whether it has a bit of the surface
  std::int32_t active[most_surfaces][2], inside[most_surfaces][2];  ///< of BlockSamples, mirrored, in two words
  float normal[3], ground;                                          ///< height above the slabs' origin: mirrored
  float low, high, error;                                           ///< of BlockSlabs
};

/// Blocks that rays may come to, in their order, of which the samples have been asked for.
struct BlocksExpected {
  static constexpr std::size_t most = 4;

  int block[most][3];
  std::size_t first = 0, count = 0;

  RHORAY_INLINE void add(const int* added) {
    int* to = block[(first + count++) % most];
    for (int a = 0; a < 3; ++a) to[a] = added[a];
  }
  /// The first of them, until another one is added.
  RHORAY_INLINE const int* take() {
    const int* taken = block[first];
    first = (first + 1) % most, --count;
    return taken;
  }
};

/// The field in a block as far as planes can tell. A height is the product of the normal and a place in the block, 0 to
/// 4 each, that is not mirrored.
struct BlockSlabs {
  float normal[3];             ///< in values a cell
  float size;                  ///< sum of its magnitudes
  float below[most_surfaces];  ///< a way that stays below this height comes to no change of side, and lies outside
  float above[most_surfaces];  ///< likewise, inside
  float low, high;             ///< the least and the greatest of these, of surfaces of which something is to be seen
  float error;                 ///< of the samples, or of means of them, less an isovalue: more than all rounding
};

/// What is kept of a block beside its samples.
struct alignas(64) SeenBlock {
  std::uint64_t active[most_surfaces], inside[most_surfaces];  ///< as BlockSamples has them
  BlockSlabs slabs;
};

/// CandidateList into as many cells as a vector has lanes: a bit for each.
struct CandidateMask {
  std::uint64_t looked, begins_inside;
};

/// Cells that a pack of rays has before it in its blocks, and what was found in them.
struct alignas(64) CellsAhead {
  /// Between nine planes, three along each axis, a way has ten parts at most.
  static constexpr std::size_t most = 10 * 16;
  static constexpr std::size_t capacity = most + 16;  ///< and a vector
  static constexpr std::int32_t nowhere = -1;

  std::int32_t lane[capacity], bit[capacity];    ///< the ray, and the cell's place in its block: x + 4 y + 16 z
  CandidateMask looks[most_surfaces][capacity];  ///< as many as there are vectors
  std::size_t count;
  // Where it has to be found out crossing by crossing whether rays end:
  std::int32_t changes[most_surfaces][capacity];
  std::int32_t place[most_surfaces][capacity];  ///< of the first of these, if there are any, among the ray's crossings
};

/// Crossings of a group with one surface of which the place in the cell is still to be refined, one after another.
struct alignas(64) FoundCrossings {
  static constexpr std::size_t full = 128;  ///< these are written before more are looked for
  /// And what a pack of rays may find in its blocks, at most three changes in each cell; and two vectors.
  static constexpr std::size_t capacity = full + 3 * CellsAhead::most + 32;

  float corner[8][capacity];                    ///< of the cell, as its block's samples are kept
  float in[3][capacity], out[3][capacity];      ///< where the ray enters and leaves the cell
  float way_in[capacity], way_out[capacity];    ///< from where it entered the block
  float low[capacity], high[capacity];          ///< the piece on which the cubic is monotone and changes side
  float cell[3][capacity];                      ///< in the mirrored lattice
  double t_block[capacity];                     ///< when the ray entered the block
  std::int32_t ray[capacity], place[capacity];  ///< of the group; among the crossings of its ray, below 0: none
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
  float start[3][RayGroup::size];                     ///< of each ray, in the mirrored lattice
  float place_error[RayGroup::size];                  ///< of places on the ray in single precision, in cells
  std::int32_t count[most_surfaces][RayGroup::size];  ///< crossings of each ray so far
  /// Where values are numbers of single precision, those of the first surface are the samples themselves, for all
  /// surfaces; else each has them less its isovalue.
  BlockSamples blocks[most_surfaces][kept_blocks];
  SeenBlock seen[kept_blocks];
  std::uint64_t block_key[kept_blocks];
  std::array<std::shared_ptr<const Occupancy>, most_surfaces> occupancies;  ///< whose blocks are kept
};

/// What is compiled once per machine: notes the crossings of at most 64 rays of a batch, from `first` on. First hits
/// are misses before.
using FindAllHits = void (*)(const TransparentSurfaces& shells, const RayArrays& rays, std::size_t first,
                             std::size_t count, const CrossingArrays* lists, std::uint8_t* complete,
                             GridAllHitsScratch& scratch, KernelCounters& counters);

/// `baseline` is what the processor has of SSE4, or else one lane.
FindAllHits find_all_hits_on(Machine machine);

}  // namespace rhoray::render::wide

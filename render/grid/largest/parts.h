#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "formats/packed_file.h"
#include "render/grid/block_samples.h"
#include "render/query/machine.h"
#include "render/traverse/ray_group.h"
#include "render/traverse/region_queue.h"

/// The interface between the sources of the SIMD kernel for largest values and the part that is
/// compiled once per machine.
///
/// That part looks for the positions on a ray where the largest value can be, in single precision
/// with bounded rounding. What it cannot rule out is decided in double precision, with exactly the
/// operations of the scalar kernel. So the answer is the scalar kernel's on every machine, whatever
/// group a ray is in.
namespace rhoray::render::wide {

/// The largest value found on a ray so far.
struct FoundMaximum {
  double value;  ///< -infinity: none
  double t;
  double entered;  ///< where the ray enters the cell
  std::uint64_t cell;
};

/// True where `other` replaces `found`: the larger value wins, and of equal ones the nearer. At
/// equal t the one in the cell that the ray enters first wins, as in the scalar kernel's queue.
RHORAY_INLINE bool is_better(const FoundMaximum& other, const FoundMaximum& found) {
  if (other.value != found.value) return other.value > found.value;
  if (other.t != found.t) return other.t < found.t;
  if (other.entered != found.entered) return other.entered < found.entered;
  return other.cell < found.cell;
}

/// Values that occur in the macrocells of one level: lo and hi of each, of the field's type, x
/// fastest.
struct StoredRanges {
  const void* first;
  int count[3];
};

/// Evaluates the cells of a ray from t_from to t_to by the scalar kernel's own code. It is used
/// where the SIMD evaluation does not apply: planes passed at nearly the same time, or differences
/// that need another unit.
/// @param ray  index in the chunk
using LookClosely = void (*)(const void* context, const RayArrays& rays, std::size_t ray, double t_from, double t_to,
                             FoundMaximum& found);

/// One field of one volume.
struct MaximumField {
  SampleSource source;
  formats::ElementType type;
  std::size_t sample_bytes;
  int leaf_count[3];
  std::array<int, 3> node_count;  ///< nodes of 16^3 cells per axis, a multiple of 4
  /// Of 4 and of 16 cells; those of 16 may be missing.
  StoredRanges blocks, nodes;
  double range;   ///< of the field's values
  bool has_gaps;  ///< some samples have no data
  /// Samples 4 i to 4 i + 3 of x and 4 j to 4 j + 3 of y are contiguous, x fastest.
  bool has_squares;
  bool has_bricks;  ///< and so are 4 k to 4 k + 3 of z
  bool time_phases;
  LookClosely look_closely;
  const void* context;
};

/// Rays that are searched together: one group, or several full adjacent ones of one octant and one
/// major axis. Numbers as in RayGroup; lanes beyond `count` up to a multiple of 16 repeat the last
/// ray.
struct alignas(64) SearchedRays {
  static constexpr std::size_t groups = 4;
  static constexpr std::size_t size = groups * RayGroup::size;
  /// So that a ray's numbers lie in different cache sets.
  static constexpr std::size_t stride = size + 8;

  double origin[3][stride], direction[3][stride];
  double plane_origin[3][stride], inverse[3][stride];
  double t_in[stride], t_out[stride];
  std::uint32_t index[size];     ///< index in the chunk
  std::uint64_t inside[groups];  ///< rays with a part inside the lattice, by group
  std::size_t count;
  unsigned octant;
};

/// The rays of a search in single precision: positions on the minor axes as functions of the
/// position on the major one.
struct alignas(64) GroupLines {
  static constexpr std::size_t size = SearchedRays::size;
  static constexpr std::size_t stride = size + 16;

  double exact_start[2][stride], exact_slope[2][stride];
  float start[2][stride];  ///< where the major axis is 0
  float slope[2][stride];
  float inverse[2][stride];        ///< of the slope; large where the slope is close to 0
  float from[stride], to[stride];  ///< the part inside the lattice, on the major axis
  float reached[stride];           ///< no more than the largest value found
  float reached_at[stride];        ///< no less than where it was found, on the major axis
};

/// The same lines in units of 2^-27 of a cell.
struct alignas(64) LineParts {
  static constexpr std::size_t size = SearchedRays::size;
  static constexpr double size_of_one = 0x1p27;

  double start[2][size], slope[2][size];
  std::int32_t step[2][size];  ///< the slope as an integer
};

/// Lines on the minor axes that enclose the rays of each vector, as functions of the position on
/// the major axis: their values where it is 0, and their slopes.
struct alignas(64) VectorLines {
  static constexpr std::size_t size = 64;  ///< the most vectors

  float low[2][size], low_slope[2][size], high[2][size], high_slope[2][size];
  float reached[size];  ///< no more than any of their rays has reached
};

/// Parts of rays in boxes of cells that may hold a larger value than was found, until they are
/// evaluated closely.
struct alignas(64) Suspects {
  static constexpr std::size_t capacity = 4096 + 16;
  static constexpr std::size_t most_boxes = 1024;

  /// Suspects from `first` up to the first of the next box are in this box. Their positions on the
  /// major axis are relative to its beginning, their values are in its unit.
  struct Box {
    double highest, scale, low_w;
    std::size_t first;
  };

  std::int32_t ray[capacity];
  float from[capacity], to[capacity];  ///< on the major axis
  float bound[capacity];               ///< no value there is larger
  /// The last box in use is followed by one whose `first` is the number of suspects.
  Box box[most_boxes + 1];
  std::size_t count, boxes;
};

/// Cells on rays that must be evaluated closely.
struct alignas(64) CandidateList {
  static constexpr std::size_t capacity = 512 + 16;

  std::int32_t ray[capacity];
  std::int32_t cell[3][capacity];
  /// t: how far the cells before and behind are evaluated too.
  double from[capacity], to[capacity];
  std::int32_t way[capacity];  ///< -1: only those before, 1: only those behind, 0: both
  std::size_t count;
};

/// The corners of their cells: (x, y, z) at x + 2 y + 4 z.
struct alignas(64) LookCorners {
  std::int32_t small[8][CandidateList::capacity];  ///< of samples of 8 and 16 bits
  double other[8][CandidateList::capacity];        ///< of all others
};

/// The last cells that suspects of a ray were in, and the range of t over which they are followed
/// up.
struct FinalCandidates {
  static constexpr std::size_t kept = 4;
  std::uint64_t key[kept];
  double from[kept], to[kept];
  std::size_t next;
};

/// Rays that pass a box of cells, packed side by side; positions relative to its lowest corner.
struct alignas(64) RaysAtBlock {
  static constexpr std::size_t capacity = 4 * SearchedRays::size + 16;

  std::int32_t ray[capacity];
  float from[capacity], to[capacity];  ///< on the major axis
  float start[2][capacity];            ///< positions on the minor axes where the box begins
  float slope[2][capacity], inverse[2][capacity];
  float reached[capacity];     ///< in the box's unit: no more than what was reached
  float reached_at[capacity];  ///< no less than where, on the major axis
  std::size_t count;
};

/// The 5 x 5 x 5 samples of a block, sample (x, y, z) at x + 5 y + 25 z: (sample - the block's
/// largest) * unit, from -2 to 0 where there is data.
struct alignas(64) MaximumBlock {
  float sample[160];
  float largest[160];  ///< of the cell whose lowest corner this is
};

/// The samples of a slab of nodes around a group's rays (Window).
struct alignas(64) MaximumWindow {
  static constexpr int longest = 40;  ///< samples on an axis
  static constexpr std::size_t capacity = 17 * 34 * 36;

  /// The second half is written but never read.
  std::int32_t words[2 * capacity];
};

/// Consecutive planes of samples across the major axis around some rays (PlaneReader): sample (u,
/// v) of plane k at u + e v + e^2 k, where e is 16 or 32.
struct alignas(64) MaximumPlanes {
  static constexpr int edge = 32;  ///< the most samples on an axis
  static constexpr int planes = 5;

  std::uint16_t below[planes * edge * edge];  ///< distance below an upper bound of all values
  std::uint16_t beyond[edge + 2];             ///< may be read but is not used
  /// For planes of 16 x 16 samples: a quarter of the largest change of values from where a ray is
  /// to the next plane.
  alignas(64) std::uint16_t rise[edge * edge / 4];
};

/// The same in pairs: a sample and, in the upper half, the one behind it in the next plane.
struct alignas(64) MaximumLayers {
  std::int32_t below[(MaximumPlanes::planes - 1) * MaximumPlanes::edge * MaximumPlanes::edge];
  std::int32_t beyond[MaximumPlanes::edge + 2];  ///< may be read but is not used
};

/// Results for layers between two planes that may hold a larger value than was found (PlaneSweep),
/// kept until the layers are walked. Each entry is for the 32 rays of a pair of vectors at a slab
/// of blocks.
struct alignas(64) SeenLayers {
  static constexpr std::size_t capacity = 512;
  static constexpr std::size_t most_slabs = 1 << 12;  ///< of a lattice
  static constexpr std::size_t per_slab = MaximumPlanes::planes - 1;

  struct At {
    std::int32_t slab;
    std::int16_t vector, second;
    std::int32_t lowest, highest;  ///< of the samples that the words were made for
  };

  /// Smallest distance below `highest` of any value in the layer, in words.
  std::int16_t least[capacity][per_slab][32];
  At at[capacity];
  std::size_t count;
};

/// Which slabs of nodes were swept, a bit each.
struct SweptSlabs {
  /// The most that a lattice can have.
  static constexpr std::size_t words = (1 << 14) / 16 / 64 + 1;

  std::uint64_t swept[words];
  std::uint8_t blocks[64 * words];  ///< blocks searched in the slab, modulo 256
  int next[64 * words];             ///< the highest bucket at which a slab is considered again
};

struct alignas(64) MaximumScratch {
  RayGroup group;
  SearchedRays rays;
  GroupLines lines;
  VectorLines around;
  RegionQueue queue;
  MaximumBlock block;
  MaximumWindow window;
  SweptSlabs slabs;
  LineParts line_parts;
  MaximumPlanes planes;
  MaximumLayers layers;
  SeenLayers seen_layers;
  /// Of the frustum's blocks, by their position on the major axis.
  std::int32_t slab_largest[SeenLayers::most_slabs];
  RaysAtBlock at_block;
  Suspects suspects;
  CandidateList looks_left;
  LookCorners corners;
  double reached[SearchedRays::size];  ///< some value on the ray is at least this
  FinalCandidates last_looks[SearchedRays::size];
  /// Copies from `found`, by index in the search.
  double known_value[SearchedRays::size], known_t[SearchedRays::size];
  FoundMaximum found[SearchedRays::size];  ///< by index in the chunk
  float visits[SearchedRays::size];        ///< boxes of cells, and cells in them
  std::uint32_t cost[SearchedRays::size];  ///< the same, by index in the chunk
  std::uint64_t regions, looks, ticks;     ///< counters
};

/// For a chunk of at most SearchedRays::size rays.
using LargestValues = void (*)(const MaximumField& field, const RayArrays& rays, std::size_t count,
                               MaximumScratch& scratch);

/// Null for `scalar`, and where this processor or this build does not have the machine.
LargestValues largest_values_on(Machine machine);

}  // namespace rhoray::render::wide

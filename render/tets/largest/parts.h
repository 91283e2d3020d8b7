#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "formats/cell_clusters.h"
#include "render/query/kernels.h"
#include "render/query/largest_so_far.h"
#include "render/triangles/kernels/facet_parts.h"

/// Data that the sources of the wide kernel for largest values in meshes pass to the part that is
/// compiled once per machine.
///
/// A ray is parametrised along its major axis w, on which it moves most, as in
/// render/triangles/kernels/facet_parts.h: u = shift_u + slope_u w and v = shift_v + slope_v w.
/// That part finds the cells in which a ray may have its largest value, in single precision with
/// bounded rounding. The cells that it cannot rule out (suspects) are decided by the scalar
/// kernel's own code. The result is therefore the scalar kernel's on every machine, whatever group
/// a ray is in.
namespace rhoray::render::wide {

/// A cell in which a ray may have its largest value.
struct TetSuspect {
  double most;  ///< upper bound of the ray's values in the cell
  std::uint32_t tet;
  std::uint32_t ray;  ///< index in the chunk
};

/// Offers the values that rays have in suspects to `found`.
/// @param found  for each ray of the chunk
using SolveCandidates = void (*)(const void* context, const RayArrays& rays, const TetSuspect* suspects,
                                 std::size_t count, LargestSoFar* found);

using CellIdOf = std::uint64_t (*)(const void* context, std::uint32_t tet);

/// One field of one mesh with clusters.
struct TetMaximumField {
  static constexpr int largest_level_count = 11;  ///< 2^32 clusters of one cell

  const double* points;  ///< three coordinates each
  const void* values;    ///< double, or float
  bool is_single;
  bool has_gaps;  ///< some values are not finite
  Interval<double> range;
  const std::uint64_t* table_starts;
  const std::uint32_t* tables;
  const std::uint8_t* corners;  ///< four per cell
  std::uint64_t cell_count, cluster_size;
  double box_unit;
  int top_level;
  const formats::BoxBlock* boxes[largest_level_count];
  const void* ranges[largest_level_count];  ///< RangeBlock<double>, or <float>
  double low[3], high[3];                   ///< of all points
  bool time_phases;
  SolveCandidates look;
  CellIdOf cell_id;
  const void* context;
};

/// A cluster in its own local frame. There its box is centred at zero and extends from -1 to 1 at
/// most, and its values extend from 0 to 1.
struct alignas(64) LocalCluster {
  static constexpr std::size_t capacity = 256;  ///< vertices
  static constexpr std::uint64_t none = ~std::uint64_t{0};

  float place[3][capacity];
  float value[capacity];
  std::uint64_t cluster = none;
  double center[3], scale;                   ///< place = (point - center) * scale
  double lowest, highest, range, per_range;  ///< of values
  float low[3], high[3];                     ///< box
  float value_error;  ///< six times the rounding error of the means that the scalar kernel computes
  std::uint32_t vertex_count;
};

/// A region in the queue of those still to be opened. The one with the largest bound is on top; of
/// equal bounds the nearest.
struct TetRegion {
  float bound;  ///< upper bound of its values, as a share of the field's range
  float near;
  std::uint32_t entry;
  std::int32_t level;
};

/// 64 rays of a batch, in the lanes of render/triangles/kernels/facet_parts.h.
struct alignas(64) TetMaximumScratch {
  static constexpr std::size_t lanes = RayGroup::size, pack = FacetScratch::pack, packs = FacetScratch::packs;

  double slope[2][lanes], shift[2][lanes];  ///< relative to the middle of the mesh
  double begin[lanes], end[lanes];          ///< the ray's ends, along w, begin <= end
  /// Lower bound of the ray's largest value; infinite without a ray.
  double reached[lanes];
  /// Lines and ends of the rays, in units of boxes.
  float tree_slope[2][lanes], tree_shift[2][lanes], tree_begin[lanes], tree_end[lanes];
  float reached_share[lanes];  ///< `reached` as a share of the field's range, or less
  /// For each pack, l: bounds of -u, u, -v, v: offset + slope w.
  double line_offset[16], line_slope[16];

  // In the frame of the cluster that is being searched.
  float place[2][lanes], local_begin[lanes], local_end[lanes];
  float level[lanes];  ///< `reached` in that frame
  std::uint32_t codes[LocalCluster::capacity];

  std::uint32_t cost[lanes];
  LargestSoFar found[lanes];  ///< by ray, not by lane

  static constexpr std::size_t suspect_capacity = 256;
  TetSuspect suspects[suspect_capacity + lanes];
  std::size_t suspect_count;

  static constexpr std::size_t region_capacity = 4096;
  TetRegion regions[region_capacity];
  std::size_t region_count;

  static constexpr std::size_t slot_count = 256;
  LocalCluster clusters[slot_count];
  /// The volume that they belong to. Every loaded volume has a FacetsCache of its own. A weak
  /// pointer distinguishes it from that of volumes loaded later, even if one is at the same
  /// address.
  std::weak_ptr<const FacetsCache> of_dataset;

  FewRays others;  ///< rays passed to the reference
};

/// Finds the largest values of at most 64 rays and stores them in `found`.
/// @return  one bit per ray that is left to the reference
using TetLargestValues = std::uint64_t (*)(const TetMaximumField& field, const RayArrays& rays, std::size_t count,
                                           TetMaximumScratch& scratch, KernelCounters& counters);

/// `baseline` uses the processor's best SSE up to SSE4, or else one lane.
TetLargestValues tet_largest_values_on(Machine machine);

}  // namespace rhoray::render::wide

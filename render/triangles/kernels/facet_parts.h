#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>

#include "render/query/batch_arrays.h"
#include "render/query/kernels.h"
#include "render/query/machine.h"
#include "render/triangles/facets.h"

/// Data that the sources of the wide kernel of meshes' isosurfaces pass to the part that is
/// compiled once per machine.
///
/// A ray in the facets' frame is parametrised along its major axis w, on which it moves most: u =
/// shift_u + slope_u w and v = shift_v + slope_v w. A corner's position in the ray's picture plane
/// is (u - slope_u w - shift_u, ...): it depends on the ray and the corner alone (Woop, Benthin and
/// Wald, JCGT 2013).
namespace rhoray::render::wide {

/// Wide kernels accept lengths, values and isovalues up to this size, and lengths from its inverse
/// on.
inline constexpr double largest_magnitude = 1e60;

/// What a query searches for.
enum class FacetSearch {
  first,      ///< the nearest facet that the ray hits
  certified,  ///< the same, proven
  any,        ///< whether there is any
  all         ///< all of them, in order
};

/// One isosurface of one mesh, or the triangles of a surface.
struct FacetSurface {
  static constexpr int largest_level_count = 8;

  const FacetBlock* blocks;
  const FacetField* fields;
  /// For each facet of a block its index in `fields`; null: its own.
  const std::uint32_t* sources = nullptr;
  /// Per block, one bit per facet: set when all rays hit the facet from the side on which they
  /// start; null: not known.
  const std::uint16_t* sure = nullptr;
  const FacetNode* levels[largest_level_count];
  int level_count;
  std::uint32_t facet_count;
  double anchor[3];
  double scale;
  float low[3], high[3];
  double isovalue;  ///< NaN for a surface
  bool is_of_triangles;
  bool time_phases;
};

/// Upper bound of the error of a corner's position in a ray's picture plane, in the facets' frame.
/// It covers what is rounded to single precision: the shift (up to 2: 2^-24), the slope (2^-25),
/// the corner (2^-25 along two axes), and one or two operations (2^-24 and 2^-25). It also covers
/// the rounding in double for rays that start less than certified_reach away.
inline constexpr float place_error = 1.25f * 0x1p-22f;
inline constexpr double certified_reach = 0x1p20;

/// Rays that start farther away than this are passed to the reference directly.
inline constexpr double reach = 0x1p40;

/// A ray of a chunk and a facet for which single precision cannot tell whether the ray passes
/// through.
struct FacetDoubt {
  std::uint32_t ray, facet;
};

struct FacetLists;

/// Rays of a chunk by major axis (on which they move most) and by their direction along it: one bit
/// each.
struct Directions {
  std::uint64_t along[3];
  std::uint64_t down[3];
  std::uint64_t strange;  ///< rays that are not finite, do not move, or start too far away
};

/// The lines of a chunk's rays, as if they all had the same major axis. Pack p holds lanes 16 p to
/// 16 p + 15, a square of 4 x 4 of a chunk of 8 x 8.
struct alignas(64) FacetLines {
  static constexpr std::size_t lanes = RayGroup::size;

  float slope[2][lanes], shift[2][lanes];
  /// Of the ray: depths, which are w, or -w where the rays move down that axis.
  float begin[lanes], end[lanes];
  float start_side[lanes];  ///< as StartSide; only where rays have one
};

/// What is known of 64 rays of a batch before they are traced.
struct FacetChunk {
  Directions directions;
  FacetLines lines;
  int axis;   ///< major axis of the lines if they are computed already; -1: not yet
  bool down;  ///< direction along it
};

/// The facets that a batch of rays may hit, extracted from a surface into a small surface of its
/// own, contiguous in memory, under one node.
struct alignas(64) FacetPart {
  static constexpr std::uint32_t capacity = FacetNode::size * FacetBlock::size;
  /// With more facets expected, assuming that they are spread evenly over their box, the whole
  /// surface is traced instead. The limit is lower for rays that end at any facet, because they
  /// gain less from a part. The whole surface is also traced when more blocks must be visited than
  /// most_looked_into. All values by measurement (data/lab/peers_tets.md).
  static constexpr float most_expected = capacity * 4, most_expected_of_any = capacity;
  static constexpr std::uint32_t most_looked_into = 96;

  FacetBlock blocks[FacetNode::size];
  FacetNode node;
  float corner[4][3][capacity + FacetBlock::size];  ///< used while facets are gathered
  std::uint32_t sources[capacity];
  std::uint16_t sure[FacetNode::size];
  std::uint32_t count;
  /// Nodes opened and blocks visited for all rays of the batch.
  std::uint32_t node_count, looked_into_count;
  FacetSurface surface;

  void begin(const FacetSurface& whole) {
    surface = whole;
    surface.blocks = blocks, surface.sources = sources, surface.sure = whole.sure != nullptr ? sure : nullptr;
    surface.levels[0] = &node, surface.level_count = 1, surface.facet_count = 0;
    std::fill(std::begin(sure), std::end(sure), std::uint16_t{0});
    count = node_count = looked_into_count = 0;
  }
};

/// Rays of a batch, 64 at a time.
struct alignas(64) FacetScratch {
  static constexpr std::size_t lanes = FacetLines::lanes, pack = 16, packs = lanes / pack;
  static constexpr std::size_t chunk_capacity = 16;

  FacetChunk chunks[chunk_capacity];
  FacetPart part;
  std::uint64_t part_visits;  ///< of nodes and blocks, for every ray of these chunks

  /// Of the nearest hit, or `end`; below everything in lanes without a ray.
  alignas(64) float depth[lanes];
  std::int32_t facet[lanes];  ///< that was hit, or no_facet
  float far[lanes];           ///< certified: upper bound of the depth of the nearest hit
  /// Certified: the two smallest depths that any hit may have.
  float nearest[lanes], second[lanes];
  float doubt[lanes];  ///< certified: the smallest depth of any facet in doubt
  /// Per pack: lower and upper bounds of u, then of v.
  float cull_offset[lanes / 4], cull_slope[lanes / 4];
  float pack_far[packs];

  static constexpr std::int32_t no_facet = 0x7fffffff;

  static constexpr std::size_t doubt_capacity = 1024;
  FacetDoubt doubts[doubt_capacity];  ///< of a chunk
  std::size_t doubt_count;

  FacetLists* lists;  ///< the group's lists, when all hits are searched

  std::shared_ptr<const Facets> facets;
  FewRays others;  ///< rays passed to the reference
};

/// Returns the lane of a chunk's ray.
constexpr std::size_t lane_of(std::size_t ray) {
  const std::size_t row = ray / 8, column = ray % 8;
  return (row / 4 * 2 + column / 4) * FacetScratch::pack + row % 4 * 4 + column % 4;
}
/// Returns the ray of a lane.
constexpr std::size_t ray_of(std::size_t lane) {
  const std::size_t pack = lane / FacetScratch::pack, in_pack = lane % FacetScratch::pack;
  return (pack / 2 * 4 + in_pack / 4) * 8 + pack % 2 * 4 + in_pack % 4;
}

/// The state of a chunk's rays, one bit per ray.
struct Answered {
  std::uint64_t hit = 0;  ///< hits are written
  /// To be traced by the reference: rays that are not finite; certified: rays that are not proven.
  std::uint64_t whole = 0;
  std::uint64_t part = 0;  ///< certified: traced except for facets in doubt (FacetScratch::doubts)
};

/// Prepares at most chunk_capacity chunks of rays.
/// @param farthest       rays that start farther away are passed to the reference
/// @param most_expected  maximum number of facets expected in a part
/// @return               the surface to trace them against: the whole one, or the part that they
///   may hit
using PrepareRays = const FacetSurface& (*)(const FacetSurface& whole, const RayArrays& rays, std::size_t count,
                                            double farthest, float most_expected, FacetScratch& scratch,
                                            KernelCounters& counters);

/// Traces a prepared chunk of at most 64 rays. Writes hits, and the cost of each ray; of misses it
/// writes nothing else.
using FirstFacets = Answered (*)(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                 FacetChunk& chunk, const HitArrays& hits, FacetScratch& scratch,
                                 KernelCounters& counters);

/// Which of at most 64 rays hit a facet.
struct MetFacets {
  std::uint64_t crossed = 0;
  std::uint64_t unanswered = 0;  ///< rays that are not finite
};
using AnyFacets = MetFacets (*)(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                FacetChunk& chunk, FacetScratch& scratch, KernelCounters& counters);

/// `baseline` uses the processor's best SSE up to SSE4, or else one lane.
PrepareRays prepare_rays_on(Machine machine);
FirstFacets first_facets_on(Machine machine, bool certified);
AnyFacets any_facets_on(Machine machine);

}  // namespace rhoray::render::wide

#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>

#include "render/query/batch_arrays.h"
#include "render/query/kernels.h"
#include "render/triangles/facets.h"

/// What the sources of the wide kernel of meshes' isosurfaces hand to the part that is compiled once per machine.
///
/// A ray in the facets' frame is described along the axis, w, on which it moves most: u = shift_u + slope_u w and
/// v = shift_v + slope_v w. A corner's place in the ray's picture plane is (u - slope_u w - shift_u, ...): it depends
/// on the ray and the corner alone (Woop, Benthin and Wald, JCGT 2013).
namespace rhoray::render::wide {

/// Lengths, values and isovalues up to this size, lengths from its inverse on, are answered by wide kernels.
inline constexpr double largest_magnitude = 1e60;

/// What is asked of facets.
enum class FacetSearch {
  first,      ///< the nearest that the ray meets
  certified,  ///< the same, proven
  any,        ///< whether there is one
  all         ///< all of them, in their order
};

/// One isosurface of one mesh, or the triangles of a surface.
struct FacetSurface {
  static constexpr int largest_level_count = 8;

  const FacetBlock* blocks;
  const FacetField* fields;
  const std::uint32_t* sources = nullptr;  ///< of each facet of a block its place among the fields; null: its own
  /// Of each block a bit for each facet that all rays meet on the side on which they start; null: not known.
  const std::uint16_t* sure = nullptr;
  const FacetNode* levels[largest_level_count];
  int level_count;
  std::uint32_t facet_count;
  double anchor[3];
  double scale;
  float low[3], high[3];
  double isovalue;  ///< NaN of a surface
  bool is_of_triangles;
  bool time_phases;
};

/// How far, at most, a corner's place in a ray's picture plane is from the exact one, in the facets' frame, by what is
/// rounded to single precision: the shift (up to 2: 2^-24), the slope (2^-25), the corner (2^-25 along two axes),
/// and one or two operations (2^-24 and 2^-25); and by the rounding in double of rays that start less than
/// certified_reach away.
inline constexpr float place_error = 1.25f * 0x1p-22f;
inline constexpr double certified_reach = 0x1p20;

/// Rays that start farther away than this go to the reference at once.
inline constexpr double reach = 0x1p40;

/// A ray of a chunk that single precision cannot tell whether it passes through a facet.
struct FacetDoubt {
  std::uint32_t ray, facet;
};

struct FacetLists;

/// Rays of a chunk by the axis on which they move most, and by the way they move along it: a bit for each.
struct Directions {
  std::uint64_t along[3];
  std::uint64_t down[3];
  std::uint64_t strange;  ///< rays that are not of finite numbers, do not move, or start too far away
};

/// The lines of a chunk's rays, as if all of them moved most along one axis. Pack p holds lanes 16 p to 16 p + 15, a
/// square of 4 x 4 of a chunk of 8 x 8.
struct alignas(64) FacetLines {
  static constexpr std::size_t lanes = RayGroup::size;

  float slope[2][lanes], shift[2][lanes];
  float begin[lanes], end[lanes];  ///< of the ray: depths, which are w, or -w where the rays move that way
  float start_side[lanes];         ///< as StartSide; only where rays have any
};

/// What is known of 64 rays of a batch before they are followed.
struct FacetChunk {
  Directions directions;
  FacetLines lines;
  int axis;   ///< along which lines are described already; -1: along none
  bool down;  ///< and the way
};

/// The facets that a batch of rays may meet, taken out of a surface as a surface of its own: few, side by side in
/// memory, under one node.
struct alignas(64) FacetPart {
  static constexpr std::uint32_t capacity = FacetNode::size * FacetBlock::size;
  /// Where more facets are expected, were they spread evenly over their box, the whole surface is asked about; a part
  /// pays less for rays that end at any facet. So it is where more blocks have to be looked into. All by measurement
  /// (data/lab/peers_tets.md).
  static constexpr float most_expected = capacity * 4, most_expected_of_any = capacity;
  static constexpr std::uint32_t most_looked_into = 96;

  FacetBlock blocks[FacetNode::size];
  FacetNode node;
  float corner[4][3][capacity + FacetBlock::size];  ///< while facets are gathered
  std::uint32_t sources[capacity];
  std::uint16_t sure[FacetNode::size];
  std::uint32_t count;
  std::uint32_t node_count, looked_into_count;  ///< nodes opened and blocks looked into for all rays of the batch
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

  alignas(64) float depth[lanes];       ///< of the nearest hit, or `end`; below all in lanes without a ray
  std::int32_t facet[lanes];            ///< that was hit; no_facet
  float far[lanes];                     ///< certified: of the nearest hit, at most
  float nearest[lanes], second[lanes];  ///< certified: the two least depths that any hit may have
  float doubt[lanes];                   ///< certified: the least depth of any facet in doubt
  float cull_offset[lanes / 4], cull_slope[lanes / 4];  ///< of each pack: lower and upper bounds of u, then of v
  float pack_far[packs];

  static constexpr std::int32_t no_facet = 0x7fffffff;

  static constexpr std::size_t doubt_capacity = 1024;
  FacetDoubt doubts[doubt_capacity];  ///< of a chunk
  std::size_t doubt_count;

  FacetLists* lists;  ///< where all are asked for: those of the group

  std::shared_ptr<const Facets> facets;
  FewRays others;  ///< what the reference is asked about
};

/// The lane of a chunk's ray.
constexpr std::size_t lane_of(std::size_t ray) {
  const std::size_t row = ray / 8, column = ray % 8;
  return (row / 4 * 2 + column / 4) * FacetScratch::pack + row % 4 * 4 + column % 4;
}
/// The ray of a lane.
constexpr std::size_t ray_of(std::size_t lane) {
  const std::size_t pack = lane / FacetScratch::pack, in_pack = lane % FacetScratch::pack;
  return (pack / 2 * 4 + in_pack / 4) * 8 + pack % 2 * 4 + in_pack % 4;
}

/// What is known of a chunk's rays: a bit for each.
struct Answered {
  std::uint64_t hit = 0;    ///< their hits are written
  std::uint64_t whole = 0;  ///< to be asked of the reference: what is no ray of finite numbers; certified: what is not
                            ///< proven
  std::uint64_t part = 0;   ///< certified: the answer but for facets in doubt (FacetScratch::doubts)
};

/// Makes at most chunk_capacity chunks of rays ready.
/// @param farthest       rays that start farther away go to the reference
/// @param most_expected  of facets in a part
/// @return               the surface to ask about them: the whole one, or the part of it that they may meet
using PrepareRays = const FacetSurface& (*)(const FacetSurface& whole, const RayArrays& rays, std::size_t count,
                                            double farthest, float most_expected, FacetScratch& scratch,
                                            KernelCounters& counters);

/// Answers a chunk of at most 64 rays that is ready. Hits are written, and what each ray cost; of what is no hit
/// nothing else.
using FirstFacets = Answered (*)(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                 FacetChunk& chunk, const HitArrays& hits, FacetScratch& scratch,
                                 KernelCounters& counters);

/// Which of at most 64 rays meet a facet.
struct MetFacets {
  std::uint64_t crossed = 0;
  std::uint64_t unanswered = 0;  ///< what is no ray of finite numbers
};
using AnyFacets = MetFacets (*)(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                FacetChunk& chunk, FacetScratch& scratch, KernelCounters& counters);

/// `baseline` is what the processor has of SSE4, or else one lane.
PrepareRays prepare_rays_on(Machine machine);
FirstFacets first_facets_on(Machine machine, bool certified);
AnyFacets any_facets_on(Machine machine);

}  // namespace rhoray::render::wide

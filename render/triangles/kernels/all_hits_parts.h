#pragma once

#include <cstddef>
#include <cstdint>

#include "render/query/crossing_arrays.h"
#include "render/triangles/kernels/facet_parts.h"

/// What the wide kernel for clear isosurfaces of meshes hands to the part that is compiled once per machine.
namespace rhoray::render::wide {

/// The facets that rays pass through, of each lane the nearest, in order of depth, then of number.
struct alignas(64) FacetLists {
  /// More than a CrossingList holds: a ray that passes through an edge meets two.
  static constexpr std::size_t capacity = CrossingList::most + 4;

  float depth[capacity][FacetScratch::lanes];
  std::int32_t facet[capacity][FacetScratch::lanes];
  std::int32_t count[FacetScratch::lanes];
  std::uint64_t overflowed;  ///< lanes of which farther ones were left out

  std::size_t room;               ///< of a ray, at most capacity
  float passing, least_light;     ///< as TransparentSurface and AllHitsQuery have it
  const CrossingArrays* written;  ///< of all rays
  std::uint8_t* complete;         ///< likewise
  std::size_t first;              ///< ray of the chunk
};

/// What a thread keeps for it.
struct FacetAllHitsScratch {
  FacetScratch facets;
  FacetLists lists;
};

/// Notes the crossings of at most 64 rays. First hits are misses before, rays complete.
/// @return  a bit for each ray that is to be answered by another kernel
using CrossFacets = std::uint64_t (*)(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                      FacetChunk& chunk, FacetLists& lists, FacetScratch& scratch,
                                      KernelCounters& counters);

/// `baseline` is what the processor has of SSE4, or else one lane.
CrossFacets cross_facets_on(Machine machine);

}  // namespace rhoray::render::wide

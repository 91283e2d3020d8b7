#pragma once

#include <cstddef>
#include <cstdint>

#include "render/query/crossing_arrays.h"
#include "render/triangles/kernels/facet_parts.h"

/// Data that the wide kernel for all hits of transparent isosurfaces in meshes passes to the part
/// that is compiled once per machine.
namespace rhoray::render::wide {

/// The facets that rays pass through: for each lane the nearest ones, in order of depth, then of
/// index.
struct alignas(64) FacetLists {
  /// More than a CrossingList holds: a ray that passes through an edge hits two facets.
  static constexpr std::size_t capacity = CrossingList::most + 4;

  float depth[capacity][FacetScratch::lanes];
  std::int32_t facet[capacity][FacetScratch::lanes];
  std::int32_t count[FacetScratch::lanes];
  std::uint64_t overflowed;  ///< lanes for which farther facets were dropped

  std::size_t room;               ///< maximum per ray, at most capacity
  float passing, least_light;     ///< as in TransparentSurface and AllHitsQuery
  const CrossingArrays* written;  ///< for all rays
  std::uint8_t* complete;         ///< for all rays
  std::size_t first;              ///< first ray of the chunk
};

/// The scratch memory of a thread for it.
struct FacetAllHitsScratch {
  FacetScratch facets;
  FacetLists lists;
};

/// Records the crossings of at most 64 rays. On entry first hits are misses and all rays are
/// complete.
/// @return  one bit per ray that another kernel must trace
using CrossFacets = std::uint64_t (*)(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                      FacetChunk& chunk, FacetLists& lists, FacetScratch& scratch,
                                      KernelCounters& counters);

/// `baseline` uses the processor's best SSE up to SSE4, or else one lane.
CrossFacets cross_facets_on(Machine machine);

}  // namespace rhoray::render::wide

#include "render/triangles/intersectors.h"

#include "render/triangles/kernels/facet_kernels.h"

namespace rhoray::render::triangles {

namespace {

/// Builds the tree. Never answers a ray in advance.
std::optional<SurfaceBoxes> prepare_triangles(const VolumeImplementation& volume, const RayQuery&, unsigned threads) {
  volume.facets->of(std::get<SurfaceVolume>(volume.view), volume.bounds_volume, 0, threads);
  return std::nullopt;
}

}  // namespace

Intersectors intersectors(const VolumeImplementation& volume, const RayQuery& query, Machine machine) {
  const ReferenceKernels reference = reference_kernels(std::get<SurfaceVolume>(volume.view), query.method.algorithm);
  Intersectors found{.first_hit = reference.first_hit,
                     .largest = reference.largest,
                     .prepare = prepare_triangles,
                     .queue_entries = reference.queue_entries,
                     .keeps_to_bounds = true};
  wide::use_facets(volume, query, machine, found);
  return found;
}

}  // namespace rhoray::render::triangles

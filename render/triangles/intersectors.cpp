#include "render/triangles/intersectors.h"

#include "render/triangles/kernels/facet_kernels.h"

namespace rhoray::render::triangles {

namespace {

/// Builds the tree. Never answers a ray in advance.
std::optional<SurfaceBoxes> prepare_triangles(const LoadedDataset& dataset, const RayQuery&, unsigned threads,
                                              const std::stop_token& stop) {
  dataset.facets->of(std::get<TriangleData>(dataset.view), dataset.bounds_data, 0, threads, stop);
  return std::nullopt;
}

}  // namespace

Intersectors intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine) {
  const ReferenceKernels reference = reference_kernels(std::get<TriangleData>(dataset.view), query.method.algorithm);
  Intersectors found{.first_hit = reference.first_hit,
                     .largest = reference.largest,
                     .prepare = prepare_triangles,
                     .queue_entries = reference.queue_entries,
                     .keeps_to_bounds = true};
  wide::use_facets(dataset, query, machine, found);
  return found;
}

}  // namespace rhoray::render::triangles

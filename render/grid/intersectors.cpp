#include "render/grid/intersectors.h"

#include "render/grid/all_hits/all_hits.h"
#include "render/grid/isosurface/isosurface.h"
#include "render/grid/largest/maximum.h"
#include "render/grid/shadow/grid_occluders.h"

namespace rhoray::render::grid {

namespace {

ReferenceKernels reference_of(const LoadedDataset& dataset, const Method& method) {
  if (const auto* uniform = std::get_if<UniformGrid>(&dataset.view))
    return reference_kernels(*uniform, method.algorithm);
  return reference_kernels(std::get<RectilinearGrid>(dataset.view), method.algorithm);
}

}  // namespace

Intersectors intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine) {
  const ReferenceKernels reference = reference_of(dataset, query.method);
  Intersectors found{.first_hit = reference.first_hit,
                     .largest = reference.largest,
                     .queue_entries = reference.queue_entries,
                     .keeps_to_bounds = true};
  if (const Kernel first_hit = wide::first_crossing_kernel(dataset, query.method, machine)) {
    found.first_hit = first_hit;
    found.prepare = wide::prepare_occupancy;
    found.occluders = &wide::grid_occluder_search;
  }
  if (const Kernel largest = wide::largest_value_kernel(dataset, query.method, machine)) found.largest = largest;
  found.all_hits = wide::grid_all_hits_kernel(dataset, query, machine);
  return found;
}

}  // namespace rhoray::render::grid

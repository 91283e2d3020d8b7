#include "render/tets/intersectors.h"

#include "render/tets/largest/maximum.h"
#include "render/triangles/kernels/facet_kernels.h"

namespace rhoray::render::tets {

namespace {

/// Methods that find a tetrahedron by its barycentric coordinates promise nothing for flat ones.
bool keeps_to_bounds(Method::Algorithm algorithm) {
  switch (algorithm) {
    case Method::Algorithm::direct:
    case Method::Algorithm::preview:
    case Method::Algorithm::certified:
    case Method::Algorithm::exact:
      return true;
    case Method::Algorithm::paper:
    case Method::Algorithm::slack:
    case Method::Algorithm::sampled:
      break;
  }
  return false;
}

}  // namespace

Intersectors intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine) {
  const ReferenceKernels reference = reference_kernels(std::get<TetData>(dataset.view), query.method.algorithm);
  Intersectors found{.first_hit = reference.first_hit,
                     .largest = reference.largest,
                     .queue_entries = reference.queue_entries,
                     .keeps_to_bounds = keeps_to_bounds(query.method.algorithm)};
  wide::use_facets(dataset, query, machine, found);
  if (const Kernel largest = wide::largest_value_in_tets_kernel(dataset, query.method, machine))
    found.largest = largest;
  return found;
}

}  // namespace rhoray::render::tets

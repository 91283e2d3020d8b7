#include "render/grid/all_hits/all_hits.h"
#include "render/query/all_hits.h"
#include "render/query/kernels.h"

#include <algorithm>
#include <cmath>

#include "render/grid/isosurface/isosurface.h"
#include "render/grid/largest/maximum.h"
#include "render/tets/largest/maximum.h"
#include "render/triangles/kernels/facet_kernels.h"

namespace rhoray::render {

Kernels choose_kernels(const VolumeImplementation& volume, const Method& method, Machine machine) {
  Kernels kernels = std::visit([&](const auto& view) { return kernels_for(view, method.algorithm); }, volume.view);
  if (const Kernel wide = wide::first_crossing_kernel(volume, method, machine)) {
    kernels.first_crossing = wide;
    kernels.prepare_first_crossing = wide::prepare_occupancy;
  }
  if (const Kernel wide = wide::first_facet_kernel(volume, method, machine)) {
    kernels.first_crossing = wide;
    kernels.prepare_first_crossing = wide::prepare_facets;
  }
  if (const Kernel wide = wide::largest_value_kernel(volume, method, machine)) kernels.largest_value = wide;
  if (const Kernel wide = wide::largest_value_in_tets_kernel(volume, method, machine)) kernels.largest_value = wide;
  return kernels;
}

AllHitsKernel all_hits_kernel(const VolumeImplementation& volume, const RayQuery& query, Machine machine) {
  if (const AllHitsKernel of_grid = wide::grid_all_hits_kernel(volume, query, machine)) return of_grid;
  return wide::facet_all_hits_kernel(volume, query, machine);
}

bool keeps_to_bounds(const VolumeImplementation& volume, const Method& method) {
  const Vec3 size = volume.bounds_volume.size();
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest > 0 && std::isfinite(longest))) return false;
  switch (method.algorithm) {
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
  return volume.facets == nullptr;
}

bool finds_crossings_wide(const VolumeImplementation& volume) {
  const Method single = method_of(Accuracy::float32);
  return wide::first_crossing_kernel(volume, single, Machine::baseline) != nullptr ||
         wide::first_facet_kernel(volume, single, Machine::baseline) != nullptr;
}

void ask(Kernel kernel, const VolumeImplementation& volume, const RayQuery& query, std::span<const Ray> rays,
         std::span<Hit> hits, KernelScratch& scratch) {
  constexpr std::size_t batch_size = 1024;
  RayBatch asked(std::min(rays.size(), batch_size));
  asked.has_start_sides = true;
  HitBatch answered(std::min(rays.size(), batch_size));
  for (std::size_t first = 0; first < rays.size(); first += batch_size) {
    asked.count = std::min(batch_size, rays.size() - first);
    for (std::size_t r = 0; r < asked.count; ++r) asked.set(r, rays[first + r]);
    kernel(volume, query, asked, answered, scratch);
    for (std::size_t r = 0; r < asked.count; ++r) hits[first + r] = answered[r];
  }
}

}  // namespace rhoray::render

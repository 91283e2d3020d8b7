#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>

#include "render/grid/all_hits/all_hits.h"
#include "render/grid/all_hits/parts.h"
#include "render/grid/isosurface/grid_surface.h"
#include "render/query/kernel_on.h"

namespace rhoray::render::wide {

namespace {

/// Clears the kept blocks if they belong to other surfaces.
void keep_blocks_of(GridAllHitsScratch& scratch,
                    const std::array<std::shared_ptr<const Occupancy>, most_surfaces>& occupancies) {
  if (scratch.occupancies == occupancies) return;
  std::fill(std::begin(scratch.block_key), std::end(scratch.block_key), IsosurfaceScratch::no_block);
  scratch.occupancies = occupancies;
}

/// Computes TransparentSurfaces::surely_lit.
std::int32_t surely_lit_of(const AllHitsQuery& query) {
  // More than the rounding of products in any order.
  const float enough = query.least_light * (1 + 0x1p-18F);
  const float passing = std::min(query.surfaces.front().passing, query.surfaces.back().passing);
  std::int32_t count = 0;
  for (float light = passing; light >= enough && count < std::int32_t{CrossingList::most}; light *= passing) ++count;
  return count;
}

TransparentSurfaces transparent_surfaces_of(const UniformGrid& view, const LoadedDataset& dataset,
                                            const AllHitsQuery& query, GridAllHitsScratch& scratch) {
  const TransparentSurface &first = query.surfaces.front(), &last = query.surfaces.back();
  keep_blocks_of(scratch, {dataset.occupancies->of(view.ranges(), first.isovalue),
                           dataset.occupancies->of(view.ranges(), last.isovalue)});
  TransparentSurfaces surfaces{.surface = {surface_of(view, *scratch.occupancies[0],
                                                      {.isovalue = first.isovalue, .time_phases = query.time_phases}),
                                           surface_of(view, *scratch.occupancies[1],
                                                      {.isovalue = last.isovalue, .time_phases = query.time_phases})},
                               .passing = {},
                               .surely_lit = surely_lit_of(query),
                               .least_inside = {},
                               .is_single = {},
                               .count = static_cast<int>(query.surfaces.size()),
                               .least_light = query.least_light,
                               .only_places = query.only_places};
  for (std::size_t s = 0; s < most_surfaces; ++s) {
    const double isovalue = surfaces.surface[s].isovalue;
    const auto nearest = static_cast<float>(isovalue);
    float light = 1;
    for (float& passing : surfaces.passing[s]) passing = light, light *= (s == 0 ? first : last).passing;
    surfaces.is_single[s] = static_cast<double>(nearest) == isovalue;
    surfaces.least_inside[s] = static_cast<double>(nearest) < isovalue
                                   ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
                                   : nearest;
  }
  return surfaces;
}

template <Machine machine>
void cross(const LoadedDataset& dataset, const AllHitsQuery& query, const RayBatch& rays,
           std::span<CrossingList* const> lists, std::uint8_t* complete, Scratch& scratch, KernelCounters& counters) {
  const UniformGrid& view = std::get<UniformGrid>(dataset.view);
  GridAllHitsScratch& memory = scratch.as<GridAllHitsScratch>();
  const TransparentSurfaces surfaces = transparent_surfaces_of(view, dataset, query, memory);
  CrossingArrays arrays[most_surfaces];
  for (std::size_t s = 0; s < lists.size(); ++s) {
    arrays[s] = arrays_of(*lists[s]);
    if (query.only_places)
      std::fill_n(arrays[s].hits[0].t, rays.count, std::numeric_limits<double>::infinity());
    else
      write_misses(arrays[s].hits[0], rays.count);
    std::fill_n(arrays[s].count, rays.count, std::uint8_t{0});
  }
  std::fill_n(complete, rays.count, std::uint8_t{1});
  counters.rays_wide += rays.count;
  const FindAllHits answer = find_all_hits_on(machine);
  for (std::size_t first = 0; first < rays.count; first += RayGroup::size)
    answer(surfaces, arrays_of(rays), first, std::min(RayGroup::size, rays.count - first), arrays, complete, memory,
           counters);
}

}  // namespace

AllHitsKernel grid_all_hits_kernel(const LoadedDataset& dataset, const RayQuery& query, Machine machine) {
  const bool is_known = has_wide_crossings(query.method) && query.method.algorithm == Method::Algorithm::direct;
  const UniformGrid* view = fit_grid(dataset);
  if (!is_known || view == nullptr || !is_answerable_wide(*view, query) || view->has_gaps()) return nullptr;
  return kernel_on(machine, []<Machine wide>() -> AllHitsKernel { return cross<wide>; });
}

}  // namespace rhoray::render::wide

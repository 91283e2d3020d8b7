#include "render/tets/largest/maximum.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/query/compiled_for.h"
#include "render/query/kernel_on.h"
#include "render/tets/largest/parts.h"
#include "render/tets/reference/largest.h"

namespace rhoray::render::wide {

namespace {

/// As in the scalar kernel, which visits a cell when the ray hits its cluster's box.
RHORAY_INLINE void look_at(const void* context, const RayArrays& rays, const TetSuspect* suspects, std::size_t count,
                           LargestSoFar* found) {
  const TetData& view = *static_cast<const TetData*>(context);
  const formats::CellClustersView& clusters = view.clusters();
  KernelCounters unused;
  for (std::size_t s = 0; s < count; ++s) {
    const auto [most, tet, r] = suspects[s];
    if (most < found[r].value) continue;
    const Ray ray{.origin = {rays.origin[0][r], rays.origin[1][r], rays.origin[2][r]},
                  .direction = {rays.direction[0][r], rays.direction[1][r], rays.direction[2][r]},
                  .t_min = rays.t_min[r],
                  .t_max = rays.t_max[r]};
    const std::uint64_t cluster = clusters.cluster_of(tet);
    const BoxRay::Parts parts = BoxRay(ray, clusters.box_unit).meet(clusters.boxes[0][cluster / BoxRay::width]);
    if (parts.is_met(cluster % BoxRay::width)) ValuesAlong(view, ray, unused, found[r]).look_into(tet);
  }
}

TetMaximumField field_of(const LoadedDataset& dataset, const TetData& view, const RayQuery& query, Machine machine) {
  const formats::CellClustersView& clusters = view.clusters();
  TetMaximumField field{.points = view.points().data()->data(),
                        .values = view.stored_values(),
                        .is_single = view.is_float(),
                        .has_gaps = dataset.field.no_data_count > 0,
                        .range = dataset.field.range,
                        .table_starts = clusters.table_starts.data(),
                        .tables = clusters.tables.data(),
                        .corners = clusters.corners.data()->data(),
                        .cell_count = clusters.shape.cell_count,
                        .cluster_size = clusters.shape.cluster_size,
                        .box_unit = clusters.box_unit,
                        .top_level = clusters.shape.top_level(),
                        .boxes = {},
                        .ranges = {},
                        .low = {},
                        .high = {},
                        .time_phases = query.time_phases,
                        .look = compiled_for<look_at>(machine),
                        .cell_id = [](const void* context,
                                      std::uint32_t tet) { return static_cast<const TetData*>(context)->cell_id(tet); },
                        .context = &view};
  for (int level = 0; level <= field.top_level; ++level) {
    field.boxes[level] = clusters.boxes[static_cast<std::size_t>(level)].data();
    field.ranges[level] = view.stored_cluster_ranges(level);
  }
  for (int axis = 0; axis < 3; ++axis)
    field.low[axis] = dataset.bounds_data.min[axis], field.high[axis] = dataset.bounds_data.max[axis];
  return field;
}

/// True when both belong to the same object, which may be gone. Distinguishes objects that used the
/// same address one after another.
bool is_same_object(const std::weak_ptr<const FacetsCache>& a, const std::shared_ptr<FacetsCache>& b) {
  return !a.owner_before(b) && !b.owner_before(a);
}

/// Returns the thread's memory, without cached clusters of another volume.
TetMaximumScratch& prepared(Scratch& scratch, const LoadedDataset& dataset) {
  TetMaximumScratch& memory = scratch.as<TetMaximumScratch>();
  if (!is_same_object(memory.of_dataset, dataset.facets)) {
    for (LocalCluster& cluster : memory.clusters) cluster.cluster = LocalCluster::none;
    memory.of_dataset = dataset.facets;
  }
  return memory;
}

template <Machine machine>
void largest_values(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                    KernelScratch& scratch) {
  const TetData& view = std::get<TetData>(dataset.view);
  const Kernel reference = reference_kernels(view, query.method.algorithm).largest;
  if (!query.use_hierarchy) return reference(dataset, query, rays, hits, scratch);
  scratch.counters.rays_wide += rays.count;
  const TetMaximumField field = field_of(dataset, view, query, machine);
  TetMaximumScratch& memory = prepared(scratch.for_largest, dataset);
  const TetLargestValues search = tet_largest_values_on(machine);
  for (std::size_t first = 0; first < rays.count; first += RayGroup::size) {
    const std::size_t count = std::min(RayGroup::size, rays.count - first);
    const std::uint64_t left = search(field, from(rays, first), count, memory, scratch.counters);
    for (std::size_t r = 0; r < count; ++r) {
      Hit hit = memory.found[r].hit();
      hit.cost = memory.cost[lane_of(r)];
      hits.set(first + r, hit);
    }
    if (left != 0) ask_again(reference, dataset, query, rays, first, left, hits, memory.others, scratch);
  }
}

/// True for a mesh with clusters whose products of lengths and values stay far from the limits of
/// doubles.
bool is_fit(const LoadedDataset& dataset) {
  const Vec3 size = dataset.bounds_data.size();
  const double longest = std::max({size.x, size.y, size.z});
  const Interval<double>& range = dataset.field.range;
  return std::get<TetData>(dataset.view).has_clusters() && longest >= 1 / largest_magnitude &&
         longest <= largest_magnitude &&
         (range.is_empty() || (std::abs(range.lo) <= largest_magnitude && std::abs(range.hi) <= largest_magnitude));
}

bool is_direct(Method::Algorithm algorithm) {
  return algorithm == Method::Algorithm::direct || algorithm == Method::Algorithm::preview ||
         algorithm == Method::Algorithm::slack || algorithm == Method::Algorithm::paper;
}

}  // namespace

Kernel largest_value_in_tets_kernel(const LoadedDataset& dataset, const Method& method, Machine machine) {
  if (!is_direct(method.algorithm) || !is_fit(dataset)) return nullptr;
  return kernel_on(machine, []<Machine wide>() -> Kernel { return largest_values<wide>; });
}

}  // namespace rhoray::render::wide

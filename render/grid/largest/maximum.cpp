#include "render/grid/largest/maximum.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "render/dataset/fit_grid.h"
#include "render/grid/largest/parts.h"
#include "render/grid/reference/largest.h"
#include "render/query/batch_arrays.h"
#include "render/query/kernel_of.h"
#include "render/query/kernel_on.h"

namespace rhoray::render::wide {

namespace {

/// A whole cell on a ray's way, as walk_level visits it.
template <class Planes>
CellVisit whole_visit(const PlaneTimesOf<Planes>& planes, const Segment& segment, const Index3& cell) {
  CellVisit visit{.cell = cell, .t_in = segment.t_in, .t_out = segment.t_out, .axis_in = -1, .axis_out = -1};
  for (int axis = 0; axis < 3; ++axis) {
    const int step = planes.step(axis);
    if (step == 0) continue;
    const double entry = planes.at(axis, step > 0 ? cell[axis] : cell[axis] + 1);
    const double exit = planes.at(axis, step > 0 ? cell[axis] + 1 : cell[axis]);
    if (entry >= visit.t_in) visit.t_in = entry, visit.axis_in = axis;
    if (exit < visit.t_out || (exit == visit.t_out && visit.axis_out < 0)) visit.t_out = exit, visit.axis_out = axis;
  }
  return visit;
}

void look_closely(const void* context, const RayArrays& rays, std::size_t r, double t_from, double t_to,
                  FoundMaximum& found) {
  const UniformGrid& view = *static_cast<const UniformGrid*>(context);
  const Ray ray{.origin = {rays.origin[0][r], rays.origin[1][r], rays.origin[2][r]},
                .direction = {rays.direction[0][r], rays.direction[1][r], rays.direction[2][r]},
                .t_min = rays.t_min[r],
                .t_max = rays.t_max[r]};
  const auto planes = view.plane_times(ray);
  const WalkLattice lattice = view.lattice();
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, lattice.leaf_count);
  if (!segment) return;
  walk_level(ray, planes, lattice, 1, whole_level(lattice, 1), t_from, t_to, [&](const CellVisit& part) {
    const CellVisit visit = whole_visit(planes, *segment, part.cell);
    if (visit.has_no_length()) return true;
    const TrilinearCell cell = view.cell(visit.cell);
    if (!view.has_data(cell)) return true;
    const double bound = cell.largest();
    if (!(bound > found.value || (bound == found.value && visit.t_in < found.t))) return true;
    const CubicMaximum best = largest_in_cell<double>(cell, visit, entry_point(view.geometry(), ray, planes, visit),
                                                      exit_point(view.geometry(), ray, planes, visit), bound, false);
    const FoundMaximum here{best.value, visit.t_at(best.s), visit.t_in, view.cell_id(visit.cell)};
    if (is_better(here, found)) found = here;
    return true;
  });
}

StoredRanges ranges_of(const MacroRanges& ranges, int level) {
  if (level > ranges.shape().level_count) return {nullptr, {0, 0, 0}};
  const auto& [first, count] = ranges.level(level);
  return {first, {static_cast<int>(count.x), static_cast<int>(count.y), static_cast<int>(count.z)}};
}

MaximumField field_of(const UniformGrid& view, bool time_phases) {
  const Index3 leaf_count = view.lattice().leaf_count;
  const Interval<double>& values = view.values();
  const SampleSource& source = *view.source();
  MaximumField field{.source = source,
                     .type = source.type,
                     .sample_bytes = with_value_type(source.type, []<class T>(T) { return sizeof(T); }),
                     .leaf_count = {},
                     .node_count = {},
                     .blocks = ranges_of(view.ranges(), 1),
                     .nodes = ranges_of(view.ranges(), 2),
                     .range = values.is_empty() ? 0 : values.hi - values.lo,
                     .has_gaps = view.has_gaps(),
                     .has_squares = source.has_padded_squares,
                     .has_bricks = source.has_padded_bricks,
                     .time_phases = time_phases,
                     .look_closely = look_closely,
                     .context = &view};
  for (int axis = 0; axis < 3; ++axis) {
    field.leaf_count[axis] = static_cast<int>(leaf_count[axis]);
    field.node_count[static_cast<std::size_t>(axis)] = 4 * static_cast<int>((leaf_count[axis] + 63) / 64);
    if (!field.nodes.first) field.nodes.count[axis] = (field.blocks.count[axis] + 3) / 4;
  }
  return field;
}

Hit hit_of(const FoundMaximum& found, std::uint32_t cost) {
  Hit hit;
  if (found.value > -std::numeric_limits<double>::infinity())
    hit.t = found.t, hit.value = found.value, hit.cell = found.cell;
  hit.cost = cost;
  return hit;
}

template <Machine machine>
void largest_values(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                    KernelScratch& scratch) {
  const UniformGrid& view = std::get<UniformGrid>(dataset.view);
  if (!query.use_hierarchy)
    return reference_kernels(view, query.method.algorithm).largest(dataset, query, rays, hits, scratch);
  scratch.counters.rays_wide += rays.count;
  MaximumScratch& memory = scratch.for_largest.as<MaximumScratch>();
  memory.regions = memory.looks = memory.ticks = 0;
  std::uint64_t cells = 0;
  const MaximumField field = field_of(view, query.time_phases);
  const LargestValues search = largest_values_on(machine);
  for (std::size_t first = 0; first < rays.count; first += SearchedRays::size) {
    const std::size_t count = std::min(SearchedRays::size, rays.count - first);
    for (std::size_t r = 0; r < count; ++r) {
      memory.found[r] = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 0, 0};
      memory.cost[r] = 0;
    }
    search(field, from(rays, first), count, memory);
    for (std::size_t r = 0; r < count; ++r) {
      hits.set(first + r, hit_of(memory.found[r], memory.cost[r]));
      cells += memory.cost[r];
    }
  }
  scratch.counters.macrocells_visited += memory.regions;
  scratch.counters.cells_visited += cells;
  scratch.counters.cells_solved += memory.looks;
  scratch.counters.intersection_ticks += memory.ticks;
}

bool is_direct(Method::Algorithm algorithm) {
  return algorithm == Method::Algorithm::direct || algorithm == Method::Algorithm::preview ||
         algorithm == Method::Algorithm::slack;
}

}  // namespace

Kernel largest_value_kernel(const LoadedDataset& dataset, const Method& method, Machine machine) {
  if (!is_direct(method.algorithm)) return nullptr;
  const UniformGrid* view = fit_grid(dataset);
  if (view == nullptr) return nullptr;
  // Positions on it have enough digits in single precision.
  constexpr std::int64_t largest_size = 1 << 14;
  const Index3 size = view->lattice().leaf_count;
  const bool is_small = std::max({size.x, size.y, size.z}) <= largest_size;
  const Interval<double>& range = view->values();
  const bool has_range = range.is_empty() || std::isfinite(range.hi - range.lo);
  if (!is_small || !has_range) return nullptr;
  return kernel_on(machine, []<Machine wide>() -> Kernel { return largest_values<wide>; });
}

}  // namespace rhoray::render::wide

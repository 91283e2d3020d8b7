#include "render/grid/largest/maximum.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "render/dataset/grid_source.h"
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

template <class View>
void look_closely(const void* context, const RayArrays& rays, std::size_t r, double t_from, double t_to,
                  FoundMaximum& found) {
  const View& view = *static_cast<const View*>(context);
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

template <class T>
StoredRanges ranges_of(const formats::MacroLevelsView<T>& levels, int level) {
  if (level > levels.shape.level_count) return {nullptr, {0, 0, 0}};
  const Index3 count = levels.shape.count(level);
  return {levels.ranges[static_cast<std::size_t>(level - levels.first_level)].data(),
          {static_cast<int>(count.x), static_cast<int>(count.y), static_cast<int>(count.z)}};
}

/// True where each four samples of an axis are `step` apart and the last four are complete.
bool is_in_fours(const std::vector<std::uint64_t>& table, std::uint64_t step) {
  if (table.size() % 4 != 0) return false;
  for (std::size_t i = 0; i < table.size(); ++i)
    if (table[i] != table[i / 4 * 4] + i % 4 * step) return false;
  return true;
}

/// Samples 4 i to 4 i + 3 of x and 4 j to 4 j + 3 of y are contiguous, x fastest.
template <class T>
bool has_squares(const GridData<T>& view) {
  return is_in_fours(view.tables().x, 1) && is_in_fours(view.tables().y, 4);
}
template <class View>
requires is_in_bricks<View>
bool has_squares(const View&) {
  return false;
}

/// The same, and samples 4 k to 4 k + 3 of z with them.
template <class T>
bool has_bricks(const GridData<T>& view) {
  return has_squares(view) && is_in_fours(view.tables().z, 16);
}
template <class View>
requires is_in_bricks<View>
bool has_bricks(const View&) {
  return false;
}

template <class View>
MaximumField field_of(const LoadedDataset& dataset, const View& view, bool time_phases) {
  const Index3 leaf_count = view.lattice().leaf_count;
  const Interval<double> values = values_of(dataset);
  MaximumField field{.source = source_of(view),
                     .type = formats::element_type_of<typename View::Sample>(),
                     .sample_bytes = sizeof(typename View::Sample),
                     .leaf_count = {},
                     .node_count = {},
                     .blocks = ranges_of(view.levels(), 1),
                     .nodes = ranges_of(view.levels(), 2),
                     .range = values.is_empty() ? 0 : values.hi - values.lo,
                     .has_gaps = has_gaps(dataset, view),
                     .has_squares = has_squares(view),
                     .has_bricks = has_bricks(view),
                     .time_phases = time_phases,
                     .look_closely = look_closely<View>,
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

template <class View, Machine machine>
void largest_values(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                    KernelScratch& scratch) {
  const View& view = std::get<View>(dataset.view);
  if (!query.use_hierarchy)
    return reference_kernels(view, query.method.algorithm).largest(dataset, query, rays, hits, scratch);
  scratch.counters.rays_wide += rays.count;
  MaximumScratch& memory = scratch.for_largest.as<MaximumScratch>();
  memory.regions = memory.looks = memory.ticks = 0;
  std::uint64_t cells = 0;
  const MaximumField field = field_of(dataset, view, query.time_phases);
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
  if (!is_direct(method.algorithm) || !largest_values_on(machine)) return nullptr;
  return std::visit(
      [&](const auto& view) -> Kernel {
        using View = std::decay_t<decltype(view)>;
        if constexpr (is_taken_wide<View>) {
          // Positions on it have enough digits in single precision.
          constexpr std::int64_t largest_size = 1 << 14;
          const Index3 size = view.lattice().leaf_count;
          const bool is_small = std::max({size.x, size.y, size.z}) <= largest_size;
          const Interval<double> range = values_of(dataset);
          const bool has_range = range.is_empty() || std::isfinite(range.hi - range.lo);
          if (is_fit_grid(dataset) && is_small && has_range)
            return kernel_on(machine, []<Machine wide>() -> Kernel { return largest_values<View, wide>; });
        }
        return nullptr;
      },
      dataset.view);
}

}  // namespace rhoray::render::wide

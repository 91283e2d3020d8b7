#pragma once

#include "render/grid/reference/exact_view.h"

/// Queries of a grid, answered by exact arithmetic.
namespace rhoray::render {

namespace {

void count_effort(const ExactEffort& effort, KernelCounters& counters) {
  ++counters.rays_exact;
  counters.cells_visited += static_cast<std::uint64_t>(effort.cells_visited);
  counters.macrocells_visited += static_cast<std::uint64_t>(effort.regions_skipped);
  counters.cells_solved += static_cast<std::uint64_t>(effort.filtered + effort.exact);
}

template <class View>
Hit exact_first_hit(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const IntersectionTimer timer(query, scratch.counters);
  const ExactGridView grid(view, ray, query.use_hierarchy);
  const GridRayVerdict verdict = exact_first_crossing(grid, ray, query.isovalue, exact_grid_width(view, ray));
  count_effort(verdict.effort, scratch.counters);
  Hit hit;
  if (!verdict.is_hit) return hit;
  const Middle t(verdict.t);
  hit.t = t.value;
  hit.error = t.error;
  hit.value = query.isovalue;
  hit.cell = view.cell_id(verdict.cell);
  hit.root_count = static_cast<std::uint32_t>(std::max(verdict.root_count, 0));
  const Vec3 p = point_in_cell(view.geometry(), ray, verdict.cell, hit.t, -1, 0);
  hit.gradient = view.geometry().gradient(view.cell(verdict.cell).gradient(p), verdict.cell);
  if (verdict.touches) ++scratch.counters.touches;
  return hit;
}

template <class View>
Hit exact_largest_hit(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const IntersectionTimer timer(query, scratch.counters);
  const ExactGridView grid(view, ray, query.use_hierarchy);
  const GridMaximumVerdict verdict = exact_largest_value(grid, ray, exact_grid_width(view, ray));
  count_effort(verdict.effort, scratch.counters);
  Hit hit;
  if (!verdict.has_value) return hit;
  const Middle value(verdict.value);
  hit.t = Middle(verdict.t).value;
  hit.value = value.value;
  hit.error = value.error;
  hit.cell = view.cell_id(verdict.cell);
  return hit;
}

}  // namespace

}  // namespace rhoray::render

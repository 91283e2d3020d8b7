#pragma once

#include "render/exact/exact_grid.h"
#include "render/grid/reference/passage.h"

/// Queries of a grid, answered by exact arithmetic.
namespace rhoray::render {

namespace {

/// Adapts a view to the interface of the exact code.
template <class View>
class ExactGridView final : public ExactGridSource {
 public:
  ExactGridView(const View& view, const Ray& ray, bool use_hierarchy)
      : view_(view), planes_(view.plane_times(ray).planes()), level_count_(use_hierarchy ? view.level_count() : 0) {}

  Index3 cell_count() const override { return view_.lattice().leaf_count; }
  std::array<double, 8> corners(const Index3& cell) const override { return view_.cell(cell).corner; }
  double plane(int axis, std::int64_t plane) const override { return planes_.position(axis, plane); }
  int level_count() const override { return level_count_; }
  CellRegion region(int level, const Index3& cell) const override {
    const WalkLattice lattice = view_.lattice();
    const std::int64_t edge = lattice.cell_edge(level);
    CellRegion region;
    Index3 at;
    for (int a = 0; a < 3; ++a) {
      at[a] = cell[a] / edge;
      region.first[a] = at[a] * edge;
      region.end[a] = std::min(region.first[a] + edge, lattice.leaf_count[a]);
    }
    const Interval<double> range = view_.range(level, at);
    region.smallest = range.lo;
    region.largest = range.hi;
    return region;
  }

 private:
  using Planes = std::decay_t<decltype(std::declval<const View&>().plane_times(std::declval<const Ray&>()).planes())>;

  const View& view_;
  Planes planes_;
  int level_count_;
};

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
  const GridRayVerdict verdict =
      exact_first_crossing(grid, ray, query.isovalue, exact_width_cells * t_per_cell(view, ray));
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
  const GridMaximumVerdict verdict = exact_largest_value(grid, ray, exact_width_cells * t_per_cell(view, ray));
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

#pragma once

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

#include "render/exact/exact_grid.h"
#include "render/grid/reference/passage.h"

/// A grid as the input of exact arithmetic, for all ways in which samples can be stored and
/// positioned.
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

/// The width of the enclosures of t.
template <class View>
double exact_grid_width(const View& view, const Ray& ray) {
  return exact_width_cells * t_per_cell(view, ray);
}

}  // namespace

}  // namespace rhoray::render

#pragma once

#include "render/grid/reference/passage.h"
#include "render/query/sampling.h"

namespace rhoray::render {

namespace {

/// A ray through a grid (sampling.h). On uneven axes a step is counted in cells of mean width.
template <class View>
class GridSampler {
 public:
  GridSampler(const View& view, const Ray& ray) : view_(view), ray_(ray), planes_(view.plane_times(ray)) {}

  WalkLattice lattice() const { return view_.lattice(); }
  const auto& planes() const { return planes_; }
  const Ray& ray_lattice() const { return ray_; }
  int top_level() const { return view_.level_count(); }

  double steps_per_t() const { return 1 / t_per_cell(view_, ray_); }

  Interval<double> range(int level, const Index3& cell) const {
    if (level > 0) return view_.range(level, cell);
    const TrilinearCell corners = view_.cell(cell);
    if (!view_.has_data(corners)) return {};
    return {corners.smallest(), corners.largest()};
  }

  template <class MayHold, class Region>
  void walk(const SampledWalk& walk, KernelCounters& counters, MayHold&& may_hold, Region&& region) const {
    walk_lattice(*this, walk, counters, may_hold, region);
  }

  double sample(double t) const {
    const Index3 at = cell_at(ray_, planes_, lattice(), t);
    const TrilinearCell cell = view_.cell(at);
    if (!view_.has_data(cell)) return std::numeric_limits<double>::quiet_NaN();
    return cell.at(point_in_cell(view_.geometry(), ray_, at, t, -1, 0));
  }

  void complete(Hit& hit) const {
    const Index3 at = cell_at(ray_, planes_, lattice(), hit.t);
    const TrilinearCell cell = view_.cell(at);
    hit.cell = view_.cell_id(at);
    if (!view_.has_data(cell)) return;
    const Vec3 p = point_in_cell(view_.geometry(), ray_, at, hit.t, -1, 0);
    hit.gradient = view_.geometry().gradient(cell.gradient(p), at);
  }

 private:
  using PlaneTimesOfView = decltype(std::declval<const View&>().plane_times(std::declval<const Ray&>()));

  const View& view_;
  const Ray& ray_;
  PlaneTimesOfView planes_;
};

}  // namespace

}  // namespace rhoray::render

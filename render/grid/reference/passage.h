#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "render/query/intersection_timer.h"
#include "render/traverse/lattice_walk.h"

/// Shared by the kernels of grids, for all ways in which samples can be stored and positioned
/// (render/grid/grid_data.h): a ray's path through one cell, and the side of the isosurface that
/// it is on from cell to cell.
namespace rhoray::render {

namespace {  // one per source, so that the compiler sees that nothing else calls these

/// A point of the ray in a cell's own coordinates, [0, 1]^3. On the axis of the plane through which
/// the ray enters or leaves it is exactly 0 or 1, so that both cells at a face see the same point.
template <class Geometry>
RHORAY_INLINE Vec3 point_in_cell(const Geometry& geometry, const Ray& ray, const Index3& cell, double t, int axis,
                                 double at_axis) {
  Vec3 p;
  for (int a = 0; a < 3; ++a)
    p[a] =
        a == axis ? at_axis : std::clamp(geometry.in_cell(a, ray.origin[a] + t * ray.direction[a], cell[a]), 0.0, 1.0);
  return p;
}

template <class Geometry, class Planes>
RHORAY_INLINE Vec3 entry_point(const Geometry& geometry, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                               const CellVisit& visit) {
  const int axis = visit.axis_in;
  return point_in_cell(geometry, ray, visit.cell, visit.t_in, axis, axis >= 0 && planes.step(axis) < 0 ? 1 : 0);
}

template <class Geometry, class Planes>
RHORAY_INLINE Vec3 exit_point(const Geometry& geometry, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                              const CellVisit& visit) {
  const int axis = visit.axis_out;
  return point_in_cell(geometry, ray, visit.cell, visit.t_out, axis, axis >= 0 && planes.step(axis) < 0 ? 0 : 1);
}

/// The cell in which the ray is at t, up to rounding.
template <class Planes>
RHORAY_INLINE Index3 cell_at(const Ray& ray, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice, double t) {
  Index3 cell;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t count = lattice.leaf_count[a];
    const double at_planes = planes.planes().in_planes(a, ray.origin[a] + t * ray.direction[a], 0, count);
    cell[a] = static_cast<std::int64_t>(std::clamp(std::floor(at_planes), 0.0, static_cast<double>(count - 1)));
  }
  return cell;
}

/// How much t grows while the ray passes a cell of mean width.
template <class View>
double t_per_cell(const View& view, const Ray& ray) {
  const auto planes = view.plane_times(ray).planes();
  const Index3 count = view.lattice().leaf_count;
  Vec3 cells;
  for (int a = 0; a < 3; ++a)
    cells[a] =
        ray.direction[a] * static_cast<double>(count[a]) / (planes.position(a, count[a]) - planes.position(a, 0));
  return 1 / cells.length();
}

/// The side on which all these values lie; nothing when they lie on both sides.
RHORAY_INLINE std::optional<bool> side_of_all(const Interval<double>& values, double isovalue) {
  if (values.lo >= isovalue) return true;
  if (values.hi < isovalue) return false;
  return std::nullopt;
}

/// Writes what is known of a hit at a crossing in a cell, between the points in and out: all but
/// its value and error.
template <class View, class Crossing>
RHORAY_INLINE void complete(Hit& hit, const View& view, const CellVisit& visit, const TrilinearCell& cell,
                            const Vec3& in, const Vec3& out, const Crossing& found) {
  hit.t = visit.t_at(found.s);
  hit.cell = view.cell_id(visit.cell);
  hit.gradient = view.geometry().gradient(cell.gradient((1 - found.s) * in + found.s * out), visit.cell);
  hit.root_count = static_cast<std::uint32_t>(found.root_count);
  hit.iteration_count = static_cast<std::uint32_t>(found.iterations);
}

/// Tracks the side of the isosurface that a ray is on, from cell to cell.
template <class View>
class SideOnRay {
 public:
  /// A macrocell that was skipped because its values lie on one side.
  struct Passed {
    int level;
    CellVisit visit;
  };

  SideOnRay(const View& view, const Ray& ray) : view_(view), ray_(ray) {}

  /// Nothing while the ray has not met data since it started or since it crossed a region without
  /// data.
  const std::optional<bool>& inside() const { return inside_; }
  void forget() {
    inside_.reset();
    passed_.reset();
  }
  void set(bool inside) { inside_ = inside; }

  /// True where all values lie on the side that the ray is already on. If they lie on the other
  /// side, the region is searched: rounding may have put the ray there where it passed an edge
  /// between cells, and the change must not be lost.
  bool stays(const std::optional<bool>& side) {
    if (!side || (inside_ && *inside_ != *side)) return false;
    inside_ = side;
    return true;
  }
  void passes(int level, const CellVisit& visit) { passed_ = {level, visit}; }

  /// The macrocell skipped last, if nothing was searched since. The call resets it.
  std::optional<Passed> take_passed() { return std::exchange(passed_, std::nullopt); }

  /// True when the last leaf cell that the ray passes through in a macrocell has data; a
  /// macrocell's range does not include cells without data.
  template <class Planes>
  bool leaves_through_data(const Passed& passed, const PlaneTimesOf<Planes>& planes) const {
    const WalkLattice lattice = view_.lattice();
    bool has_data = false;
    auto enters = [](int, const CellVisit&) { return true; };
    auto leaf = [&](const CellVisit& visit) {
      if (!visit.has_no_length()) has_data = view_.has_data(view_.cell(visit.cell));
      return true;
    };
    const int below = passed.level - 1;
    walk_hierarchy(ray_, planes, lattice, below, children(lattice, passed.visit.cell, lattice.cell_edge(below)),
                   passed.visit.t_in, passed.visit.t_out, enters, leaf);
    return has_data;
  }

 private:
  const View& view_;
  const Ray& ray_;
  std::optional<bool> inside_;
  std::optional<Passed> passed_;
};

/// Walks a ray through the grid's hierarchy and tracks the side it is on. Searches the leaf cells
/// where the side may change.
/// @param look  (cell, visit, the macrocell skipped before it): returns true to go on
/// @param see   (level, visit), called for each region before any decision there: returns true to
///              go on
template <class View, class Planes, class See, class Look>
void walk_sides(const View& view, const RayQuery& query, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                const Segment& segment, KernelCounters& counters, SideOnRay<View>& side, See&& see, Look&& look) {
  const WalkLattice lattice = view.lattice();
  bool goes_on = true;
  auto enters = [&](int level, const CellVisit& visit) {
    if (!goes_on || !(goes_on = see(level, visit))) return false;
    ++counters.macrocells_visited;
    const Interval<double> range = view.range(level, visit.cell);
    if (range.is_empty()) {
      side.forget();
      return false;
    }
    if (!side.stays(side_of_all(range, query.isovalue))) return true;
    side.passes(level, visit);
    return false;
  };
  auto leaf = [&](const CellVisit& visit) {
    if (!goes_on || !(goes_on = see(0, visit))) return false;
    if (visit.has_no_length()) return true;
    ++counters.cells_visited;
    const TrilinearCell cell = view.cell(visit.cell);
    const auto before = side.take_passed();
    if (!view.has_data(cell)) {
      side.forget();
      return true;
    }
    if (side.stays(side_of_all({cell.smallest(), cell.largest()}, query.isovalue))) return true;
    const IntersectionTimer timer(query, counters);
    ++counters.cells_solved;
    return goes_on = look(cell, visit, before);
  };
  const int top = query.use_hierarchy ? view.level_count() : 0;
  walk_hierarchy(ray, planes, lattice, top, whole_level(lattice, lattice.cell_edge(top)), segment.t_in, segment.t_out,
                 enters, leaf);
}

}  // namespace

}  // namespace rhoray::render

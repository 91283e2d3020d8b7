#include <algorithm>
#include <cmath>
#include <utility>

#include "render/kernels/intersection_timer.h"
#include "render/kernels/kernels.h"
#include "render/kernels/largest_value_search.h"

namespace rhoray::render {

namespace {

/// A point of the ray in a cell's own coordinates, [0, 1]^3. On the axis of the plane through which the ray comes in or
/// leaves it is exactly 0 or 1: both cells at a face then see the same point.
RHORAY_INLINE Vec3 point_in_cell(const Ray& ray, const Index3& cell, double t, int axis, double at_axis) {
  Vec3 p;
  for (int a = 0; a < 3; ++a)
    p[a] =
        a == axis ? at_axis : std::clamp(ray.origin[a] + t * ray.direction[a] - static_cast<double>(cell[a]), 0.0, 1.0);
  return p;
}

RHORAY_INLINE Vec3 entry_point(const Ray& ray, const PlaneTimes& planes, const Index3& cell, double t, int axis) {
  return point_in_cell(ray, cell, t, axis, axis >= 0 && planes.step(axis) < 0 ? 1 : 0);
}

RHORAY_INLINE Vec3 exit_point(const Ray& ray, const PlaneTimes& planes, const Index3& cell, double t, int axis) {
  return point_in_cell(ray, cell, t, axis, axis >= 0 && planes.step(axis) < 0 ? 0 : 1);
}

struct PassedMacrocell {
  int level;
  CellVisit visit;
};

/// True when the last leaf cell that the ray passes through in a macrocell has data.
template <class View>
bool leaves_through_data(const View& view, const Ray& ray, const PlaneTimes& planes, const PassedMacrocell& passed) {
  const WalkLattice lattice = view.lattice();
  bool has_data = false;
  auto enters = [](int, const CellVisit&) { return true; };
  auto leaf = [&](const CellVisit& visit) {
    if (!visit.has_no_length()) has_data = view.has_data(view.cell(visit.cell));
    return true;
  };
  const int below = passed.level - 1;
  walk_hierarchy(ray, planes, lattice, below, children(lattice, passed.visit.cell, lattice.cell_edge(below)),
                 passed.visit.t_in, passed.visit.t_out, enters, leaf);
  return has_data;
}

template <class View, bool timed>
Hit first_crossing(const View& view, const Question& question, const Ray& ray, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = view.lattice();
  const PlaneTimes planes(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, lattice.leaf_count);
  if (!segment) return hit;
  const double iso = question.isovalue;

  // The side on which the ray is; nothing while it has not met data since it started or crossed a region without.
  std::optional<bool> inside;
  // The macrocell that was passed over last, when nothing was looked into since.
  std::optional<PassedMacrocell> passed;
  // True where all values lie on the side on which the ray already is. On the other side the region is looked into:
  // rounding may have put the ray there where it passed an edge between cells, and the change of side must not be lost.
  const auto nothing_changes = [&](const Interval<double>& range) {
    std::optional<bool> side;
    if (range.lo >= iso)
      side = true;
    else if (range.hi < iso)
      side = false;
    if (!side || (inside && *inside != *side)) return false;
    inside = side;
    return true;
  };

  auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    const Interval<double> range = view.range(level, visit.cell);
    if (range.is_empty()) {
      inside.reset();
      return false;
    }
    if (!nothing_changes(range)) return true;
    passed = {level, visit};
    return false;
  };
  auto leaf = [&](const CellVisit& visit) {
    if (visit.has_no_length()) return true;
    ++counters.cells_visited;
    const TrilinearCell cell = view.cell(visit.cell);
    const std::optional<PassedMacrocell> before = std::exchange(passed, std::nullopt);
    if (!view.has_data(cell)) {
      inside.reset();
      return true;
    }
    if (nothing_changes({cell.smallest(), cell.largest()})) return true;

    const IntersectionTimer<timed> timer(counters);
    ++counters.cells_solved;
    const Vec3 p_in = entry_point(ray, planes, visit.cell, visit.t_in, visit.axis_in);
    const Vec3 p_out = exit_point(ray, planes, visit.cell, visit.t_out, visit.axis_out);
    const Cubic cubic = cell.along(p_in, p_out, iso);
    const bool starts_inside = is_inside(cubic.b[0]);
    // A macrocell's range says nothing of cells without data in it: the side that was taken from there may be no longer
    // known where the ray leaves it.
    if (inside && *inside != starts_inside && before && !leaves_through_data(view, ray, planes, *before))
      inside.reset();
    if (!inside) inside = starts_inside;
    const std::optional<double> s = first_change_of_side(cubic, *inside);
    if (!s) return true;  // the side at the exit is the side at the entry
    hit.t = visit.t_at(*s);
    hit.value = iso;
    hit.cell = view.cell_id(visit.cell);
    hit.gradient = cell.gradient((1 - *s) * p_in + *s * p_out);
    return false;
  };

  const int top = question.use_hierarchy ? view.level_count() : 0;
  walk_hierarchy(ray, planes, lattice, top, whole_level(lattice, lattice.cell_edge(top)), segment->t_in, segment->t_out,
                 enters, leaf);
  return hit;
}

/// The cell in which the ray is at t, up to rounding.
RHORAY_INLINE Index3 cell_at(const Ray& ray, const WalkLattice& lattice, double t) {
  Index3 cell;
  for (int a = 0; a < 3; ++a) {
    const double last = static_cast<double>(lattice.leaf_count[a] - 1);
    cell[a] = static_cast<std::int64_t>(std::clamp(std::floor(ray.origin[a] + t * ray.direction[a]), 0.0, last));
  }
  return cell;
}

/// When the ray came through the last face before t, or t_in where it has met none: the face rule sees no other points.
RHORAY_INLINE double last_face_before(const Ray& ray, const PlaneTimes& planes, const WalkLattice& lattice, double t,
                                      double t_in) {
  const Index3 cell = cell_at(ray, lattice, t);
  double last = t_in;
  for (int a = 0; a < 3; ++a) {
    if (planes.step(a) == 0) continue;
    const double entered = planes.at(a, planes.step(a) > 0 ? cell[a] : cell[a] + 1);
    if (entered <= t && entered > last) last = entered;
  }
  return last;
}

/// A value that the ray reaches near t, lowered by about its rounding; -infinity where there is no data. It is a guess
/// that saves work: at t the ray may already be in another cell, by rounding.
template <class View>
double value_near(const View& view, const WalkLattice& lattice, const Ray& ray, double t) {
  const Index3 cell = cell_at(ray, lattice, t);
  const TrilinearCell corners = view.cell(cell);
  if (!view.has_data(corners)) return -std::numeric_limits<double>::infinity();
  const double magnitude = std::max(std::abs(corners.smallest()), std::abs(corners.largest()));
  return corners.at(point_in_cell(ray, cell, t, -1, 0)) - 1e-12 * magnitude;
}

template <class View, bool timed, MipMethod method>
Hit largest_value(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  const WalkLattice lattice = view.lattice();
  const PlaneTimes planes(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, lattice.leaf_count);
  if (!segment) return {};
  KernelCounters& counters = scratch.counters;

  double lower_bound = -std::numeric_limits<double>::infinity();
  if (question.use_last_t) {
    const double middle = 0.5 * (segment->t_in + segment->t_out);
    double t = std::clamp(scratch.last_t.value_or(middle), segment->t_in, segment->t_out);
    if constexpr (method == MipMethod::face) t = last_face_before(ray, planes, lattice, t, segment->t_in);
    lower_bound = value_near(view, lattice, ray, t);
  }

  const auto bound = [&](int level, const Index3& at) {
    if (level > 0) {
      ++counters.macrocells_visited;
      return view.range(level, at).hi;
    }
    ++counters.cells_visited;
    const TrilinearCell cell = view.cell(at);
    return view.has_data(cell) ? cell.largest() : -std::numeric_limits<double>::infinity();
  };
  const auto open_leaf = [&](const MaximumQueue::Entry& entry, const auto& offer) {
    const IntersectionTimer<timed> timer(counters);
    ++counters.cells_solved;
    const TrilinearCell cell = view.cell(entry.cell);
    // Measured from the cell's largest value, which is its bound: no sum is above zero, and a plateau is exactly zero.
    const CellVisit visit{entry.cell, entry.t_in, entry.t_out, entry.axis_in, entry.axis_out};
    const Cubic cubic = cell.along(entry_point(ray, planes, visit.cell, visit.t_in, visit.axis_in),
                                   exit_point(ray, planes, visit.cell, visit.t_out, visit.axis_out), entry.bound);
    CubicMaximum best{cubic.b[0], 0};
    if constexpr (method == MipMethod::exact)
      best = render::largest_value(cubic);
    else if (cubic.b[3] > cubic.b[0])
      best = {cubic.b[3], 1};
    offer(entry.bound + best.value, visit.t_at(best.s), view.cell_id(visit.cell));
  };
  const int top = question.use_hierarchy ? view.level_count() : 0;
  Hit hit = largest_value_search(ray, lattice, top, lower_bound, scratch, bound, open_leaf);
  // A lower bound that rounding made too high drops everything, the answer too; it never gives another one.
  constexpr double no_bound = -std::numeric_limits<double>::infinity();
  if (hit.is_miss() && lower_bound > no_bound)
    hit = largest_value_search(ray, lattice, top, no_bound, scratch, bound, open_leaf);
  if (!hit.is_miss()) scratch.last_t = hit.t;
  return hit;
}

template <class View, bool timed>
void first_crossing_kernel(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                           std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r)
    hits[r] = first_crossing<View, timed>(view, question, rays[r], scratch.counters);
}

template <class View, bool timed, MipMethod method>
void largest_value_kernel(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                          std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r)
    hits[r] = largest_value<View, timed, method>(view, question, rays[r], scratch);
}

template <class View, bool timed>
Kernels choose(const View& view, MipMethod method) {
  return {.first_crossing = first_crossing_kernel<View, timed>,
          .largest_value = method == MipMethod::exact ? largest_value_kernel<View, timed, MipMethod::exact>
                                                      : largest_value_kernel<View, timed, MipMethod::face>,
          .queue_entries = largest_queue_size(view.lattice(), view.level_count())};
}

}  // namespace

template <class View>
Kernels kernels_for(const View& view, MipMethod method, bool timed) {
  return timed ? choose<View, true>(view, method) : choose<View, false>(view, method);
}

template Kernels kernels_for(const GridVolume<std::uint8_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::int8_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::uint16_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::int16_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::uint32_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::int32_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<float>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<double>&, MipMethod, bool);
template Kernels kernels_for(const NanoVdbVolume&, MipMethod, bool);

}  // namespace rhoray::render

#pragma once

#include "render/cell/crossing_methods.h"
#include "render/grid/reference/passage.h"

/// The first crossing with a grid's isosurface by the methods that search one cell after another:
/// direct, preview and the paper's.
namespace rhoray::render {

namespace {

RHORAY_INLINE CrossingMethod in_cell_method(Method::Algorithm algorithm) {
  return algorithm == Method::Algorithm::paper     ? CrossingMethod::paper
         : algorithm == Method::Algorithm::preview ? CrossingMethod::preview
                                                   : CrossingMethod::bracketed;
}

/// The ray in the coordinates of a cell.
template <class Geometry>
RHORAY_INLINE CellPassage passage_of(const Geometry& geometry, const Ray& ray, const CellVisit& visit, const Vec3& in,
                                     const Vec3& out) {
  CellPassage passage{.in = in, .out = out, .origin = {}, .direction = {}, .t_in = visit.t_in, .t_out = visit.t_out};
  for (int a = 0; a < 3; ++a) {
    passage.origin[a] = geometry.in_cell(a, ray.origin[a], visit.cell[a]);
    passage.direction[a] = geometry.direction_in_cell(a, ray.direction[a], visit.cell[a]);
  }
  return passage;
}

/// True where a ray that starts in a crossing does not get farther from the surface in this cell
/// than the start's own error. The ray may then be in this cell, or on this side, only because the
/// position of the crossing is rounded.
RHORAY_INLINE bool stays_at_start(const TrilinearCell& cell, const Vec3& in, const Vec3& out, double isovalue) {
  const double near = start_error_cells * (cell.largest() - cell.smallest());
  const CubicOf<double> cubic = minus<double>(cell, isovalue).cell.along(in, out);
  return std::all_of(cubic.b.begin(), cubic.b.end(), [&](double b) { return std::abs(b) <= near; });
}

template <class Real, class View>
Hit crossing_by_method(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters) {
  Hit hit;
  const auto planes = view.plane_times(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, view.lattice().leaf_count);
  if (!segment) return hit;
  const double iso = query.isovalue;
  const CrossingMethod method = in_cell_method(query.method.algorithm);

  SideOnRay side(view, ray);
  bool starts_in_crossing = ray.start_side != StartSide::unknown;
  if (starts_in_crossing) side.set(ray.start_side == StartSide::inside);
  const auto see = [](int, const CellVisit&) { return true; };
  const auto look = [&](const TrilinearCell& cell, const CellVisit& visit, const auto& before) {
    const Vec3 in = entry_point(view.geometry(), ray, planes, visit);
    const Vec3 out = exit_point(view.geometry(), ray, planes, visit);
    if (!side.inside()) starts_in_crossing = false;  // there were cells without data between
    if (starts_in_crossing && stays_at_start(cell, in, out, iso)) return true;
    const bool starts_inside = is_inside(minus<Real>(cell, iso).cell.at(Imath::Vec3<Real>(in)));
    // A macrocell's range does not include cells without data. So the side taken from that range
    // may no longer be known where the ray leaves the macrocell.
    if (side.inside() && *side.inside() != starts_inside && before && !side.leaves_through_data(*before, planes))
      side.forget();
    if (!side.inside()) side.set(starts_inside);
    CellPassage passage = passage_of(view.geometry(), ray, visit, in, out);
    passage.starts_in_crossing = std::exchange(starts_in_crossing, false);
    const CellCrossing found = find_crossing<Real>(method, cell, passage, iso, *side.inside());
    if (!found.crosses) return true;  // the side at the exit is the side at the entry
    complete(hit, view, visit, cell, in, out, found);
    hit.value = iso;
    return false;
  };
  walk_sides(view, query, ray, planes, *segment, counters, side, see, look);
  return hit;
}

template <class View>
Hit first_crossing_of_ray(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  return query.method.precision == Method::Precision::float32
             ? crossing_by_method<float>(view, query, ray, scratch.counters)
             : crossing_by_method<double>(view, query, ray, scratch.counters);
}

}  // namespace

}  // namespace rhoray::render

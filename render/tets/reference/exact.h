#pragma once

#include <vector>

#include "render/tets/reference/exact_cells.h"

/// Queries of a mesh in exact arithmetic.
namespace rhoray::render {

namespace {

template <class View>
Hit exact_first_hit(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const IntersectionTimer timer(query, scratch.counters);
  ++scratch.counters.rays_exact;
  const std::vector<ExactTet> tets = crossed_cells(view, query, ray, scratch.counters);
  const TetRayVerdict verdict = exact_first_crossing(tets, ray, query.isovalue, exact_mesh_width(view, ray));
  Hit hit;
  if (!verdict.is_hit) return hit;
  const Middle t(verdict.t);
  fill_in(hit, view, query, tet_of(verdict), t.value);
  hit.error = t.error;
  if (verdict.touches) ++scratch.counters.touches;
  return hit;
}

template <class View>
Hit exact_largest_hit(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const IntersectionTimer timer(query, scratch.counters);
  ++scratch.counters.rays_exact;
  const std::vector<ExactTet> tets = shown(
      view,
      tets_along(view, query, ray, scratch.counters, [](const Interval<double>& range) { return !range.is_empty(); }));
  const TetMaximumVerdict verdict = exact_largest_value(tets, ray);
  Hit hit;
  if (!verdict.has_value) return hit;
  const Middle value(verdict.value);
  hit.t = Middle(verdict.t).value;
  hit.value = value.value;
  hit.error = value.error;
  hit.cell = view.cell_id(tet_of(verdict));
  return hit;
}

}  // namespace

}  // namespace rhoray::render

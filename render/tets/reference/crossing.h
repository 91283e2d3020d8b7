#pragma once

#include "render/tets/reference/walk.h"

/// The first crossing of a mesh's isosurface by the methods that test one tetrahedron after
/// another.
namespace rhoray::render {

namespace {

RHORAY_INLINE TetMethod in_tet_method(Method::Algorithm algorithm) {
  return algorithm == Method::Algorithm::paper   ? TetMethod::paper
         : algorithm == Method::Algorithm::slack ? TetMethod::slack
                                                 : TetMethod::edges;
}

/// Returns the nearest crossing in the tetrahedra that a traversal visits.
/// @param walk  (matters_from, look, ends_at): called like walk_active_tets
template <class Real, class View, class Walk>
Hit nearest_crossing(const View& view, const RayQuery& query, const Ray& ray, Walk&& walk) {
  const TetMethod method = in_tet_method(query.method.algorithm);
  const TetRay<Real> tet_ray(ray);
  Hit hit;
  std::uint32_t hit_tet = 0;
  const auto look = [&](std::uint32_t tet, const LocalTet& local) {
    const std::optional<double> t =
        ray.start_side == StartSide::unknown
            ? find_crossing<Real>(method, tet_ray, local.points, local.values, query.isovalue, query.method.slack)
            : find_exit_crossing<Real>(tet_ray, local.points, local.values, query.isovalue,
                                       ray.start_side == StartSide::inside);
    if (!t || *t > hit.t || (*t == hit.t && !is_preferred(view, tet, hit_tet))) return;
    hit.t = *t;
    hit_tet = tet;
  };
  // A tetrahedron may extend over several leaf cells: a crossing behind this leaf cell is not final
  // until the ray gets there.
  walk([&](double t_in) { return !(hit.t < t_in); }, look, [&](double t_out) { return !(hit.t <= t_out); });
  if (!hit.is_miss()) fill_in(hit, view, query, hit_tet, hit.t);
  return hit;
}

template <class Real, class View>
Hit crossing_by_method(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters) {
  return nearest_crossing<Real>(view, query, ray, [&](auto&& matters_from, auto&& look, auto&& ends_at) {
    walk_active_tets(view, query, ray, counters, matters_from, look, ends_at);
  });
}

template <class View>
Hit first_crossing_of_ray(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  return query.method.precision == Method::Precision::float32
             ? crossing_by_method<float>(view, query, ray, scratch.counters)
             : crossing_by_method<double>(view, query, ray, scratch.counters);
}

}  // namespace

}  // namespace rhoray::render

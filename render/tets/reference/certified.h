#pragma once

#include "render/tets/reference/exact.h"

/// The first crossing of a mesh's isosurface, proven. Arithmetic of a given precision decides what
/// it can with its rounding included; the rest is decided in double precision, and what that cannot
/// decide by exact arithmetic. Proven for cells that are a partition of the mesh
/// (render/tets/reference/exact.h).
namespace rhoray::render {

namespace {

struct CertifiedTetHit {
  Hit hit;
  bool is_certain = true;
};

template <class Real, class View>
CertifiedTetHit certified_crossing(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const TetRay<Real> tet_ray(ray);
  std::uint32_t hit_tet = 0;
  double hit_t = infinity, hit_error = 0, earliest = infinity;
  double doubtful_from = infinity;  // no doubt before this t
  const auto look = [&](std::uint32_t tet, const LocalTet& local) {
    const CertifiedTetCrossing found = certify_tet_crossing<Real>(tet_ray, local.points, local.values, query.isovalue);
    if (found.decision == Decision::unknown) {
      for (const auto& point : local.points) doubtful_from = std::min(doubtful_from, tet_ray.shear.see(point).t);
    } else if (found.decision == Decision::crosses) {
      earliest = std::min(earliest, found.t - found.t_error);
      if (found.t > hit_t || (found.t == hit_t && !is_preferred(view, tet, hit_tet))) return;
      hit_t = found.t;
      hit_error = found.t_error;
      hit_tet = tet;
    }
  };
  walk_active_tets(
      view, query, ray, counters, [&](double t_in) { return !(hit_t + hit_error < t_in); }, look,
      [&](double t_out) { return !(hit_t + hit_error <= t_out); });
  CertifiedTetHit answer;
  const double t_rounding = 0x1p-50 * std::abs(doubtful_from);
  answer.is_certain = doubtful_from == infinity || hit_t + hit_error < doubtful_from - t_rounding;
  if (hit_t < infinity && answer.is_certain) {
    fill_in(answer.hit, view, query, hit_tet, hit_t);
    // Another crossing may come first by less than their errors.
    answer.hit.error = std::max(hit_error, hit_t - earliest);
  }
  return answer;
}

/// Decides rays that single precision could not decide.
template <class View>
Hit certified_first_crossing_redone(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  ++scratch.counters.rays_redone;
  const CertifiedTetHit answer = certified_crossing<double>(view, query, ray, scratch.counters);
  if (answer.is_certain) return answer.hit;
  return exact_first_hit(view, query, ray, scratch);
}

template <class View>
Hit certified_first_crossing(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const CertifiedTetHit answer = certified_crossing<float>(view, query, ray, scratch.counters);
  if (answer.is_certain) return answer.hit;
  return certified_first_crossing_redone(view, query, ray, scratch);
}

/// The largest value. The t at which the ray enters and leaves is exact to the rounding of one
/// mean. Exact arithmetic must decide which tetrahedra are hit by a ray that grazes an edge.
template <class View>
Hit certified_largest_value(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  return exact_largest_hit(view, query, ray, scratch);
}

}  // namespace

}  // namespace rhoray::render

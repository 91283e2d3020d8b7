#pragma once

#include <algorithm>

#include "render/kernels/largest_value_search.h"
#include "render/kernels/tet_walk.h"

namespace rhoray::render {

namespace {

/// On a tetrahedron the field is linear, so its largest value on a ray is where the ray enters or leaves: direct,
/// preview and paper are the same.
template <class Real, class View>
Hit largest_value_in(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  const Ray ray_lattice = view.on_lattice(ray);
  KernelCounters& counters = scratch.counters;
  const RayShearOf<Real> shear(ray);

  const auto offer_tet = [&](std::uint32_t tet, double bound, const auto& offer) {
    const auto vertices = view.sorted_vertices(tet);
    const TetValues values = view.values_at(vertices);
    if (!has_data(values)) return;
    ++counters.cells_solved;
    const TetPoints p = view.points_at(vertices);
    auto passage =
        pass_through(SeenTetOf<Real>{{shear.see(p[0]), shear.see(p[1]), shear.see(p[2]), shear.see(p[3])}, values}, 0);
    if (passage) passage = clip(*passage, ray.t_min, ray.t_max);
    if (!passage) return;
    // Rounding must not lift a value over its leaf's bound: the queue relies on it.
    offer(std::min(passage->in.value, bound), passage->in.t, view.cell_id(tet));
    offer(std::min(passage->out.value, bound), passage->out.t, view.cell_id(tet));
  };
  const auto bound = [&](int level, const Index3& cell) {
    ++(level > 0 ? counters.macrocells_visited : counters.cells_visited);
    return view.range(level, cell).hi;
  };
  const auto open_leaf = [&](const MaximumQueue::Entry& entry, const auto& offer) {
    const IntersectionTimer timer(question, counters);
    for (const std::uint32_t tet : view.tetrahedra_at(entry.cell)) offer_tet(tet, entry.bound, offer);
  };
  return largest_value_search(ray_lattice, PlaneTimes(ray_lattice), view.lattice(),
                              question.use_hierarchy ? view.level_count() : 0, -std::numeric_limits<double>::infinity(),
                              scratch, bound, open_leaf);
}

template <class View>
Hit largest_value_on_ray(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  return question.method.precision == Method::Precision::single
             ? largest_value_in<float>(view, question, ray, scratch)
             : largest_value_in<double>(view, question, ray, scratch);
}

}  // namespace

}  // namespace rhoray::render

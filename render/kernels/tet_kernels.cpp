#include <algorithm>
#include <cmath>

#include "render/kernels/intersection_timer.h"
#include "render/kernels/kernels.h"
#include "render/kernels/largest_value_search.h"

namespace rhoray::render {

namespace {

template <class View>
RHORAY_INLINE SeenTet see(const View& view, const RayShear& shear, const std::array<std::uint32_t, 4>& vertices,
                          const std::array<double, 4>& values) {
  const auto points = view.points_at(vertices);
  return {{shear.see(points[0]), shear.see(points[1]), shear.see(points[2]), shear.see(points[3])}, values};
}

template <class View, bool timed>
Hit first_crossing(const View& view, const Question& question, const Ray& ray, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = view.lattice();
  const Ray ray_lattice = view.on_lattice(ray);
  const PlaneTimes planes(ray_lattice);
  const std::optional<Segment> segment = clip_to_lattice(ray_lattice, planes, lattice.leaf_count);
  if (!segment) return hit;
  const double iso = question.isovalue;
  const RayShear shear(ray);

  std::uint32_t hit_tet = 0;
  const auto try_tet = [&](std::uint32_t tet) {
    const auto vertices = view.sorted_vertices(tet);
    const auto values = view.values_at(vertices);
    const auto [lo, hi] = std::minmax({values[0], values[1], values[2], values[3]});
    if (!(lo < iso && iso <= hi) || !has_data(values)) return;
    ++counters.cells_solved;
    auto passage = pass_through(see(view, shear, vertices, values), iso);
    if (passage) passage = clip(*passage, ray.t_min, ray.t_max);
    if (!passage) return;
    const std::optional<double> t = first_crossing(*passage);
    if (!t || *t > hit.t || (*t == hit.t && tet > hit_tet)) return;
    hit.t = *t;
    hit_tet = tet;
  };

  const auto can_cross = [&](const Interval<double>& range) { return range.lo < iso && iso <= range.hi; };
  auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    return can_cross(view.range(level, visit.cell));
  };
  // A tetrahedron reaches over several leaf cells: a crossing beyond this one waits until the ray gets there.
  auto leaf = [&](const CellVisit& visit) {
    if (visit.has_no_length()) return true;
    if (hit.t < visit.t_in) return false;
    ++counters.cells_visited;
    if (!can_cross(view.range(0, visit.cell))) return true;
    const IntersectionTimer<timed> timer(counters);
    for (const std::uint32_t tet : view.tetrahedra_at(visit.cell)) try_tet(tet);
    return !(hit.t <= visit.t_out);
  };

  const int top = question.use_hierarchy ? view.level_count() : 0;
  walk_hierarchy(ray_lattice, planes, lattice, top, whole_level(lattice, lattice.cell_edge(top)), segment->t_in,
                 segment->t_out, enters, leaf);
  if (hit.is_miss()) return hit;
  const auto vertices = view.sorted_vertices(hit_tet);
  hit.value = iso;
  hit.cell = view.cell_id(hit_tet);
  hit.gradient = tet_gradient(view.points_at(vertices), view.values_at(vertices));
  return hit;
}

/// On a tetrahedron the field is linear, so its largest value on a ray is where the ray enters or leaves: one method.
template <class View, bool timed>
Hit largest_value(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  const Ray ray_lattice = view.on_lattice(ray);
  KernelCounters& counters = scratch.counters;
  const RayShear shear(ray);

  const auto offer_tet = [&](std::uint32_t tet, double bound, const auto& offer) {
    const auto vertices = view.sorted_vertices(tet);
    const auto values = view.values_at(vertices);
    if (!has_data(values)) return;
    ++counters.cells_solved;
    auto passage = pass_through(see(view, shear, vertices, values), 0);
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
    const IntersectionTimer<timed> timer(counters);
    for (const std::uint32_t tet : view.tetrahedra_at(entry.cell)) offer_tet(tet, entry.bound, offer);
  };
  return largest_value_search(ray_lattice, PlaneTimes(ray_lattice), view.lattice(),
                              question.use_hierarchy ? view.level_count() : 0, -std::numeric_limits<double>::infinity(),
                              scratch, bound, open_leaf);
}

template <class View, bool timed>
void first_crossing_kernel(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                           std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r)
    hits[r] = first_crossing<View, timed>(view, question, rays[r], scratch.counters);
}

template <class View, bool timed>
void largest_value_kernel(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                          std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r) hits[r] = largest_value<View, timed>(view, question, rays[r], scratch);
}

template <class View, bool timed>
Kernels choose(const View& view) {
  return {.first_crossing = first_crossing_kernel<View, timed>,
          .largest_value = largest_value_kernel<View, timed>,
          .queue_entries = largest_queue_size(view.lattice(), view.level_count())};
}

}  // namespace

template <class View>
Kernels kernels_for(const View& view, MipMethod, bool timed) {
  return timed ? choose<View, true>(view) : choose<View, false>(view);
}

template Kernels kernels_for(const TetVolume<float>&, MipMethod, bool);
template Kernels kernels_for(const TetVolume<double>&, MipMethod, bool);

}  // namespace rhoray::render

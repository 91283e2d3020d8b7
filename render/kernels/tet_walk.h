#pragma once

#include <algorithm>
#include <cmath>

#include "render/cells/tet_methods.h"
#include "render/kernels/intersection_timer.h"
#include "render/kernels/kernels.h"
#include "render/march/lattice_walk.h"

/// What the kernels of tetrahedral meshes share: a ray's walk through the leaf cells, to the tetrahedra that their
/// lists name (paper, section 4.2).
namespace rhoray::render {

namespace {

/// A tetrahedron as the kernels look at it: its vertices in rising order, so that neighbours see the same.
struct LocalTet {
  TetPoints points;
  TetValues values;
};

/// Which of two tetrahedra crossed at the same t is the hit: the one of the smaller id; of those that were cut from one
/// cell of the source the one that stands first.
template <class View>
RHORAY_INLINE bool is_preferred(const View& view, std::uint32_t tet, std::uint32_t to) {
  const std::uint64_t id = view.cell_id(tet), other = view.cell_id(to);
  return id != other ? id < other : tet < to;
}

/// Calls look(tetrahedron, values of its sorted vertices) for those that may hold the isosurface and have data, leaf
/// after leaf along the ray; a tetrahedron comes up once for every leaf cell that lists it.
/// @param leaf_begins  (t_in of the leaf): false to stop
/// @param leaf_ends    (t_out of the leaf): false to stop
template <class View, class Begins, class Look, class Ends>
void walk_active_tets(const View& view, const Question& question, const Ray& ray, KernelCounters& counters,
                      Begins&& leaf_begins, Look&& look, Ends&& leaf_ends) {
  const WalkLattice lattice = view.lattice();
  const Ray ray_lattice = view.on_lattice(ray);
  const PlaneTimes planes(ray_lattice);
  const std::optional<Segment> segment = clip_to_lattice(ray_lattice, planes, lattice.leaf_count);
  if (!segment) return;
  const double iso = question.isovalue;
  const auto can_cross = [&](const Interval<double>& range) { return range.lo < iso && iso <= range.hi; };
  auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    return can_cross(view.range(level, visit.cell));
  };
  auto leaf = [&](const CellVisit& visit) {
    if (visit.has_no_length()) return true;
    if (!leaf_begins(visit.t_in)) return false;
    ++counters.cells_visited;
    if (!can_cross(view.range(0, visit.cell))) return true;
    const IntersectionTimer timer(question, counters);
    for (const std::uint32_t tet : view.tetrahedra_at(visit.cell)) {
      const auto vertices = view.sorted_vertices(tet);
      const TetValues values = view.values_at(vertices);
      const auto [lo, hi] = std::minmax({values[0], values[1], values[2], values[3]});
      if (!can_cross({lo, hi}) || !has_data(values)) continue;
      ++counters.cells_solved;
      look(tet, LocalTet{view.points_at(vertices), values});
    }
    return leaf_ends(visit.t_out);
  };
  const int top = question.use_hierarchy ? view.level_count() : 0;
  walk_hierarchy(ray_lattice, planes, lattice, top, whole_level(lattice, lattice.cell_edge(top)), segment->t_in,
                 segment->t_out, enters, leaf);
}

/// Completes a hit at t in a tetrahedron.
template <class View>
void fill_in(Hit& hit, const View& view, const Question& question, std::uint32_t tet, double t) {
  const auto vertices = view.sorted_vertices(tet);
  hit.t = t;
  hit.value = question.isovalue;
  hit.cell = view.cell_id(tet);
  hit.gradient = tet_gradient(view.points_at(vertices), view.values_at(vertices));
  hit.root_count = 1;
}

}  // namespace

}  // namespace rhoray::render

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "render/cell/tet_methods.h"
#include "render/query/intersection_timer.h"
#include "render/query/kernels.h"
#include "render/tets/reference/cluster_walk.h"
#include "render/tets/reference/mailbox.h"
#include "render/traverse/lattice_walk.h"

/// Shared by the kernels of tetrahedral meshes: traversal of the leaf cells along a ray, to the
/// tetrahedra that their lists name (paper, section 4.2), or of clusters, to their tetrahedra.
namespace rhoray::render {

namespace {

/// A tetrahedron with its vertices in increasing order, so that neighbours compute with the same
/// numbers.
struct LocalTet {
  TetPoints points;
  TetValues values;
};

/// Decides which of two tetrahedra crossed at the same t is the hit: the one with the smaller id.
/// For two that were cut from one cell of the source, it is the one with the smaller index.
template <class View>
RHORAY_INLINE bool is_preferred(const View& view, std::uint32_t tet, std::uint32_t to) {
  const std::uint64_t id = view.cell_id(tet), other = view.cell_id(to);
  return id != other ? id < other : tet < to;
}

/// Calls look(tetrahedron, values of its sorted vertices) if it may contain the isosurface, has
/// data, and is_new(it).
template <class View, class Look, class IsNew>
RHORAY_INLINE void look_into(const View& view, const RayQuery& query, std::uint32_t tet, KernelCounters& counters,
                             Look&& look, IsNew&& is_new) {
  const TetValues unsorted = view.values_at(view.vertices(tet));
  const double lo = std::min(std::min(unsorted[0], unsorted[1]), std::min(unsorted[2], unsorted[3]));
  const double hi = std::max(std::max(unsorted[0], unsorted[1]), std::max(unsorted[2], unsorted[3]));
  if (!(lo < query.isovalue && query.isovalue <= hi) || !has_data(unsorted) || !is_new(tet)) return;
  ++counters.cells_solved;
  const auto vertices = view.sorted_vertices(tet);
  look(tet, LocalTet{view.points_at(vertices), view.values_at(vertices)});
}

/// The same for tetrahedra that come up only once.
template <class View, class Look>
RHORAY_INLINE void look_into(const View& view, const RayQuery& query, std::uint32_t tet, KernelCounters& counters,
                             Look&& look) {
  look_into(view, query, tet, counters, look, [](std::uint32_t) { return true; });
}

/// Visits the leaf cells along the ray, front to back, in macrocells whose range satisfies
/// may_hold.
/// @param leaf  (visit): returns true to go on
template <class View, class MayHold, class Leaf>
void walk_leaves(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters, MayHold&& may_hold,
                 Leaf&& leaf) {
  const WalkLattice lattice = view.lattice();
  const Ray ray_lattice = view.on_lattice(ray);
  const PlaneTimes planes(ray_lattice);
  const std::optional<Segment> segment = clip_to_lattice(ray_lattice, planes, lattice.leaf_count);
  if (!segment) return;
  auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    return may_hold(view.range(level, visit.cell));
  };
  const int top = query.use_hierarchy ? view.level_count() : 0;
  walk_hierarchy(ray_lattice, planes, lattice, top, whole_level(lattice, lattice.cell_edge(top)), segment->t_in,
                 segment->t_out, enters, leaf);
}

/// Visits the lists of the leaf cells along the ray that may contain the isosurface, front to back.
/// @param leaf_begins  (t_in of the leaf): false to stop
/// @param list         (the tetrahedra that a leaf cell lists)
/// @param leaf_ends    (t_out of the leaf): false to stop
template <class View, class Begins, class List, class Ends>
void walk_active_leaves(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                        Begins&& leaf_begins, List&& list, Ends&& leaf_ends) {
  const double iso = query.isovalue;
  const auto can_cross = [&](const Interval<double>& range) { return range.lo < iso && iso <= range.hi; };
  walk_leaves(view, query, ray, counters, can_cross, [&](const CellVisit& visit) {
    if (visit.has_no_length()) return true;
    if (!leaf_begins(visit.t_in)) return false;
    ++counters.cells_visited;
    if (!can_cross(view.range(0, visit.cell))) return true;
    const IntersectionTimer timer(query, counters);
    list(view.tetrahedra_at(visit.cell));
    return leaf_ends(visit.t_out);
  });
}

/// Visits the tetrahedra along the ray, leaf after leaf, each once although several leaf cells list
/// it.
template <class View, class Begins, class Look, class Ends>
void walk_active_lists(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                       Begins&& leaf_begins, Look&& look, Ends&& leaf_ends) {
  Mailbox met;
  const auto is_new = [&](std::uint32_t tet) { return met.add(tet); };
  walk_active_leaves(
      view, query, ray, counters, leaf_begins,
      [&](std::span<const std::uint32_t> list) {
        for (const std::uint32_t tet : list) look_into(view, query, tet, counters, look, is_new);
      },
      leaf_ends);
}

/// Visits the tetrahedra of the clusters along the ray, each once. Clusters overlap: a hit in one
/// of them may be behind one in another. Therefore only clusters that begin behind the hit are
/// skipped.
template <class View, class Begins, class Look>
void walk_active_clusters(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                          Begins&& cluster_begins, Look&& look) {
  const double iso = query.isovalue;
  const formats::CellClustersView& clusters = view.clusters();
  walk_clusters(
      view, BoxRay(ray, clusters.box_unit), query.use_hierarchy, counters,
      [&](const Interval<double>& range) { return range.lo < iso && iso <= range.hi; }, cluster_begins,
      [&](const ClusterVisit& visit) {
        const IntersectionTimer timer(query, counters);
        for (std::uint64_t tet = clusters.first_cell(visit.entry); tet < clusters.end_cell(visit.entry); ++tet)
          look_into(view, query, static_cast<std::uint32_t>(tet), counters, look);
        return true;
      });
}

/// Calls look(tetrahedron, values of its sorted vertices) for those along the ray that may contain
/// the isosurface and have data. The order is front to back, except for the overlap of leaf cells
/// and clusters.
/// @param matters_from  (t): false when nothing behind t matters
/// @param ends_at       (t): false when nothing matters at t or behind it
template <class View, class MattersFrom, class Look, class EndsAt>
void walk_active_tets(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                      MattersFrom&& matters_from, Look&& look, EndsAt&& ends_at) {
  if (view.has_clusters())
    walk_active_clusters(view, query, ray, counters, matters_from, look);
  else
    walk_active_lists(view, query, ray, counters, matters_from, look, ends_at);
}

/// Completes a hit at t in a tetrahedron.
template <class View>
void fill_in(Hit& hit, const View& view, const RayQuery& query, std::uint32_t tet, double t) {
  const auto vertices = view.sorted_vertices(tet);
  hit.t = t;
  hit.value = query.isovalue;
  hit.cell = view.cell_id(tet);
  hit.tet = tet;
  hit.gradient = tet_gradient(view.points_at(vertices), view.values_at(vertices));
  hit.root_count = 1;
}

}  // namespace

}  // namespace rhoray::render

#pragma once

#include <algorithm>

#include "render/query/largest_so_far.h"
#include "render/query/largest_value_search.h"
#include "render/tets/reference/walk.h"

/// The largest value along a ray through a mesh. The field is linear in a tetrahedron, so its
/// largest value on a ray is where the ray enters or leaves. Direct, preview and paper are
/// therefore the same, in double whatever the precision requested.
///
/// Regions are leaf cells and macrocells, or clusters and the entries above them. They are opened
/// in the order of their largest values, and front to back for equal values. The search ends when
/// no remaining region could improve the result. That would be a larger value, the same value at a
/// smaller t, or both the same in a cell with a smaller id. The result therefore does not depend on
/// the choice of regions.
namespace rhoray::render {

namespace {

/// True when nothing in the region can replace the result so far.
inline bool beats(const LargestSoFar& largest, const MaximumQueue::Entry& region) {
  return region.bound < largest.value || (region.bound == largest.value && region.t_in > largest.t);
}

/// Offers the values at which the ray enters and leaves tetrahedra.
template <class View>
class ValuesAlong {
 public:
  ValuesAlong(const View& view, const Ray& ray, KernelCounters& counters, LargestSoFar& largest)
      : view_(view), ray_(ray), shear_(ray), counters_(counters), largest_(largest) {}

  RHORAY_INLINE void look_into(std::uint32_t tet) const {
    const auto vertices = view_.sorted_vertices(tet);
    const TetValues values = view_.values_at(vertices);
    if (!has_data(values)) return;
    ++counters_.cells_solved;
    const std::optional<SeenTet> seen = see_near(shear_, view_.points_at(vertices), values);
    if (!seen) return;
    auto passage = pass_through(*seen, 0);
    if (passage) passage = clip(*passage, ray_.t_min, ray_.t_max);
    if (!passage) return;
    // Rounding must not raise a value above those of the cell, because the bounds of regions are
    // computed from them.
    const double most = std::max({values[0], values[1], values[2], values[3]});
    largest_.offer(std::min(passage->in.value, most), passage->in.t, view_.cell_id(tet));
    largest_.offer(std::min(passage->out.value, most), passage->out.t, view_.cell_id(tet));
  }

 private:
  const View& view_;
  const Ray& ray_;
  RayShear shear_;
  KernelCounters& counters_;
  LargestSoFar& largest_;
};

/// Opens regions until the largest value beats all that are left. `open(region)` searches one, or
/// puts its children into the queue.
template <class Open>
void open_regions(MaximumQueue& queue, const LargestSoFar& largest, Open&& open) {
  while (!queue.is_empty()) {
    const MaximumQueue::Entry region = queue.pop();
    if (beats(largest, region)) return;
    open(region);
  }
}

template <class View, class Look>
void search_lists(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch,
                  const LargestSoFar& largest, const Look& look_into) {
  const WalkLattice lattice = view.lattice();
  const Ray ray_lattice = view.on_lattice(ray);
  const PlaneTimes planes(ray_lattice);
  const std::optional<Segment> segment = clip_to_lattice(ray_lattice, planes, lattice.leaf_count);
  if (!segment) return;
  KernelCounters& counters = scratch.counters;
  const auto put_level = [&](int level, const CellBlock& block, double t_in, double t_out) {
    walk_level(ray_lattice, planes, lattice, lattice.cell_edge(level), block, t_in, t_out, [&](const CellVisit& visit) {
      if (visit.has_no_length()) return true;
      ++(level > 0 ? counters.macrocells_visited : counters.cells_visited);
      const Interval<double> range = view.range(level, visit.cell);
      const MaximumQueue::Entry region{
          .bound = range.hi, .t_in = visit.t_in, .t_out = visit.t_out, .cell = visit.cell, .level = level};
      if (!range.is_empty() && !beats(largest, region)) scratch.queue.push(region);
      return true;
    });
  };
  const int top = query.use_hierarchy ? view.level_count() : 0;
  put_level(top, whole_level(lattice, lattice.cell_edge(top)), segment->t_in, segment->t_out);
  open_regions(scratch.queue, largest, [&](const MaximumQueue::Entry& region) {
    if (region.level > 0) {
      const int below = region.level - 1;
      return put_level(below, children(lattice, region.cell, lattice.cell_edge(below)), region.t_in, region.t_out);
    }
    const IntersectionTimer timer(query, counters);
    for (const std::uint32_t tet : view.tetrahedra_at(region.cell)) look_into(tet);
  });
}

template <class View, class Look>
void search_clusters(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch,
                     const LargestSoFar& largest, const Look& look_into) {
  const formats::CellClustersView& clusters = view.clusters();
  const BoxRay box_ray(ray, clusters.box_unit);
  KernelCounters& counters = scratch.counters;
  const auto put_block = [&](int level, std::uint64_t block) {
    ++counters.macrocells_visited;
    const auto has_values = [](const Interval<double>& range) { return !range.is_empty(); };
    meet_block(view, box_ray, level, block, has_values, [&](const ClusterVisit& visit) {
      const double largest_in_entry = view.with_cluster_ranges(level, block, [&](const auto& ranges) {
        return static_cast<double>(ranges.hi[visit.entry % BoxRay::width]);
      });
      const MaximumQueue::Entry region{.bound = largest_in_entry,
                                       .t_in = visit.part.t_in,
                                       .t_out = visit.part.t_out,
                                       .cell = {0, 0, 0},
                                       .level = level,
                                       .id = visit.entry};
      if (!beats(largest, region)) scratch.queue.push(region);
    });
  };
  const int top = first_level(view, query.use_hierarchy);
  for (std::uint64_t block = 0; block < clusters.shape.block_count(top); ++block) put_block(top, block);
  open_regions(scratch.queue, largest, [&](const MaximumQueue::Entry& region) {
    if (region.level > 0) return put_block(region.level - 1, region.id);
    ++counters.cells_visited;
    const IntersectionTimer timer(query, counters);
    for (std::uint64_t tet = clusters.first_cell(region.id); tet < clusters.end_cell(region.id); ++tet)
      look_into(static_cast<std::uint32_t>(tet));
  });
}

template <class View>
Hit largest_value_on_ray(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  LargestSoFar largest;
  const ValuesAlong<View> values(view, ray, scratch.counters, largest);
  const auto look_into = [&](std::uint32_t tet) { values.look_into(tet); };
  scratch.queue.clear();
  if (view.has_clusters())
    search_clusters(view, query, ray, scratch, largest, look_into);
  else
    search_lists(view, query, ray, scratch, largest, look_into);
  return largest.hit();
}

/// Returns the queue capacity that one ray needs. With clusters it suffices for most rays; the
/// queue then keeps the size it grows to.
template <class View>
std::size_t queue_size_for(const View& view) {
  return view.has_clusters() ? 1024 : largest_queue_size(view.lattice(), view.level_count());
}

}  // namespace

}  // namespace rhoray::render

#pragma once

#include <cmath>

#include "render/query/kernels.h"
#include "render/traverse/lattice_walk.h"

namespace rhoray::render {

/// The search for the largest value along one ray (paper, section 4.3), the same for grids and
/// meshes. It takes the region with the largest bound from the queue, opens it and inserts its
/// parts, until a found value comes first.
///
/// `bound(level, cell)` is an upper bound of the values in a region; it is -infinity for an empty
/// region. `open_leaf(entry, offer)` calls offer(value, t, cell id) for values that the ray
/// reaches. None of them exceeds entry.bound, and the largest in that leaf cell is among them.
/// Cells that the ray only touches, over a length of zero, are left out.
///
/// Of equal values the nearest is the answer. At equal t the answer is the value of the cell that
/// the ray enters first: if a cell entered earlier can hold the same value, it is opened before a
/// later cell's value becomes the answer.
/// @param lower_bound  regions and values below it are dropped: the answer is the same as without,
///                     or a miss
template <class Planes, class Bound, class OpenLeaf>
Hit largest_value_search(const Ray& ray_lattice, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice,
                         int top_level, double lower_bound, KernelScratch& scratch, Bound&& bound,
                         OpenLeaf&& open_leaf) {
  constexpr double nothing = -std::numeric_limits<double>::infinity();
  const std::optional<Segment> segment = clip_to_lattice(ray_lattice, planes, lattice.leaf_count);
  if (!segment) return {};

  MaximumQueue& queue = scratch.queue;
  queue.clear();
  const auto put_level = [&](int level, const CellBlock& block, double t_in, double t_out) {
    walk_level(ray_lattice, planes, lattice, lattice.cell_edge(level), block, t_in, t_out, [&](const CellVisit& visit) {
      if (visit.has_no_length()) return true;
      const double largest = bound(level, visit.cell);
      if (largest > nothing && largest >= lower_bound)
        queue.push({.bound = largest,
                    .t_in = visit.t_in,
                    .t_out = visit.t_out,
                    .cell = visit.cell,
                    .level = level,
                    .axis_in = visit.axis_in,
                    .axis_out = visit.axis_out});
      return true;
    });
  };

  put_level(top_level, whole_level(lattice, lattice.cell_edge(top_level)), segment->t_in, segment->t_out);
  while (!queue.is_empty()) {
    const MaximumQueue::Entry entry = queue.pop();
    if (entry.level == MaximumQueue::found) {
      Hit hit;
      hit.t = entry.t_in;
      hit.value = entry.bound;
      hit.cell = entry.id;
      return hit;
    }
    if (entry.level > 0) {
      const int child_level = entry.level - 1;
      put_level(child_level, children(lattice, entry.cell, lattice.cell_edge(child_level)), entry.t_in, entry.t_out);
      continue;
    }
    // Only the leaf's largest value can be the answer, and of equal ones the nearest.
    MaximumQueue::Entry best;
    best.bound = nothing;
    open_leaf(entry, [&](double value, double t, std::uint64_t id) {
      if (value > best.bound || (value == best.bound && t < best.t_in)) {
        best.bound = value;
        best.t_in = t;
        best.id = id;
      }
    });
    if (best.bound > nothing && best.bound >= lower_bound) {
      best.level = MaximumQueue::found;
      best.t_out = entry.t_in;
      queue.push(best);
    }
  }
  return {};
}

/// The most entries that one ray can have in the queue. A ray visits fewer than x + y + z cells of
/// a level and inserts each once; a found value replaces its leaf cell.
inline std::size_t largest_queue_size(const WalkLattice& lattice, int top_level) {
  std::size_t entries = 0;
  for (int level = 0; level <= top_level; ++level) {
    const Index3 count = whole_level(lattice, lattice.cell_edge(level)).end;
    entries += static_cast<std::size_t>(count.x + count.y + count.z);
  }
  return entries;
}

}  // namespace rhoray::render

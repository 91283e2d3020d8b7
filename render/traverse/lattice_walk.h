#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/traverse/ray.h"
#include "render/traverse/ray_box.h"

namespace rhoray::render {

/// The lattice that a ray walks through: leaf cells, and macrocells of factor^level leaf cells per
/// axis.
struct WalkLattice {
  Index3 leaf_count;
  std::int64_t factor = 2;

  RHORAY_INLINE std::int64_t cell_edge(int level) const {
    std::int64_t edge = 1;
    for (int l = 0; l < level; ++l) edge *= factor;
    return edge;
  }
};

/// Which cells of one level to walk: first <= cell < end on every axis.
struct CellBlock {
  Index3 first;
  Index3 end;
};

/// All cells of a level.
RHORAY_INLINE CellBlock whole_level(const WalkLattice& lattice, std::int64_t edge) {
  CellBlock block{{0, 0, 0}, {}};
  for (int axis = 0; axis < 3; ++axis) block.end[axis] = (lattice.leaf_count[axis] + edge - 1) / edge;
  return block;
}

/// The cells one level below that a macrocell consists of.
RHORAY_INLINE CellBlock children(const WalkLattice& lattice, const Index3& cell, std::int64_t child_edge) {
  CellBlock block;
  for (int axis = 0; axis < 3; ++axis) {
    block.first[axis] = cell[axis] * lattice.factor;
    block.end[axis] =
        std::min(block.first[axis] + lattice.factor, (lattice.leaf_count[axis] + child_edge - 1) / child_edge);
  }
  return block;
}

/// One cell of one level on the path of a ray.
struct CellVisit {
  Index3 cell;  ///< position in its level
  double t_in = 0;
  double t_out = 0;  ///< not before t_in; equal where the ray touches an edge or a corner
  /// Axis of the last plane passed at t_in, or -1: the ray starts between planes.
  int axis_in = -1;
  /// Axis of the first plane passed at t_out, or -1: the ray ends between planes.
  int axis_out = -1;

  RHORAY_INLINE bool has_no_length() const { return !(t_in < t_out); }

  /// The t at a share s of the path through the cell; exactly t_in and t_out at 0 and 1.
  RHORAY_INLINE double t_at(double s) const { return std::clamp((1 - s) * t_in + s * t_out, t_in, t_out); }
};

/// Walks one level's cells front to back (Amanatides and Woo, Eurographics '87), from the cell
/// where the ray is at t_in until it leaves the block or passes t_out. Calls visit(const
/// CellVisit&) for each cell; visit returns true to go on.
///
/// Planes with equal times are passed in the order x, y, z, through cells of length zero, so that
/// consecutive cells always share a face. At the first cell all planes of time <= t_in count as
/// passed.
/// @param edge  leaf cells per axis of a cell of this level
/// @return      false when visit ended the walk
template <class Planes, class Visit>
RHORAY_INLINE bool walk_level(const Ray& ray, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice,
                              std::int64_t edge, const CellBlock& block, double t_in, double t_out, Visit&& visit) {
  constexpr double never = std::numeric_limits<double>::infinity();
  // Time at which the ray passes a side of the cell at position c; the upper side is cut off where
  // the lattice ends.
  const auto side_time = [&](int axis, std::int64_t c, bool upper) {
    if (planes.step(axis) == 0) return upper ? never : -never;
    return planes.at(axis, upper ? std::min((c + 1) * edge, lattice.leaf_count[axis]) : c * edge);
  };
  const auto entry_time = [&](int axis, std::int64_t c) { return side_time(axis, c, planes.step(axis) < 0); };
  const auto exit_time = [&](int axis, std::int64_t c) { return side_time(axis, c, planes.step(axis) >= 0); };

  CellVisit at{.cell = {}, .t_in = t_in, .t_out = t_in, .axis_in = -1, .axis_out = -1};
  double exits[3];
  for (int axis = 0; axis < 3; ++axis) {
    // A guess from the position, then corrected so that it agrees with the plane times.
    const double at_planes =
        planes.planes().in_planes(axis, ray.origin[axis] + t_in * ray.direction[axis], block.first[axis] * edge,
                                  std::min(block.end[axis] * edge, lattice.leaf_count[axis]));
    const double guess = std::floor(at_planes / static_cast<double>(edge));
    const double first = static_cast<double>(block.first[axis]), last = static_cast<double>(block.end[axis] - 1);
    std::int64_t c = static_cast<std::int64_t>(std::clamp(guess, first, last));
    if (const int step = planes.step(axis); step != 0) {
      const std::int64_t nearest = step > 0 ? block.first[axis] : block.end[axis] - 1;
      const std::int64_t furthest = step > 0 ? block.end[axis] - 1 : block.first[axis];
      while (c != nearest && entry_time(axis, c) > t_in) c -= step;
      while (c != furthest && exit_time(axis, c) <= t_in) c += step;
    }
    at.cell[axis] = c;
    if (entry_time(axis, c) == t_in) at.axis_in = axis;
    exits[axis] = exit_time(axis, c);
  }

  for (;;) {
    const int axis = exits[0] <= exits[1] ? (exits[0] <= exits[2] ? 0 : 2) : (exits[1] <= exits[2] ? 1 : 2);
    const bool ends = !(exits[axis] <= t_out);
    at.t_out = std::max(at.t_in, ends ? t_out : exits[axis]);
    at.axis_out = ends ? -1 : axis;
    if (!visit(static_cast<const CellVisit&>(at))) return false;
    if (ends) return true;
    at.cell[axis] += planes.step(axis);
    if (at.cell[axis] < block.first[axis] || at.cell[axis] >= block.end[axis]) return true;
    exits[axis] = exit_time(axis, at.cell[axis]);
    at.t_in = at.t_out;
    at.axis_in = axis;
  }
}

/// Walks the hierarchy front to back from level `level` down to the leaf cells (paper, section 3).
/// `enters(level, visit)` returns whether a macrocell is opened. `leaf(visit)` is called for each
/// leaf cell of the opened macrocells and returns true to go on. Its visits are, bit for bit, those
/// of the plain walk in the opened macrocells, except that some cells of length zero may be left
/// out.
template <class Planes, class Enters, class Leaf>
bool walk_hierarchy(const Ray& ray, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice, int level,
                    const CellBlock& block, double t_in, double t_out, Enters& enters, Leaf& leaf) {
  const std::int64_t edge = lattice.cell_edge(level);
  return walk_level(ray, planes, lattice, edge, block, t_in, t_out, [&](const CellVisit& visit) {
    if (level == 0) return leaf(visit);
    if (!enters(level, visit)) return true;
    return walk_hierarchy(ray, planes, lattice, level - 1, children(lattice, visit.cell, edge / lattice.factor),
                          visit.t_in, visit.t_out, enters, leaf);
  });
}

}  // namespace rhoray::render

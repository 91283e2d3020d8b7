#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "formats/base/interval.h"
#include "formats/cell_clusters.h"
#include "render/query/kernels.h"
#include "render/traverse/ray.h"

/// Traversal of a tree of clusters along a ray.
namespace rhoray::render {

namespace {

/// The part of a ray that may be in a box, t_in <= t_out.
struct BoxPart {
  double t_in, t_out;
};

/// A ray prepared for intersection with boxes, eight at a time.
///
/// It misses no box that the ray touches, and no part of the ray inside it, between t_min and
/// t_max, with these taken as exact numbers. The error of a plane's time is at most three
/// roundings, 2^-53 of itself each; parts are extended by 2^-50 of it. This holds for directions
/// whose components, divided by the boxes' unit, have a finite inverse; other components count as
/// zero. A ray with a number that is not finite hits nothing.
class BoxRay {
 public:
  static constexpr std::size_t width = formats::ClusterShape::width;

  /// @param box_unit  of the boxes, a power of two
  BoxRay(const Ray& ray, double box_unit) : t_min_(ray.t_min), t_max_(ray.t_max) {
    bool moves = false, is_finite = true;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      origin_[a] = ray.origin[axis] / box_unit;  // exact
      inverse_[a] = 1 / (ray.direction[axis] / box_unit);
      is_finite = is_finite && std::isfinite(origin_[a]) && std::isfinite(ray.direction[axis]);
      if (!std::isfinite(inverse_[a])) inverse_[a] = 0;  // does not move along this axis
      moves = moves || inverse_[a] != 0;
    }
    if (!moves || !is_finite || !(t_min_ <= t_max_)) t_max_ = -std::numeric_limits<double>::infinity();
  }

  struct Parts {
    std::array<double, width> t_in, t_out;
    bool is_met(std::size_t entry) const { return t_in[entry] <= t_out[entry]; }  // false for NaN
  };

  RHORAY_INLINE Parts meet(const formats::BoxBlock& block) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Parts parts;
    parts.t_in.fill(-infinity);
    parts.t_out.fill(infinity);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double origin = origin_[axis], inverse = inverse_[axis];
      if (inverse == 0) {
        for (std::size_t e = 0; e < width; ++e)
          if (!(block.lo[axis][e] <= origin && origin <= block.hi[axis][e])) parts.t_in[e] = infinity;
        continue;
      }
      const auto& near = inverse > 0 ? block.lo[axis] : block.hi[axis];
      const auto& far = inverse > 0 ? block.hi[axis] : block.lo[axis];
      for (std::size_t e = 0; e < width; ++e) {
        parts.t_in[e] = std::max(parts.t_in[e], (static_cast<double>(near[e]) - origin) * inverse);
        parts.t_out[e] = std::min(parts.t_out[e], (static_cast<double>(far[e]) - origin) * inverse);
      }
    }
    // A NaN (infinity minus infinity) comes first: it stays, and marks the box as missed.
    constexpr double rounding = 0x1p-50, least = 1e-300;
    for (std::size_t e = 0; e < width; ++e) {
      parts.t_in[e] = std::max(parts.t_in[e] - (std::abs(parts.t_in[e]) * rounding + least), t_min_);
      parts.t_out[e] = std::min(parts.t_out[e] + (std::abs(parts.t_out[e]) * rounding + least), t_max_);
    }
    return parts;
  }

 private:
  std::array<double, 3> origin_, inverse_;
  double t_min_, t_max_;
};

/// An entry of the tree that a ray hits; at level 0 a cluster.
struct ClusterVisit {
  std::uint64_t entry;
  int level;
  BoxPart part;
};

/// Calls meets(visit) for the entries of a block that the ray hits and whose range passes may_hold.
template <class View, class MayHold, class Meets>
RHORAY_INLINE void meet_block(const View& view, const BoxRay& ray, int level, std::uint64_t block, MayHold&& may_hold,
                              Meets&& meets) {
  const unsigned wanted = view.with_cluster_ranges(level, block, [&](const auto& ranges) {
    unsigned entries = 0;
    for (std::size_t e = 0; e < BoxRay::width; ++e)
      entries |= static_cast<unsigned>(
                     may_hold(Interval<double>{static_cast<double>(ranges.lo[e]), static_cast<double>(ranges.hi[e])}))
                 << e;
    return entries;
  });
  if (wanted == 0) return;
  const BoxRay::Parts parts = ray.meet(view.clusters().boxes[static_cast<std::size_t>(level)][block]);
  for (std::size_t e = 0; e < BoxRay::width; ++e)
    if ((wanted >> e & 1) != 0 && parts.is_met(e))
      meets(ClusterVisit{block * BoxRay::width + e, level, {parts.t_in[e], parts.t_out[e]}});
}

/// Returns the level whose blocks a traversal begins with.
template <class View>
int first_level(const View& view, bool use_hierarchy) {
  return use_hierarchy ? view.clusters().shape.top_level() : 0;
}

/// Traverses the tree, in each block in the order in which the ray enters the entries. Calls
/// cluster(visit) for the clusters that the ray hits and whose range passes may_hold; returns when
/// that is false.
/// @param matters_from  (t_in of an entry): false to skip it
template <class View, class MayHold, class MattersFrom, class Cluster>
void walk_clusters(const View& view, const BoxRay& ray, bool use_hierarchy, KernelCounters& counters,
                   MayHold&& may_hold, MattersFrom&& matters_from, Cluster&& cluster) {
  constexpr std::size_t most_levels = 11;  // 2^32 clusters of one cell
  std::array<ClusterVisit, most_levels * BoxRay::width> waiting;
  std::size_t count = 0;
  const auto open = [&](int level, std::uint64_t block) {
    const std::size_t before = count;
    meet_block(view, ray, level, block, may_hold, [&](const ClusterVisit& visit) {
      // Entries that begin later are deeper in the stack: move those up that begin before this one.
      std::size_t at = count++;
      for (; at > before && waiting[at - 1].part.t_in < visit.part.t_in; --at) waiting[at] = waiting[at - 1];
      waiting[at] = visit;
    });
  };
  const int top = first_level(view, use_hierarchy);
  for (std::uint64_t block = 0; block < view.clusters().shape.block_count(top); ++block) {
    ++counters.macrocells_visited;
    open(top, block);
    while (count > 0) {
      const ClusterVisit visit = waiting[--count];
      if (!matters_from(visit.part.t_in)) continue;
      if (visit.level > 0) {
        ++counters.macrocells_visited;
        open(visit.level - 1, visit.entry);
      } else {
        ++counters.cells_visited;
        if (!cluster(visit)) return;
      }
    }
  }
}

}  // namespace

}  // namespace rhoray::render

#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "render/mesh_search.h"
#include "tools/lab/structures/plain_mesh.h"

namespace rhoray::study {

/// An adaptive grid: boxes are halved along each axis where many cells touch them. Leaves have
/// lists, and nodes have the ranges of eight children side by side.
class Octree {
 public:
  /// Divides a box that contains the centres of more cells than this. The number of cells that
  /// touch it would be no measure: around a point of the mesh two dozen cells touch it, however
  /// small it is.
  Octree(const PlainMesh& mesh, std::size_t most_middles);

  std::uint64_t bytes() const;  ///< without the mesh's
  std::uint64_t item_count() const { return items_.size(); }

  /// Like TwoLevelGrid::walk.
  template <class Begins, class List, class Ends>
  void walk(const render::RayQuery& query, const render::Ray& ray, render::KernelCounters& counters, Begins&& begins,
            List&& list, Ends&& ends) const;

 private:
  static constexpr std::uint32_t leaf_bit = 0x80000000;
  static constexpr int most_levels = 20;

  /// Child 0 is low on all axes; bits 0, 1 and 2 of a child's number are for x, y and z.
  struct Node {
    std::array<std::uint32_t, 8> child{};  ///< index of a node, or leaf_bit and index of a leaf
    std::array<float, 8> lo, hi;           ///< of values
  };
  /// A node's cube in the frame in which the root is the unit cube.
  struct Cube {
    Vec3 low{0, 0, 0};
    double edge = 1;

    Cube child(unsigned number) const {
      const double half = 0.5 * edge;
      return {low + Vec3((number & 1) != 0 ? half : 0, (number & 2) != 0 ? half : 0, (number & 4) != 0 ? half : 0),
              half};
    }
  };
  /// Cells that touch a node, on the way to their leaves.
  struct Touching {
    std::vector<std::uint32_t> cells;
    std::size_t middle_count = 0;  ///< number of cells with their centre in the node
  };
  struct Built {
    std::uint32_t node;
    Interval<float> range;
  };
  Built build_node(const PlainMesh& mesh, const Cube& cube, const std::array<Touching, 8>& parts, int level);
  Built build_leaf(const PlainMesh& mesh, const std::vector<std::uint32_t>& cells);
  std::array<Touching, 8> divided(const PlainMesh& mesh, const Cube& cube,
                                  const std::vector<std::uint32_t>& cells) const;

  Vec3 low_, size_;
  std::size_t most_middles_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> starts_;  ///< leaves + 1
  std::vector<std::uint32_t> items_;
};

template <class Begins, class List, class Ends>
void Octree::walk(const render::RayQuery& query, const render::Ray& ray, render::KernelCounters& counters,
                  Begins&& begins, List&& list, Ends&& ends) const {
  using namespace render;
  const double iso = query.isovalue;
  Ray unit = ray;
  unit.origin = (ray.origin - low_) / size_;
  unit.direction = ray.direction / size_;
  const PlaneTimes planes(unit);
  const std::optional<Segment> segment = clip_to_lattice(unit, planes, {1, 1, 1});
  if (!segment) return;
  const Vec3 inverse{1 / unit.direction.x, 1 / unit.direction.y, 1 / unit.direction.z};
  struct Waiting {
    std::uint32_t node;
    Cube cube;
    double t_in, t_out;
  };
  // A ray meets at most four children of a node.
  std::array<Waiting, 4 * (most_levels + 1)> waiting;
  std::size_t count = 0;
  waiting[count++] = {0, {}, segment->t_in, segment->t_out};
  while (count > 0) {
    const Waiting at = waiting[--count];
    if (!begins(at.t_in)) return;
    if ((at.node & leaf_bit) != 0) {
      ++counters.cells_visited;
      const std::uint32_t leaf = at.node ^ leaf_bit;
      list(std::span(items_).subspan(starts_[leaf], starts_[leaf + 1] - starts_[leaf]));
      if (!ends(at.t_out)) return;
      continue;
    }
    ++counters.macrocells_visited;
    const Node& node = nodes_[at.node];
    const double half = 0.5 * at.cube.edge;
    constexpr double never = std::numeric_limits<double>::infinity();
    std::array<double, 3> passes;  // t of the plane between two halves, if still ahead
    unsigned child = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double middle = at.cube.low[axis] + half;
      const int step = planes.step(axis);
      const double t = step == 0 ? never : (middle - unit.origin[axis]) * inverse[axis];
      const bool is_passed = step != 0 && t <= at.t_in;
      const bool is_high = step == 0 ? unit.origin[axis] >= middle : (step > 0) == is_passed;
      child |= static_cast<unsigned>(is_high) << axis;
      passes[static_cast<std::size_t>(axis)] = is_passed ? never : t;
    }
    std::array<Waiting, 4> met;
    std::size_t met_count = 0;
    for (double t = at.t_in;;) {
      const std::size_t axis =
          passes[0] <= passes[1] ? (passes[0] <= passes[2] ? 0 : 2) : (passes[1] <= passes[2] ? 1 : 2);
      const bool is_last = !(passes[axis] < at.t_out);
      const double t_out = is_last ? at.t_out : passes[axis];
      if (t < t_out && node.lo[child] < iso && iso <= node.hi[child]) {
        met[met_count++] = {node.child[child], at.cube.child(child), t, t_out};
      }
      if (is_last) break;
      child ^= 1U << axis;
      passes[axis] = never;
      t = t_out;
    }
    while (met_count > 0) waiting[count++] = met[--met_count];
  }
}

}  // namespace rhoray::study

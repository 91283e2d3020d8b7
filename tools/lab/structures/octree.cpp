#include "tools/lab/structures/octree.h"

#include <algorithm>
#include <numeric>

#include "tools/lab/structures/cell_sides.h"

namespace rhoray::study {
namespace {

constexpr Interval<float> no_value{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};

Interval<float> together(const Interval<float>& a, const Interval<float>& b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

}  // namespace

Octree::Octree(const PlainMesh& mesh, std::size_t most_middles) : most_middles_(most_middles), starts_{0} {
  const Box3 box = mesh.bounds();
  const Vec3 rim = box.size() * 0x1p-20 + Vec3(std::numeric_limits<double>::min());
  low_ = box.min - rim;
  size_ = box.size() + rim * 2;
  std::vector<std::uint32_t> all(mesh.cell_count());
  std::iota(all.begin(), all.end(), 0U);
  build_node(mesh, {}, divided(mesh, {}, all), 1);
}

/// The cells among these that touch each child of a node.
std::array<Octree::Touching, 8> Octree::divided(const PlainMesh& mesh, const Cube& cube,
                                                const std::vector<std::uint32_t>& cells) const {
  std::array<Touching, 8> parts;
  const Vec3 half(0.25 * cube.edge);
  for (const std::uint32_t cell : cells) {
    auto points = mesh.points_at(mesh.sorted_vertices(cell));
    for (auto& point : points)
      for (int axis = 0; axis < 3; ++axis) {
        double& x = point[static_cast<std::size_t>(axis)];
        x = (x - low_[axis]) / size_[axis];
      }
    const CellSides sides(points);
    const Vec3 middle = (mesh.center(cell) - low_) / size_;
    for (unsigned child = 0; child < 8; ++child) {
      const Cube part = cube.child(child);
      if (!sides.touches(part.low + half, half)) continue;
      parts[child].cells.push_back(cell);
      const Vec3 from_low = middle - part.low;
      bool is_inside = true;
      for (int axis = 0; axis < 3; ++axis) is_inside &= from_low[axis] >= 0 && from_low[axis] < part.edge;
      parts[child].middle_count += is_inside;
    }
  }
  return parts;
}

Octree::Built Octree::build_leaf(const PlainMesh& mesh, const std::vector<std::uint32_t>& cells) {
  Built built{leaf_bit | static_cast<std::uint32_t>(starts_.size() - 1), no_value};
  items_.insert(items_.end(), cells.begin(), cells.end());
  starts_.push_back(static_cast<std::uint32_t>(items_.size()));
  for (const std::uint32_t cell : cells) built.range = together(built.range, mesh.range(cell));
  return built;
}

Octree::Built Octree::build_node(const PlainMesh& mesh, const Cube& cube, const std::array<Touching, 8>& parts,
                                 int level) {
  Built built{static_cast<std::uint32_t>(nodes_.size()), no_value};
  nodes_.emplace_back();
  for (unsigned child = 0; child < 8; ++child) {
    const Touching& touching = parts[child];
    const Cube below = cube.child(child);
    const bool divides = touching.middle_count > most_middles_ && level < most_levels;
    const Built part = divides ? build_node(mesh, below, divided(mesh, below, touching.cells), level + 1)
                               : build_leaf(mesh, touching.cells);
    Node& node = nodes_[built.node];
    node.child[child] = part.node;
    node.lo[child] = part.range.lo, node.hi[child] = part.range.hi;
    built.range = together(built.range, part.range);
  }
  return built;
}

std::uint64_t Octree::bytes() const {
  return nodes_.size() * sizeof nodes_[0] + starts_.size() * sizeof starts_[0] + items_.size() * sizeof items_[0];
}

}  // namespace rhoray::study

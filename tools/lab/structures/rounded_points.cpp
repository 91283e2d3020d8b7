#include "tools/lab/structures/rounded_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rhoray::study {
namespace {

Vec3 vector_of(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

double six_volumes(const std::array<std::array<double, 3>, 4>& p) {
  const Vec3 a = vector_of(p[0]);
  return (vector_of(p[1]) - a).dot((vector_of(p[2]) - a).cross(vector_of(p[3]) - a));
}

}  // namespace

FloatPoints::FloatPoints(const formats::TetMesh& packed) : ClusteredCells(packed) {
  for (const auto& p : packed.points())
    points_.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
}

LatticePoints::LatticePoints(const formats::TetMesh& packed) : ClusteredCells(packed) {
  constexpr double last = (1 << 21) - 1;
  Box3 box;
  for (const auto& point : packed.points()) box.extendBy(vector_of(point));
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    low_[a] = box.min[axis], step_[a] = box.size()[axis] / last;
  }
  for (const auto& point : packed.points()) {
    std::uint64_t stored = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // A flat mesh has one position.
      const double steps = step_[axis] > 0 ? (point[axis] - low_[axis]) / step_[axis] + 0.5 : 0;
      stored |= static_cast<std::uint64_t>(std::min(steps, last)) << (21 * axis);
    }
    points_.push_back(stored);
  }
}

template <class Mesh>
RoundedShape shape_of(const Mesh& rounded) {
  const formats::TetMesh& packed = rounded.packed();
  const formats::CellClustersView& clusters = packed.clusters();
  RoundedShape shape;
  // For each point, the box of its positions, and the longest edge of a cell that contains it.
  std::vector<Box3> places(packed.points().size());
  std::vector<double> longest_edge(packed.points().size(), 0);
  for (std::uint64_t cluster = 0; cluster < clusters.cluster_count(); ++cluster)
    for (std::uint64_t cell = clusters.first_cell(cluster); cell < clusters.end_cell(cluster); ++cell) {
      const auto v = rounded.sorted_vertices(static_cast<std::uint32_t>(cell));
      std::array<std::array<double, 3>, 4> before;
      for (std::size_t n = 0; n < 4; ++n) {
        before[n] = packed.points()[rounded.point(v.entry[n])];
        places[rounded.point(v.entry[n])].extendBy(vector_of(rounded.place(cluster, v.entry[n])));
      }
      const double volume = six_volumes(before);
      shape.folded_cells += volume != 0 && !(volume * six_volumes(rounded.points_at(v)) > 0);
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) {
          double& edge = longest_edge[rounded.point(v.entry[a])];
          edge = std::max(edge, (vector_of(before[a]) - vector_of(before[b])).length());
        }
    }
  for (std::size_t point = 0; point < places.size(); ++point) {
    const double gap = places[point].size().length();
    shape.split_points += gap > 0;
    shape.widest_gap_edges = std::max(shape.widest_gap_edges, gap / longest_edge[point]);
  }
  return shape;
}

template RoundedShape shape_of(const DoublePoints&);
template RoundedShape shape_of(const FloatPoints&);
template RoundedShape shape_of(const LatticePoints&);
template RoundedShape shape_of(const ClusterPoints<SixteenBits>&);
template RoundedShape shape_of(const ClusterPoints<ElevenBits>&);

}  // namespace rhoray::study

#include "render/triangles/point_gradients.h"

#include <algorithm>
#include <cmath>

#include "formats/base/stopping.h"
#include "formats/base/vector.h"

namespace rhoray::render {

namespace {

/// Six times the volume of a cell, and its gradient multiplied by that.
struct WeightedGradient {
  Vec3 gradient;
  double weight;
};

WeightedGradient weighted_gradient(const std::array<std::array<double, 3>, 4>& points,
                                   const std::array<double, 4>& values) {
  const auto edge = [&](std::size_t to) {
    return Vec3(points[to][0] - points[0][0], points[to][1] - points[0][1], points[to][2] - points[0][2]);
  };
  const Vec3 a = edge(1), b = edge(2), c = edge(3), bc = b.cross(c);
  const double six_volumes = a.dot(bc);
  const Vec3 gradient =
      (values[1] - values[0]) * bc + (values[2] - values[0]) * c.cross(a) + (values[3] - values[0]) * a.cross(b);
  return six_volumes < 0 ? WeightedGradient{-gradient, -six_volumes} : WeightedGradient{gradient, six_volumes};
}

}  // namespace

// Every thread goes through all cells in order and adds up those of its own points. Sums are
// therefore the same for any number of threads, and no list of the cells around a point is needed.
PointGradients::PointGradients(const TetData& view, unsigned threads, const std::stop_token& stop)
    : gradients_(view.description().point_count, std::array<double, 3>{}) {
  constexpr std::uint64_t fewest_points = 1 << 14, cells_per_check = 1 << 12;
  const std::uint64_t cell_count = view.description().cell_count;
  for_each_range(gradients_.size(), fewest_points, threads, [&](std::uint64_t first, std::uint64_t end) {
    std::vector<double> weights(end - first);
    for_each_until_stopped(0, cell_count, cells_per_check, stop, [&](std::uint64_t cell) {
      const auto vertices = view.vertices(static_cast<std::uint32_t>(cell));
      const auto is_own = [&](std::uint32_t point) { return point >= first && point < end; };
      if (std::none_of(vertices.begin(), vertices.end(), is_own)) return;
      const auto values = view.values_at(vertices);
      if (!has_data(values)) return;
      const auto [gradient, weight] = weighted_gradient(view.points_at(vertices), values);
      for (const std::uint32_t point : vertices) {
        if (!is_own(point)) continue;
        for (int axis = 0; axis < 3; ++axis) gradients_[point][static_cast<std::size_t>(axis)] += gradient[axis];
        weights[point - first] += weight;
      }
    });
    for (std::uint64_t point = first; point < end; ++point)
      for (double& component : gradients_[point])
        component = weights[point - first] > 0 ? component / weights[point - first] : 0;
  });
}

}  // namespace rhoray::render

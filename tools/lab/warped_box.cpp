#include "tools/lab/warped_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>

namespace rhoray::study {

preprocess::NeutralMesh warped_box(std::int64_t edge) {
  preprocess::NeutralMesh mesh;
  preprocess::NeutralField field{
      .name = "value", .unit = {}, .component_count = 1, .was_single_precision = true, .values = {}};
  const auto point_count = static_cast<std::size_t>((edge + 1) * (edge + 1) * (edge + 1));
  mesh.points.reserve(point_count);
  field.values.reserve(point_count);
  mesh.cells.reserve(static_cast<std::size_t>(6 * edge * edge * edge));
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> shift(-0.1, 0.1);
  for (std::int64_t k = 0; k <= edge; ++k)
    for (std::int64_t j = 0; j <= edge; ++j)
      for (std::int64_t i = 0; i <= edge; ++i) {
        std::array<double, 3> p{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        const bool is_inside = i > 0 && j > 0 && k > 0 && i < edge && j < edge && k < edge;
        for (double& x : p) x = (x + (is_inside ? shift(random) : 0)) / static_cast<double>(edge);
        mesh.points.push_back(p);
        const double value = std::sin(5 * p[0]) * std::cos(7 * p[1]) + std::exp(p[2]) * p[0];
        field.values.push_back(static_cast<double>(static_cast<float>(value)));
      }
  mesh.point_fields.push_back(std::move(field));

  // Divide each cube along its diagonal: one tetrahedron for each order of the three axes.
  constexpr std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  const std::array<std::int64_t, 3> step{1, edge + 1, (edge + 1) * (edge + 1)};
  for (std::int64_t k = 0; k < edge; ++k)
    for (std::int64_t j = 0; j < edge; ++j)
      for (std::int64_t i = 0; i < edge; ++i)
        for (std::size_t order = 0; order < orders.size(); ++order) {
          std::array<std::int64_t, 4> cell{i * step[0] + j * step[1] + k * step[2]};
          for (std::size_t v = 0; v < 3; ++v) cell[v + 1] = cell[v] + step[orders[order][v]];
          if (order >= 3) std::swap(cell[2], cell[3]);
          mesh.cells.push_back({static_cast<std::uint64_t>(cell[0]), static_cast<std::uint64_t>(cell[1]),
                                static_cast<std::uint64_t>(cell[2]), static_cast<std::uint64_t>(cell[3])});
        }
  return mesh;
}

std::int64_t edge_for(std::uint64_t cell_count) {
  return std::max<std::int64_t>(1, std::llround(std::cbrt(static_cast<double>(cell_count) / 6)));
}

}  // namespace rhoray::study

#include "render/truth.h"

#include <algorithm>

namespace rhoray::render {

namespace {

/// Length in cells of a vector at a position, or at the nearest position in the grid. Both are in
/// the grid's frame.
double in_cells(const formats::GridDescription& grid, Vec3 vector, const Vec3& position) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& table = grid.axes[static_cast<std::size_t>(axis)];
    if (table.empty()) continue;  // samples at 0, 1, 2, ...
    const auto high = std::upper_bound(table.begin() + 1, table.end() - 1, position[axis]);
    vector[axis] /= *high - *(high - 1);
  }
  return vector.length();
}

double longest_edge(const formats::TetMesh& mesh, std::uint32_t tet) {
  const auto corners = mesh.cell(tet);
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b) {
      const std::array<double, 3>&p = mesh.points()[corners[a]], &q = mesh.points()[corners[b]];
      longest = std::max(longest, Vec3(p[0] - q[0], p[1] - q[1], p[2] - q[2]).length());
    }
  return longest;
}

}  // namespace

CellLengths::CellLengths(const Dataset& dataset) {
  if (dataset.is_mesh())
    mesh_.emplace(dataset.file());
  else if (dataset.file().description().kind == "grid")
    grid_.emplace(dataset.file());
}

double CellLengths::cells_per_t(const Ray& ray, const Hit& hit) const {
  if (grid_) return in_cells(grid_->description(), ray.direction, ray.at(hit.t));
  return mesh_ ? ray.direction.length() / longest_edge(*mesh_, hit.tet) : ray.direction.length();
}

}  // namespace rhoray::render

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::tests {

/// Between which corners each further node of a quadratic cell stands, in VTK's order (the drawings
/// of vtkQuadraticTetra and its neighbours); the 14-node kinds as preprocess/neutral.h describes
/// them.
inline const std::map<preprocess::CellKind, std::vector<std::vector<int>>>& corners_between() {
  using preprocess::CellKind;
  using Rows = std::vector<std::vector<int>>;
  const auto join = [](Rows rows, const Rows& more) {
    rows.insert(rows.end(), more.begin(), more.end());
    return rows;
  };
  static const Rows tetrahedron{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  static const Rows hexahedron{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                               {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  static const Rows wedge{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
  static const Rows pyramid{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
  static const std::map<CellKind, Rows> table{
      {CellKind::quadratic_tetrahedron, tetrahedron},
      {CellKind::quadratic_tetrahedron_14, join(tetrahedron, {{0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 2, 1}})},
      {CellKind::quadratic_hexahedron, hexahedron},
      {CellKind::triquadratic_hexahedron, join(hexahedron, {{0, 3, 4, 7},
                                                            {1, 2, 5, 6},
                                                            {0, 1, 4, 5},
                                                            {3, 2, 7, 6},
                                                            {0, 1, 2, 3},
                                                            {4, 5, 6, 7},
                                                            {0, 1, 2, 3, 4, 5, 6, 7}})},
      {CellKind::quadratic_wedge, wedge},
      {CellKind::biquadratic_quadratic_wedge, join(wedge, {{0, 1, 3, 4}, {1, 2, 4, 5}, {2, 0, 5, 3}})},
      {CellKind::quadratic_pyramid, pyramid},
      {CellKind::quadratic_pyramid_14, join(pyramid, {{0, 1, 2, 3}})},
  };
  return table;
}

inline int corner_count(preprocess::CellKind kind) {
  int count = 0;
  for (const auto& row : corners_between().at(kind))
    for (const int corner : row) count = std::max(count, corner + 1);
  return count;
}

/// Every further node of every cell lies where its kind says, within `tolerance` of the cell's
/// longest first edge. Returns how many nodes were looked at.
inline std::size_t expect_nodes_in_their_places(const preprocess::CellMesh& mesh, double tolerance) {
  std::size_t looked_at = 0;
  for (std::size_t c = 0; c < mesh.kinds.size(); ++c) {
    const auto found = corners_between().find(mesh.kinds[c]);
    if (found == corners_between().end()) continue;
    const auto* nodes = mesh.cell_nodes.data() + mesh.cell_offsets[c];
    const auto first = static_cast<std::size_t>(corner_count(mesh.kinds[c]));
    for (std::size_t i = 0; i < found->second.size(); ++i) {
      double apart = 0, size = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double mean = 0;
        for (const int corner : found->second[i])
          mean += mesh.points[nodes[corner]][axis] / static_cast<double>(found->second[i].size());
        apart = std::max(apart, std::abs(mean - mesh.points[nodes[first + i]][axis]));
        size = std::max(size, std::abs(mesh.points[nodes[0]][axis] - mesh.points[nodes[1]][axis]));
      }
      EXPECT_LE(apart, tolerance * size) << "cell " << c << ", node " << first + i;
      ++looked_at;
    }
  }
  return looked_at;
}

}  // namespace rhoray::tests

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::tests {

/// Six times the volume; positive in VTK's vertex order.
inline double volume6(const preprocess::NeutralMesh& mesh, const std::array<std::uint64_t, 4>& cell) {
  std::array<std::array<double, 3>, 3> u;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      u[i][axis] = mesh.points[cell[i + 1]][axis] - mesh.points[cell[0]][axis];
  return u[0][0] * (u[1][1] * u[2][2] - u[1][2] * u[2][1]) - u[0][1] * (u[1][0] * u[2][2] - u[1][2] * u[2][0]) +
         u[0][2] * (u[1][0] * u[2][1] - u[1][1] * u[2][0]);
}

/// Sum of the signed volumes of all tetrahedra: inverted ones are subtracted.
inline double mesh_volume(const preprocess::NeutralMesh& mesh) {
  double sum = 0;
  for (const auto& cell : mesh.cells) sum += volume6(mesh, cell) / 6;
  return sum;
}

/// Counts how the tetrahedra of a mesh share their faces.
struct FaceCensus {
  std::uint64_t inner = 0;  ///< shared by two, one on each side
  /// shared by two on the same side: one of them is inverted or misplaced
  std::uint64_t one_side = 0;
  std::uint64_t crowded = 0;  ///< shared by more than two
  /// of one tetrahedron only; point indices are sorted, so orientation is lost
  std::vector<std::array<std::uint64_t, 3>> outer;
};

inline FaceCensus census_of_faces(const preprocess::NeutralMesh& mesh) {
  struct Face {
    std::array<std::uint64_t, 3> points;
    bool is_even;  ///< sorting the points took an even number of exchanges
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.cells.size());
  for (const auto& c : mesh.cells)
    for (const std::array<std::uint64_t, 3>& corners : {std::array{c[0], c[2], c[1]}, std::array{c[0], c[1], c[3]},
                                                        std::array{c[1], c[2], c[3]}, std::array{c[0], c[3], c[2]}}) {
      Face face{corners, true};
      for (const auto& [i, j] : {std::pair{0U, 1U}, std::pair{1U, 2U}, std::pair{0U, 1U}})
        if (face.points[i] > face.points[j]) {
          std::swap(face.points[i], face.points[j]);
          face.is_even = !face.is_even;
        }
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.points < b.points; });
  FaceCensus census;
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    while (end < faces.size() && faces[end].points == faces[begin].points) ++end;
    if (end - begin == 1)
      census.outer.push_back(faces[begin].points);
    else if (end - begin > 2)
      ++census.crowded;
    else if (faces[begin].is_even == faces[begin + 1].is_even)
      ++census.one_side;
    else
      ++census.inner;
  }
  return census;
}

/// Checks that every face is shared by two tetrahedra, one on each side, or lies outside.
/// `is_outside(a, b, c)` says which triangles, given by their points, may lie outside. So it finds
/// a face that two neighbours cut differently.
template <class IsOutside>
testing::AssertionResult conforms(const preprocess::NeutralMesh& mesh, IsOutside&& is_outside) {
  const FaceCensus census = census_of_faces(mesh);
  if (census.crowded != 0)
    return testing::AssertionFailure() << census.crowded << " faces are shared by more than two tetrahedra";
  if (census.one_side != 0)
    return testing::AssertionFailure() << census.one_side << " faces have both their tetrahedra on one side";
  std::uint64_t unmatched = 0;
  for (const auto& [a, b, c] : census.outer)
    if (!is_outside(mesh.points[a], mesh.points[b], mesh.points[c])) ++unmatched;
  if (unmatched != 0) return testing::AssertionFailure() << unmatched << " inner faces belong to one tetrahedron only";
  return testing::AssertionSuccess();
}

/// The same for a mesh that fills a box, up to rounding.
inline testing::AssertionResult conforms_in_box(const preprocess::NeutralMesh& mesh, const std::array<double, 3>& low,
                                                const std::array<double, 3>& high) {
  using Point = std::array<double, 3>;
  const auto same = [](double x, double side) { return std::abs(x - side) < 1e-9; };
  return conforms(mesh, [&](const Point& a, const Point& b, const Point& c) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const double side : {low[axis], high[axis]})
        if (same(a[axis], side) && same(b[axis], side) && same(c[axis], side)) return true;
    return false;
  });
}

}  // namespace rhoray::tests

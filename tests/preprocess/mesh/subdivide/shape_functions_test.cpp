#include "preprocess/mesh/subdivide/shape_functions.h"

#include <gtest/gtest.h>
#include <vtkBiQuadraticQuadraticHexahedron.h>
#include <vtkBiQuadraticQuadraticWedge.h>
#include <vtkIdList.h>
#include <vtkLagrangeHexahedron.h>
#include <vtkLagrangeTetra.h>
#include <vtkLagrangeWedge.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkQuadraticHexahedron.h>
#include <vtkQuadraticLinearWedge.h>
#include <vtkQuadraticPyramid.h>
#include <vtkQuadraticTetra.h>
#include <vtkQuadraticWedge.h>
#include <vtkTriQuadraticHexahedron.h>
#include <vtkTriQuadraticPyramid.h>

#include <random>

#include "tests/support/expect_error.h"

namespace rhoray::preprocess {
namespace {

using tests::expect_error;

std::vector<double> weights_at(const ShapeFunctions& shape, const CellPlace& place) {
  std::vector<double> weights(shape.node_count());
  shape.at(place, weights);
  return weights;
}

/// A place inside the unit tetrahedron, hexahedron or wedge, or anything between the corners of a
/// pyramid.
CellPlace random_place(std::mt19937_64& random, CellKind kind) {
  std::uniform_real_distribution<double> unit(0, 1);
  double r = unit(random), s = unit(random), t = unit(random);
  if (kind == CellKind::pyramid) return {r * (1 - t), s * (1 - t), t};
  if (kind != CellKind::hexahedron && r + s > 1) {
    r = 1 - r;
    s = 1 - s;
  }
  if (kind == CellKind::tetrahedron) t *= 1 - r - s;
  return {r, s, t};
}

void expect_same_as_vtk(vtkCell& cell, CellKind kind, CellKind corners, std::size_t node_count) {
  SCOPED_TRACE(testing::Message() << static_cast<int>(kind) << ", " << node_count << " nodes");
  const ShapeFunctions shape(kind, node_count);
  ASSERT_EQ(shape.node_count(), node_count);
  std::mt19937_64 random(1);
  for (int i = 0; i < 50; ++i) {
    const CellPlace place = random_place(random, corners);
    const std::vector<double> ours = weights_at(shape, place);
    std::vector<double> theirs(node_count);
    cell.InterpolateFunctions(place.data(), theirs.data());
    for (std::size_t n = 0; n < node_count; ++n) ASSERT_NEAR(ours[n], theirs[n], 1e-9) << n;
  }
}

template <class Cell>
void expect_same_as_vtk(CellKind kind, CellKind corners, std::size_t node_count) {
  vtkNew<Cell> cell;
  expect_same_as_vtk(*cell, kind, corners, node_count);
}

TEST(ShapeFunctions, are_those_of_vtk_for_its_quadratic_cells) {
  using enum CellKind;
  expect_same_as_vtk<vtkQuadraticTetra>(quadratic_tetrahedron, tetrahedron, 10);
  expect_same_as_vtk<vtkQuadraticHexahedron>(quadratic_hexahedron, hexahedron, 20);
  expect_same_as_vtk<vtkBiQuadraticQuadraticHexahedron>(biquadratic_quadratic_hexahedron, hexahedron, 24);
  expect_same_as_vtk<vtkTriQuadraticHexahedron>(triquadratic_hexahedron, hexahedron, 27);
  expect_same_as_vtk<vtkQuadraticLinearWedge>(quadratic_linear_wedge, wedge, 12);
  expect_same_as_vtk<vtkQuadraticWedge>(quadratic_wedge, wedge, 15);
  expect_same_as_vtk<vtkBiQuadraticQuadraticWedge>(biquadratic_quadratic_wedge, wedge, 18);
}

template <class Cell>
void expect_same_as_vtk_lagrange(CellKind kind, CellKind corners, std::size_t node_count) {
  vtkNew<Cell> cell;
  const auto count = static_cast<vtkIdType>(node_count);
  cell->GetPointIds()->SetNumberOfIds(count);
  cell->GetPoints()->SetNumberOfPoints(count);
  if constexpr (requires { cell->SetUniformOrderFromNumPoints(count); }) cell->SetUniformOrderFromNumPoints(count);
  cell->Initialize();
  expect_same_as_vtk(*cell, kind, corners, node_count);
}

TEST(ShapeFunctions, are_those_of_vtk_for_lagrange_cells_of_any_order) {
  using enum CellKind;
  for (const std::size_t n : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
    expect_same_as_vtk_lagrange<vtkLagrangeTetra>(lagrange_tetrahedron, tetrahedron, (n + 1) * (n + 2) * (n + 3) / 6);
    expect_same_as_vtk_lagrange<vtkLagrangeHexahedron>(lagrange_hexahedron, hexahedron, (n + 1) * (n + 1) * (n + 1));
    expect_same_as_vtk_lagrange<vtkLagrangeWedge>(lagrange_wedge, wedge, (n + 1) * (n + 1) * (n + 2) / 2);
  }
  expect_same_as_vtk_lagrange<vtkLagrangeTetra>(lagrange_tetrahedron, tetrahedron, 15);
  expect_same_as_vtk_lagrange<vtkLagrangeWedge>(lagrange_wedge, wedge, 21);
}

struct Row {
  CellKind kind, corners;
  std::size_t node_count;
};

std::vector<Row> all_rows() {
  using enum CellKind;
  return {{quadratic_tetrahedron, tetrahedron, 10},
          {quadratic_tetrahedron_14, tetrahedron, 14},
          {lagrange_tetrahedron, tetrahedron, 15},
          {lagrange_tetrahedron, tetrahedron, 56},
          {quadratic_hexahedron, hexahedron, 20},
          {biquadratic_quadratic_hexahedron, hexahedron, 24},
          {triquadratic_hexahedron, hexahedron, 27},
          {lagrange_hexahedron, hexahedron, 125},
          {quadratic_linear_wedge, wedge, 12},
          {quadratic_wedge, wedge, 15},
          {biquadratic_quadratic_wedge, wedge, 18},
          {lagrange_wedge, wedge, 21},
          {lagrange_wedge, wedge, 40},
          {quadratic_pyramid, pyramid, 13},
          {lagrange_pyramid, pyramid, 13},
          {quadratic_pyramid_14, pyramid, 14},
          {lagrange_pyramid, pyramid, 14},
          {triquadratic_pyramid, pyramid, 19}};
}

TEST(ShapeFunctions, are_one_at_their_node_and_nothing_at_the_others) {
  for (const Row& row : all_rows()) {
    const ShapeFunctions shape(row.kind, row.node_count);
    for (std::size_t n = 0; n < row.node_count; ++n) {
      const std::vector<double> weights = weights_at(shape, shape.node_places()[n]);
      for (std::size_t m = 0; m < row.node_count; ++m)
        EXPECT_NEAR(weights[m], m == n ? 1 : 0, 1e-12) << static_cast<int>(row.kind) << " " << n << " " << m;
    }
  }
}

TEST(ShapeFunctions, reproduce_linear_functions_of_their_places) {
  std::mt19937_64 random(2);
  for (const Row& row : all_rows()) {
    const ShapeFunctions shape(row.kind, row.node_count);
    for (int i = 0; i < 20; ++i) {
      const CellPlace place = random_place(random, row.corners);
      const std::vector<double> weights = weights_at(shape, place);
      double one = 0;
      CellPlace found{};
      for (std::size_t n = 0; n < row.node_count; ++n) {
        one += weights[n];
        for (std::size_t axis = 0; axis < 3; ++axis) found[axis] += weights[n] * shape.node_places()[n][axis];
      }
      EXPECT_NEAR(one, 1, 1e-12);
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found[axis], place[axis], 1e-12) << static_cast<int>(row.kind);
    }
  }
}

/// In the face of a pyramid with corners a, b and the apex, nodes of the edges ab, b-apex, a-apex:
/// the functions there must be those of a tetrahedron's face 0-1-2, and those of all other nodes
/// nothing.
TEST(ShapeFunctions, of_pyramids_agree_with_tetrahedra_at_their_triangular_faces_and_with_hexahedra_below) {
  using enum CellKind;
  const ShapeFunctions tetrahedron_10(quadratic_tetrahedron, 10), tetrahedron_14(quadratic_tetrahedron_14, 14);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const auto& [kind, count] : {std::pair{quadratic_pyramid, 13U}, std::pair{quadratic_pyramid_14, 14U},
                                    std::pair{triquadratic_pyramid, 19U}}) {
    const ShapeFunctions pyramid(kind, count);
    const bool has_middles = count == 19;
    const ShapeFunctions& tetrahedron = has_middles ? tetrahedron_14 : tetrahedron_10;
    const ShapeFunctions hexahedron(count == 13 ? quadratic_hexahedron : triquadratic_hexahedron,
                                    count == 13 ? 20 : 27);
    for (std::size_t side = 0; side < 4; ++side)
      for (int i = 0; i < 20; ++i) {
        double r = unit(random), s = unit(random);
        if (r + s > 1) r = 1 - r, s = 1 - s;
        const auto &a = pyramid.node_places()[side], &b = pyramid.node_places()[(side + 1) % 4];
        CellPlace place{};
        for (std::size_t axis = 0; axis < 3; ++axis)
          place[axis] = (1 - r - s) * a[axis] + r * b[axis] + s * (axis == 2 ? 1 : 0);
        std::vector<double> in_pyramid = weights_at(pyramid, place);
        const std::vector<double> in_tetrahedron = weights_at(tetrahedron, {r, s, 0});
        const std::size_t next = (side + 1) % 4;
        const std::size_t from[] = {side, next, 4, 5 + side, 9 + next, 9 + side, 14 + side};
        const std::size_t to[] = {0, 1, 2, 4, 5, 6, 13};
        for (std::size_t n = 0; n < (has_middles ? 7 : 6); ++n) {
          EXPECT_NEAR(in_pyramid[from[n]], in_tetrahedron[to[n]], 1e-12) << count << " " << n;
          in_pyramid[from[n]] = 0;
        }
        for (const double rest : in_pyramid) EXPECT_NEAR(rest, 0, 1e-12);

        in_pyramid = weights_at(pyramid, {r, s, 0});
        const std::vector<double> in_hexahedron = weights_at(hexahedron, {r, s, 0});
        const std::size_t below[] = {0, 1, 2, 3, 5, 6, 7, 8, 13}, there[] = {0, 1, 2, 3, 8, 9, 10, 11, 24};
        for (std::size_t n = 0; n < (count == 13 ? 8 : 9); ++n)
          EXPECT_NEAR(in_pyramid[below[n]], in_hexahedron[there[n]], 1e-12) << count << " " << n;
      }
  }
}

TEST(ShapeFunctions, of_pyramids_are_those_of_vtk_along_edges) {
  vtkNew<vtkQuadraticPyramid> cell;
  const ShapeFunctions shape(CellKind::quadratic_pyramid, 13);
  for (const auto& [r, s] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
    for (const double t : {0.0, 0.2, 0.7, 1.0}) {
      const std::array<double, 3> upward{r, s, t}, along{t, s, 0};
      std::vector<double> theirs(13);
      cell->InterpolateFunctions(upward.data(), theirs.data());
      const std::vector<double> ours = weights_at(shape, {r * (1 - t), s * (1 - t), t});
      for (std::size_t n = 0; n < 13; ++n) EXPECT_NEAR(ours[n], theirs[n], 1e-12) << n;
      cell->InterpolateFunctions(along.data(), theirs.data());
      const std::vector<double> at_base = weights_at(shape, {t, s, 0});
      for (std::size_t n = 0; n < 13; ++n) EXPECT_NEAR(at_base[n], theirs[n], 1e-12) << n;
    }
}

TEST(ShapeFunctions, refuse_node_counts_that_a_kind_cannot_have) {
  expect_error(ErrorCode::invalid, "a quadratic wedge of 14 nodes; expected 15",
               [] { ShapeFunctions(CellKind::quadratic_wedge, 14); });
  expect_error(ErrorCode::unsupported, "a Lagrange hexahedron of 28 nodes",
               [] { ShapeFunctions(CellKind::lagrange_hexahedron, 28); });
  expect_error(ErrorCode::unsupported, "a Lagrange pyramid of 30 nodes",
               [] { ShapeFunctions(CellKind::lagrange_pyramid, 30); });
}

}  // namespace
}  // namespace rhoray::preprocess

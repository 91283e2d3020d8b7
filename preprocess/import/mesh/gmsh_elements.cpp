#include "preprocess/import/mesh/gmsh_elements.h"

#include <vtkHigherOrderHexahedron.h>
#include <vtkHigherOrderTetra.h>

#include <algorithm>
#include <array>

#include "formats/base/checks.h"

namespace rhoray::preprocess {
namespace {

enum class Shape : std::uint8_t { point, line, triangle, quadrilateral, tetrahedron, hexahedron, wedge, pyramid };

struct Row {
  std::uint8_t number;
  Shape shape;
  std::uint8_t order;
  std::uint16_t node_count;
};

constexpr Row rows[] = {
    {1, Shape::line, 1, 2},
    {2, Shape::triangle, 1, 3},
    {3, Shape::quadrilateral, 1, 4},
    {4, Shape::tetrahedron, 1, 4},
    {5, Shape::hexahedron, 1, 8},
    {6, Shape::wedge, 1, 6},
    {7, Shape::pyramid, 1, 5},
    {8, Shape::line, 2, 3},
    {9, Shape::triangle, 2, 6},
    {10, Shape::quadrilateral, 2, 9},
    {11, Shape::tetrahedron, 2, 10},
    {12, Shape::hexahedron, 2, 27},
    {13, Shape::wedge, 2, 18},
    {14, Shape::pyramid, 2, 14},
    {15, Shape::point, 0, 1},
    {16, Shape::quadrilateral, 2, 8},
    {17, Shape::hexahedron, 2, 20},
    {18, Shape::wedge, 2, 15},
    {19, Shape::pyramid, 2, 13},
    {20, Shape::triangle, 3, 9},
    {21, Shape::triangle, 3, 10},
    {22, Shape::triangle, 4, 12},
    {23, Shape::triangle, 4, 15},
    {24, Shape::triangle, 5, 15},
    {25, Shape::triangle, 5, 21},
    {26, Shape::line, 3, 4},
    {27, Shape::line, 4, 5},
    {28, Shape::line, 5, 6},
    {29, Shape::tetrahedron, 3, 20},
    {30, Shape::tetrahedron, 4, 35},
    {31, Shape::tetrahedron, 5, 56},
    {32, Shape::tetrahedron, 4, 22},
    {33, Shape::tetrahedron, 5, 28},
    {36, Shape::quadrilateral, 3, 16},
    {37, Shape::quadrilateral, 4, 25},
    {38, Shape::quadrilateral, 5, 36},
    {39, Shape::quadrilateral, 3, 12},
    {40, Shape::quadrilateral, 4, 16},
    {41, Shape::quadrilateral, 5, 20},
    {42, Shape::triangle, 6, 28},
    {43, Shape::triangle, 7, 36},
    {44, Shape::triangle, 8, 45},
    {45, Shape::triangle, 9, 55},
    {46, Shape::triangle, 10, 66},
    {47, Shape::quadrilateral, 6, 49},
    {48, Shape::quadrilateral, 7, 64},
    {49, Shape::quadrilateral, 8, 81},
    {50, Shape::quadrilateral, 9, 100},
    {51, Shape::quadrilateral, 10, 121},
    {52, Shape::triangle, 6, 18},
    {53, Shape::triangle, 7, 21},
    {54, Shape::triangle, 8, 24},
    {55, Shape::triangle, 9, 27},
    {56, Shape::triangle, 10, 30},
    {57, Shape::quadrilateral, 6, 24},
    {58, Shape::quadrilateral, 7, 28},
    {59, Shape::quadrilateral, 8, 32},
    {60, Shape::quadrilateral, 9, 36},
    {61, Shape::quadrilateral, 10, 40},
    {62, Shape::line, 6, 7},
    {63, Shape::line, 7, 8},
    {64, Shape::line, 8, 9},
    {65, Shape::line, 9, 10},
    {66, Shape::line, 10, 11},
    {71, Shape::tetrahedron, 6, 84},
    {72, Shape::tetrahedron, 7, 120},
    {73, Shape::tetrahedron, 8, 165},
    {74, Shape::tetrahedron, 9, 220},
    {75, Shape::tetrahedron, 10, 286},
    {79, Shape::tetrahedron, 6, 34},
    {80, Shape::tetrahedron, 7, 40},
    {81, Shape::tetrahedron, 8, 46},
    {82, Shape::tetrahedron, 9, 52},
    {83, Shape::tetrahedron, 10, 58},
    {92, Shape::hexahedron, 3, 64},
    {93, Shape::hexahedron, 4, 125},
    {94, Shape::hexahedron, 5, 216},
    {95, Shape::hexahedron, 6, 343},
    {96, Shape::hexahedron, 7, 512},
    {97, Shape::hexahedron, 8, 729},
    {98, Shape::hexahedron, 9, 1000},
    {99, Shape::hexahedron, 3, 32},
    {100, Shape::hexahedron, 4, 44},
    {101, Shape::hexahedron, 5, 56},
    {102, Shape::hexahedron, 6, 68},
    {103, Shape::hexahedron, 7, 80},
    {104, Shape::hexahedron, 8, 92},
    {105, Shape::hexahedron, 9, 104},
    {118, Shape::pyramid, 3, 30},
    {119, Shape::pyramid, 4, 55},
    {120, Shape::pyramid, 5, 91},
    {121, Shape::pyramid, 6, 140},
    {122, Shape::pyramid, 7, 204},
    {123, Shape::pyramid, 8, 285},
    {124, Shape::pyramid, 9, 385},
    {125, Shape::pyramid, 3, 21},
    {126, Shape::pyramid, 4, 29},
    {127, Shape::pyramid, 5, 37},
    {128, Shape::pyramid, 6, 45},
    {129, Shape::pyramid, 7, 53},
    {130, Shape::pyramid, 8, 61},
    {131, Shape::pyramid, 9, 69},
    {137, Shape::tetrahedron, 3, 16},
};

/// Position of a node, in n-th parts of the edges from the first corner.
using Place = std::array<int, 3>;

/// A corner of the reference cell, with coordinates 0 and 1.
using Corners = std::vector<Place>;
using Edges = std::vector<std::array<std::size_t, 2>>;
using Faces = std::vector<std::vector<std::size_t>>;

const Corners corners_of_tetrahedron{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const Edges edges_of_tetrahedron{{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}};
const Faces faces_of_tetrahedron{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {3, 1, 2}};

const Corners corners_of_hexahedron{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const Edges edges_of_hexahedron{{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3},
                                {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}};
const Faces faces_of_hexahedron{{0, 3, 2, 1}, {0, 1, 5, 4}, {0, 4, 7, 3}, {1, 2, 6, 5}, {2, 3, 7, 6}, {4, 5, 6, 7}};

/// The nodes inside a face of order n, as steps along its first edge and along the edge from its
/// first to its last corner. They are the nodes of a smaller face, and so on inwards.
void add_face_steps(std::vector<std::array<int, 2>>& steps, bool is_triangle, int n, int first) {
  if (n < 0) return;
  const int last = first + n;
  if (n == 0) {
    steps.push_back({first, first});
    return;
  }
  const std::vector<std::array<int, 2>> corners =
      is_triangle ? std::vector<std::array<int, 2>>{{first, first}, {last, first}, {first, last}}
                  : std::vector<std::array<int, 2>>{{first, first}, {last, first}, {last, last}, {first, last}};
  steps.insert(steps.end(), corners.begin(), corners.end());
  for (std::size_t e = 0; e < corners.size(); ++e)
    for (int i = 1; i < n; ++i) {
      const auto &from = corners[e], &to = corners[(e + 1) % corners.size()];
      steps.push_back({from[0] + (to[0] - from[0]) / n * i, from[1] + (to[1] - from[1]) / n * i});
    }
  add_face_steps(steps, is_triangle, n - (is_triangle ? 3 : 2), first + 1);
}

/// Gmsh's nodes of a complete tetrahedron or hexahedron of order n whose first corner is at (first,
/// first, first).
void add_places(std::vector<Place>& places, bool is_tetrahedron, int n, int first) {
  if (n < 0) return;
  if (n == 0) {
    places.push_back({first, first, first});
    return;
  }
  const Corners& corners = is_tetrahedron ? corners_of_tetrahedron : corners_of_hexahedron;
  const auto add = [&](std::size_t from, const std::array<std::size_t, 2>& to, const std::array<int, 2>& steps) {
    Place place;
    for (std::size_t axis = 0; axis < 3; ++axis)
      place[axis] = first + n * corners[from][axis] + steps[0] * (corners[to[0]][axis] - corners[from][axis]) +
                    steps[1] * (corners[to[1]][axis] - corners[from][axis]);
    places.push_back(place);
  };
  for (std::size_t c = 0; c < corners.size(); ++c) add(c, {c, c}, {0, 0});
  for (const auto& edge : is_tetrahedron ? edges_of_tetrahedron : edges_of_hexahedron)
    for (int i = 1; i < n; ++i) add(edge[0], {edge[1], edge[1]}, {i, 0});
  std::vector<std::array<int, 2>> steps;
  add_face_steps(steps, is_tetrahedron, n - (is_tetrahedron ? 3 : 2), 1);
  for (const auto& face : is_tetrahedron ? faces_of_tetrahedron : faces_of_hexahedron)
    for (const auto& step : steps) add(face[0], {face[1], face.back()}, step);
  add_places(places, is_tetrahedron, n - (is_tetrahedron ? 4 : 2), first + 1);
}

/// VTK's number of the node at this position of a Lagrange cell.
std::size_t vtk_node(bool is_tetrahedron, int n, const Place& place) {
  if (!is_tetrahedron) {
    const int order[3] = {n, n, n};
    return static_cast<std::size_t>(vtkHigherOrderHexahedron::PointIndexFromIJK(place[0], place[1], place[2], order));
  }
  const vtkIdType weights[4] = {place[0], place[1], place[2], n - place[0] - place[1] - place[2]};
  return static_cast<std::size_t>(vtkHigherOrderTetra::Index(weights, n));
}

std::vector<std::uint16_t> lagrange_order(bool is_tetrahedron, int n) {
  std::vector<Place> places;
  add_places(places, is_tetrahedron, n, 0);
  std::vector<std::uint16_t> order(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    order[vtk_node(is_tetrahedron, n, places[i])] = static_cast<std::uint16_t>(i);
  return order;
}

std::size_t complete_count(bool is_tetrahedron, std::size_t n) {
  return is_tetrahedron ? (n + 1) * (n + 2) * (n + 3) / 6 : (n + 1) * (n + 1) * (n + 1);
}

struct QuadraticRow {
  std::uint8_t number;
  CellKind kind;
  std::vector<std::uint16_t> order;
};
const QuadraticRow quadratic_rows[] = {
    {11, CellKind::quadratic_tetrahedron, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
    {17, CellKind::quadratic_hexahedron, {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
    {12, CellKind::triquadratic_hexahedron, {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                             19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26}},
    {18, CellKind::quadratic_wedge, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}},
    {13, CellKind::biquadratic_quadratic_wedge, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16}},
    {19, CellKind::quadratic_pyramid, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12}},
    {14, CellKind::quadratic_pyramid_14, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13}},
};

/// VTK's number of the linear cell of each shape.
constexpr std::uint8_t linear_kinds[] = {1, 3, 5, 9, 10, 12, 13, 14};

GmshElement element_of(const Row& row) {
  GmshElement element{.node_count = row.node_count, .kind = linear_kinds[static_cast<int>(row.shape)], .order = {}};
  // elements that are left out need no node order
  if (row.order < 2 || row.shape < Shape::tetrahedron) return element;
  for (const QuadraticRow& quadratic : quadratic_rows)
    if (quadratic.number == row.number) {
      element.kind = static_cast<std::uint8_t>(quadratic.kind);
      element.order = quadratic.order;
      return element;
    }
  const bool is_tetrahedron = row.shape == Shape::tetrahedron;
  element.is_readable =
      (is_tetrahedron || row.shape == Shape::hexahedron) && row.node_count == complete_count(is_tetrahedron, row.order);
  if (!element.is_readable) return element;
  element.kind =
      static_cast<std::uint8_t>(is_tetrahedron ? CellKind::lagrange_tetrahedron : CellKind::lagrange_hexahedron);
  element.order = lagrange_order(is_tetrahedron, row.order);
  return element;
}

}  // namespace

std::optional<GmshElement> gmsh_element(std::uint64_t number) {
  const auto row =
      std::find_if(std::begin(rows), std::end(rows), [&](const Row& candidate) { return candidate.number == number; });
  if (row == std::end(rows)) return std::nullopt;
  return element_of(*row);
}

}  // namespace rhoray::preprocess

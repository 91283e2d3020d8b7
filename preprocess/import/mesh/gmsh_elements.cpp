#include "preprocess/import/mesh/gmsh_elements.h"

#include <vtkHigherOrderHexahedron.h>
#include <vtkHigherOrderTetra.h>

#include <algorithm>
#include <array>

#include "formats/base/checks.h"

namespace rhoray::preprocess {
namespace {

enum class Shape : std::uint8_t { point, line, triangle, quadrilateral, tetrahedron, hexahedron, wedge, pyramid };

/// Elements of one shape, in ascending order.
struct Family {
  Shape shape;
  bool is_complete;  ///< has nodes inside faces and volumes; else only at corners and on edges
  std::uint8_t first_order;
  std::vector<std::uint8_t> numbers;  ///< in the file, from the first order on
};

const Family families[] = {
    {Shape::point, true, 0, {15}},
    {Shape::line, true, 1, {1, 8, 26, 27, 28, 62, 63, 64, 65, 66}},
    {Shape::triangle, true, 1, {2, 9, 21, 23, 25, 42, 43, 44, 45, 46}},
    {Shape::triangle, false, 3, {20, 22, 24, 52, 53, 54, 55, 56}},
    {Shape::quadrilateral, true, 1, {3, 10, 36, 37, 38, 47, 48, 49, 50, 51}},
    {Shape::quadrilateral, false, 2, {16, 39, 40, 41, 57, 58, 59, 60, 61}},
    {Shape::tetrahedron, true, 1, {4, 11, 29, 30, 31, 71, 72, 73, 74, 75}},
    {Shape::tetrahedron, false, 3, {137, 32, 33, 79, 80, 81, 82, 83}},
    {Shape::hexahedron, true, 1, {5, 12, 92, 93, 94, 95, 96, 97, 98}},
    {Shape::hexahedron, false, 2, {17, 99, 100, 101, 102, 103, 104, 105}},
    {Shape::wedge, true, 1, {6, 13}},
    {Shape::wedge, false, 2, {18}},
    {Shape::pyramid, true, 1, {7, 14, 118, 119, 120, 121, 122, 123, 124}},
    {Shape::pyramid, false, 2, {19, 125, 126, 127, 128, 129, 130, 131}},
};

std::uint64_t node_count(Shape shape, bool is_complete, std::uint64_t n) {
  constexpr std::uint64_t corner_counts[] = {1, 2, 3, 4, 4, 8, 6, 5}, edge_counts[] = {0, 1, 3, 4, 6, 12, 9, 8};
  const auto i = static_cast<std::size_t>(shape);
  if (!is_complete) return corner_counts[i] + edge_counts[i] * (n - 1);
  switch (shape) {
    case Shape::point:
      return 1;
    case Shape::line:
      return n + 1;
    case Shape::triangle:
      return (n + 1) * (n + 2) / 2;
    case Shape::quadrilateral:
      return (n + 1) * (n + 1);
    case Shape::tetrahedron:
      return (n + 1) * (n + 2) * (n + 3) / 6;
    case Shape::hexahedron:
      return (n + 1) * (n + 1) * (n + 1);
    case Shape::wedge:
      return (n + 1) * (n + 1) * (n + 2) / 2;
    case Shape::pyramid:
      return (n + 1) * (n + 2) * (2 * n + 3) / 6;
  }
  RHORAY_CHECK(false);
}

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

GmshElement element_of(const Family& family, int order, std::uint8_t number) {
  GmshElement element{.node_count = node_count(family.shape, family.is_complete, static_cast<std::uint64_t>(order)),
                      .kind = linear_kinds[static_cast<int>(family.shape)],
                      .order = {}};
  // elements that are left out need no node order
  if (order < 2 || family.shape < Shape::tetrahedron) return element;
  for (const QuadraticRow& quadratic : quadratic_rows)
    if (quadratic.number == number) {
      element.kind = static_cast<std::uint8_t>(quadratic.kind);
      element.order = quadratic.order;
      return element;
    }
  const bool is_tetrahedron = family.shape == Shape::tetrahedron;
  element.is_readable = family.is_complete && (is_tetrahedron || family.shape == Shape::hexahedron);
  if (!element.is_readable) return element;
  element.kind =
      static_cast<std::uint8_t>(is_tetrahedron ? CellKind::lagrange_tetrahedron : CellKind::lagrange_hexahedron);
  element.order = lagrange_order(is_tetrahedron, order);
  return element;
}

}  // namespace

std::optional<GmshElement> gmsh_element(std::uint64_t number) {
  for (const Family& family : families)
    if (const auto found = std::find(family.numbers.begin(), family.numbers.end(), number);
        found != family.numbers.end())
      return element_of(family, family.first_order + static_cast<int>(found - family.numbers.begin()), *found);
  return std::nullopt;
}

}  // namespace rhoray::preprocess

// Cells of higher order, straight and bent.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <set>

#include "preprocess/mesh/subdivide/shape_functions.h"
#include "preprocess/subdivide.h"
#include "tests/preprocess/mesh/subdivide/cell_meshes.h"
#include "tests/support/conformity.h"
#include "tests/support/expect_error.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using preprocess::NeutralMesh;
using preprocess::ShapeFunctions;
using preprocess::subdivide;
using testing::Contains;
using testing::HasSubstr;
using Point = std::array<double, 3>;
using Bend = std::function<Point(const Point&)>;

Point straight(const Point& p) {
  return p;
}

/// Bends what lies inside the box (0,0,0)-(n,n,n) and leaves its sides in their planes.
Bend bent(double n, double amount) {
  return [=](const Point& p) {
    const double pi = std::acos(-1.0);
    const double bump = amount * std::sin(pi * p[0] / n) * std::sin(pi * p[1] / n) * std::sin(pi * p[2] / n);
    return Point{p[0] + bump * std::sin(p[1]), p[1] - bump, p[2] + bump * std::cos(2 * p[0])};
  };
}

/// Makes higher-order cells: nodes that lie at the same straight place are one point.
class CurvedMeshMaker {
 public:
  explicit CurvedMeshMaker(Bend bend) : bend_(std::move(bend)) {}

  CellMesh mesh;

  void add(CellKind kind, std::size_t node_count, const std::vector<Point>& corners) {
    const ShapeFunctions shape(kind, node_count);
    Ids nodes;
    for (const auto& place : shape.node_places()) nodes.push_back(point_at(blend(corners, place)));
    add_cell(mesh, kind, nodes);
  }

  /// The straight cell with these corners at a place.
  static Point blend(const std::vector<Point>& corners, const Point& at) {
    const auto [r, s, t] = at;
    std::vector<double> weights;
    if (corners.size() == 4) weights = {1 - r - s - t, r, s, t};
    if (corners.size() == 5) {
      const double u = t < 1 ? r / (1 - t) : 0, v = t < 1 ? s / (1 - t) : 0;
      weights = {(1 - u) * (1 - v) * (1 - t), u * (1 - v) * (1 - t), u * v * (1 - t), (1 - u) * v * (1 - t), t};
    }
    if (corners.size() == 6) weights = {(1 - r - s) * (1 - t), r * (1 - t), s * (1 - t), (1 - r - s) * t, r * t, s * t};
    if (corners.size() == 8)
      weights = {(1 - r) * (1 - s) * (1 - t), r * (1 - s) * (1 - t), r * s * (1 - t), (1 - r) * s * (1 - t),
                 (1 - r) * (1 - s) * t,       r * (1 - s) * t,       r * s * t,       (1 - r) * s * t};
    Point p{};
    for (std::size_t c = 0; c < corners.size(); ++c)
      for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += weights[c] * corners[c][axis];
    return p;
  }

 private:
  std::uint64_t point_at(const Point& p) {
    std::array<std::int64_t, 3> key;
    for (std::size_t axis = 0; axis < 3; ++axis) key[axis] = std::llround(p[axis] * 1e7);
    const auto [found, is_new] = points_.try_emplace(key, mesh.points.size());
    if (is_new) mesh.points.push_back(bend_(p));
    return found->second;
  }

  Bend bend_;
  std::map<std::array<std::int64_t, 3>, std::uint64_t> points_;
};

enum class Family { serendipity, full, lagrange_3 };

struct Member {
  CellKind kind;
  std::size_t node_count;
};

/// Kinds whose faces fit together: of 8 or 9 nodes on squares and 6 on triangles; of third order.
Member member(Family family, std::size_t corner_count) {
  using enum CellKind;
  const bool full = family == Family::full;
  if (family == Family::lagrange_3)
    return corner_count == 4   ? Member{lagrange_tetrahedron, 20}
           : corner_count == 6 ? Member{lagrange_wedge, 40}
                               : Member{lagrange_hexahedron, 64};
  switch (corner_count) {
    case 4:
      return {quadratic_tetrahedron, 10};
    case 5:
      return full ? Member{quadratic_pyramid_14, 14} : Member{quadratic_pyramid, 13};
    case 6:
      return full ? Member{biquadratic_quadratic_wedge, 18} : Member{quadratic_wedge, 15};
    default:
      return full ? Member{triquadratic_hexahedron, 27} : Member{quadratic_hexahedron, 20};
  }
}

/// The box (0,0,0)-(n,n,n): cubes, columns of wedges, cubes of pyramids with tetrahedra in place of
/// some.
CellMesh mixed_curved_mesh(Family family, std::uint64_t n, const Bend& bend, std::uint64_t seed) {
  CurvedMeshMaker maker(bend);
  std::mt19937_64 random(seed);
  const auto add = [&](const std::vector<Point>& corners) {
    const Member m = member(family, corners.size());
    maker.add(m.kind, m.node_count, corners);
  };
  for (std::uint64_t j = 0; j < n; ++j)
    for (std::uint64_t i = 0; i < n; ++i) {
      const bool wedges = random() % 3 == 0;
      for (std::uint64_t k = 0; k < n; ++k) {
        const double x = static_cast<double>(i), y = static_cast<double>(j), z = static_cast<double>(k);
        const std::vector<Point> h{{x, y, z},     {x + 1, y, z},     {x + 1, y + 1, z},     {x, y + 1, z},
                                   {x, y, z + 1}, {x + 1, y, z + 1}, {x + 1, y + 1, z + 1}, {x, y + 1, z + 1}};
        if (wedges) {
          add({h[0], h[1], h[2], h[4], h[5], h[6]});
          add({h[0], h[3], h[2], h[4], h[7], h[6]});
        } else if (random() % 2 == 0 && family != Family::lagrange_3) {
          const Point middle{x + 0.5, y + 0.5, z + 0.5};
          for (const Ids& f : hexahedron_faces({0, 1, 2, 3, 4, 5, 6, 7}))
            add({h[f[3]], h[f[2]], h[f[1]], h[f[0]], middle});
        } else {
          add(h);
        }
      }
    }
  shuffle_points(maker.mesh, seed + 7);
  return maker.mesh;
}

TEST(CurvedCells, of_different_kinds_agree_on_their_faces_however_finely_they_are_cut) {
  for (const Family family : {Family::serendipity, Family::full, Family::lagrange_3})
    for (const double error : {0.5, 0.02, 0.01}) {
      CellMesh mesh = mixed_curved_mesh(family, 2, bent(2, 0.3), 5);
      add_field(mesh, "wave", [](double x, double y, double z) { return std::sin(x) * std::cos(y) + z * z; });
      const std::size_t cell_count = mesh.kinds.size();
      const NeutralMesh tets = subdivide(std::move(mesh), {.max_error = error});
      EXPECT_TRUE(conforms_in_box(tets, {0, 0, 0}, {2, 2, 2})) << static_cast<int>(family) << " " << error;
      EXPECT_NEAR(mesh_volume(tets), 8, 1e-10);
      EXPECT_EQ(std::set(tets.cell_ids.begin(), tets.cell_ids.end()).size(), cell_count);
    }
}

TEST(CurvedCells, that_are_straight_and_hold_a_linear_field_are_not_cut_further) {
  for (const Family family : {Family::serendipity, Family::full, Family::lagrange_3}) {
    CellMesh mesh = mixed_curved_mesh(family, 2, straight, 3);
    const auto plane = [](double x, double y, double z) { return 3 + x - 2 * y + 5 * z; };
    add_field(mesh, "plane", plane);
    std::size_t expected = 0;  // 6 tetrahedra of a hexahedron, or 5
    for (const CellKind kind : mesh.kinds) {
      const bool is_hexahedron = kind == CellKind::quadratic_hexahedron || kind == CellKind::triquadratic_hexahedron ||
                                 kind == CellKind::lagrange_hexahedron;
      const bool is_pyramid = kind == CellKind::quadratic_pyramid || kind == CellKind::quadratic_pyramid_14;
      expected += is_hexahedron ? 6 : is_pyramid ? 2 : 3;
    }
    const NeutralMesh tets = subdivide(std::move(mesh), {.max_error = 1e-9});
    EXPECT_LE(tets.cells.size(), expected);
    EXPECT_GT(tets.cells.size(), expected * 4 / 5);
    for (std::size_t p = 0; p < tets.points.size(); ++p)
      EXPECT_NEAR(tets.point_fields[0].values[p], plane(tets.points[p][0], tets.points[p][1], tets.points[p][2]),
                  1e-12);
    std::set<std::uint64_t> used;
    for (const auto& cell : tets.cells) used.insert(cell.begin(), cell.end());
    EXPECT_EQ(used.size(), tets.points.size()) << "nodes that no tetrahedron needs are left out";
  }
}

TEST(CurvedCells, that_are_bent_reproduce_a_linear_field_of_their_places) {
  // The field follows the geometry, since both have the same shape functions.
  CellMesh mesh = mixed_curved_mesh(Family::full, 2, bent(2, 0.3), 3);
  const auto plane = [](double x, double y, double z) { return 3 + x - 2 * y + 5 * z; };
  add_field(mesh, "plane", plane);
  const NeutralMesh tets = subdivide(std::move(mesh), {.max_error = 0.01});
  for (std::size_t p = 0; p < tets.points.size(); ++p)
    EXPECT_NEAR(tets.point_fields[0].values[p], plane(tets.points[p][0], tets.points[p][1], tets.points[p][2]), 1e-12);
}

std::array<double, 4> barycentric(const NeutralMesh& mesh, const std::array<std::uint64_t, 4>& cell, const Point& at) {
  NeutralMesh with;
  for (const std::uint64_t v : cell) with.points.push_back(mesh.points[v]);
  with.points.push_back(at);
  const double whole = volume6(with, {0, 1, 2, 3});
  return {volume6(with, {4, 1, 2, 3}) / whole, volume6(with, {0, 4, 2, 3}) / whole, volume6(with, {0, 1, 4, 3}) / whole,
          volume6(with, {0, 1, 2, 4}) / whole};
}

/// Straight cells of one kind whose nodes carry random values: the field is as curved as it can be.
CellMesh cells_with_random_values(CellKind kind, std::size_t node_count, const std::vector<Point>& corners) {
  CurvedMeshMaker maker(straight);
  maker.add(kind, node_count, corners);
  std::mt19937_64 random(node_count);
  std::uniform_real_distribution<double> unit(0, 1);
  add_field(maker.mesh, "noise", [&](double, double, double) { return unit(random); });
  return maker.mesh;
}

struct FieldCase {
  CellKind kind;
  std::size_t node_count;
  std::vector<Point> corners;
};

std::vector<FieldCase> field_cases() {
  using enum CellKind;
  const std::vector<Point> tet{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<Point> hex{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const std::vector<Point> prism{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<Point> tent{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  return {{quadratic_tetrahedron, 10, tet},   {quadratic_tetrahedron_14, 14, tet},
          {lagrange_tetrahedron, 15, tet},    {lagrange_tetrahedron, 35, tet},
          {quadratic_hexahedron, 20, hex},    {biquadratic_quadratic_hexahedron, 24, hex},
          {triquadratic_hexahedron, 27, hex}, {quadratic_linear_wedge, 12, prism},
          {quadratic_wedge, 15, prism},       {biquadratic_quadratic_wedge, 18, prism},
          {lagrange_wedge, 21, prism},        {quadratic_pyramid, 13, tent},
          {quadratic_pyramid_14, 14, tent},   {triquadratic_pyramid, 19, tent}};
}

double range_of(const preprocess::NeutralField& field) {
  const auto [low, high] = std::minmax_element(field.values.begin(), field.values.end());
  return *high - *low;
}

TEST(CurvedCells, keep_the_promised_error_of_a_field_everywhere_inside) {
  for (const FieldCase& row : field_cases()) {
    SCOPED_TRACE(testing::Message() << static_cast<int>(row.kind) << ", " << row.node_count << " nodes");
    const CellMesh source = cells_with_random_values(row.kind, row.node_count, row.corners);
    const ShapeFunctions shape(row.kind, row.node_count);
    const double range = range_of(source.point_fields[0]);
    std::size_t before = 0;
    for (const double error : {0.4, 0.2}) {
      const NeutralMesh tets = subdivide(source, {.max_error = error});
      EXPECT_GT(tets.cells.size(), before);
      before = tets.cells.size();
      std::mt19937_64 random(9);
      std::uniform_real_distribution<double> unit(0, 1);
      std::vector<double> weights(row.node_count);
      double largest = 0;
      for (int i = 0; i < 200;) {
        const Point place{unit(random), unit(random), unit(random)};
        const auto cell = std::find_if(tets.cells.begin(), tets.cells.end(), [&](const auto& c) {
          const auto b = barycentric(tets, c, place);
          return *std::min_element(b.begin(), b.end()) >= -1e-12;
        });
        if (cell == tets.cells.end()) continue;  // outside the cell
        ++i;
        shape.at(place, weights);
        double curved = 0, flat = 0;
        for (std::size_t n = 0; n < row.node_count; ++n)
          curved += weights[n] * source.point_fields[0].values[source.cell_nodes[n]];
        const auto b = barycentric(tets, *cell, place);
        for (std::size_t v = 0; v < 4; ++v) flat += b[v] * tets.point_fields[0].values[(*cell)[v]];
        largest = std::max(largest, std::abs(curved - flat) / range);
      }
      EXPECT_LE(largest, error);
      EXPECT_GT(largest, error / 50) << "cut far more finely than asked for";
    }
  }
}

double squared(const Point& a) {
  return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

/// The distance from a point to a triangle, by a fine net of the triangle's points: so a little too
/// large.
double distance_to_triangle(const Point& p, const Point& a, const Point& b, const Point& c, int steps) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j) {
      const double u = static_cast<double>(i) / steps, v = static_cast<double>(j) / steps;
      Point d;
      for (std::size_t axis = 0; axis < 3; ++axis)
        d[axis] = (1 - u - v) * a[axis] + u * b[axis] + v * c[axis] - p[axis];
      best = std::min(best, squared(d));
    }
  return std::sqrt(best);
}

TEST(CurvedCells, keep_the_promised_error_of_their_shape) {
  // One hexahedron with a round top: points of its curved top against the triangles of the result's
  // surface.
  for (const auto& [kind, count] :
       {std::pair{CellKind::quadratic_hexahedron, 20U}, std::pair{CellKind::triquadratic_hexahedron, 27U},
        std::pair{CellKind::lagrange_hexahedron, 64U}}) {
    CurvedMeshMaker maker([](const Point& p) {
      return Point{p[0], p[1], p[2] * (1 + 2 * p[0] * (1 - p[0]) + p[1] * (1 - p[1]))};
    });
    maker.add(kind, count, field_cases()[4].corners);
    const CellMesh source = maker.mesh;
    const ShapeFunctions shape(kind, count);
    Point low = source.points[0], high = low;
    for (const Point& p : source.points)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    const double diagonal = std::sqrt(squared({high[0] - low[0], high[1] - low[1], high[2] - low[2]}));
    std::size_t before = 0;
    for (const double error : {0.04, 0.02}) {
      const NeutralMesh tets = subdivide(source, {.max_error = error});
      EXPECT_GT(tets.cells.size(), before);
      before = tets.cells.size();
      const FaceCensus census = census_of_faces(tets);
      std::vector<double> weights(count);
      double largest = 0;
      for (int i = 1; i < 6; ++i)
        for (int j = 1; j < 6; ++j) {
          shape.at({i / 6.0, j / 6.0, 1}, weights);
          Point p{};
          for (std::size_t n = 0; n < count; ++n)
            for (std::size_t axis = 0; axis < 3; ++axis)
              p[axis] += weights[n] * source.points[source.cell_nodes[n]][axis];
          double nearest = std::numeric_limits<double>::infinity();
          for (const auto& [a, b, c] : census.outer)
            nearest = std::min(nearest, distance_to_triangle(p, tets.points[a], tets.points[b], tets.points[c], 20));
          largest = std::max(largest, nearest / diagonal);
        }
      EXPECT_LE(largest, error) << count;
    }
  }
}

TEST(CurvedCells, use_their_own_nodes_as_points_where_they_are_cut) {
  CurvedMeshMaker maker([](const Point& p) { return Point{p[0], p[1] + 0.2 * p[0] * (1 - p[0]), p[2]}; });
  maker.add(CellKind::quadratic_tetrahedron, 10, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const CellMesh source = maker.mesh;
  const NeutralMesh tets = subdivide(source, {.max_error = 0.01});
  EXPECT_GT(tets.cells.size(), 1U);
  for (const std::size_t node : {4U, 5U, 8U})  // of the edges 0-1, 1-2 and 1-3
    EXPECT_EQ(std::count(tets.points.begin(), tets.points.end(), source.points[source.cell_nodes[node]]), 1) << node;
  for (std::size_t p = 0; p < tets.points.size(); ++p)
    for (std::size_t q = 0; q < p; ++q)
      EXPECT_GT(squared({tets.points[p][0] - tets.points[q][0], tets.points[p][1] - tets.points[q][1],
                         tets.points[p][2] - tets.points[q][2]}),
                1e-6)
          << "a node was made a second time";
}

TEST(CurvedCells, in_a_mesh_of_quadratic_tetrahedra_agree_and_report_their_error) {
  const NeutralMesh box = box_mesh({.cells = {3, 3, 3}, .box = {{0, 0, 0}, {3, 3, 3}}});
  CurvedMeshMaker maker(bent(3, 0.4));
  for (const auto& cell : box.cells) {
    std::vector<Point> corners;
    for (const std::uint64_t v : cell) corners.push_back(box.points[v]);
    maker.add(CellKind::quadratic_tetrahedron, 10, corners);
  }
  shuffle_points(maker.mesh, 2);
  add_field(maker.mesh, "pressure", [](double x, double y, double z) { return x * x + std::sin(3 * y) - z; });
  std::size_t before = 0;
  for (const double error : {0.02, 0.01}) {
    const NeutralMesh tets = subdivide(maker.mesh, {.max_error = error});
    EXPECT_TRUE(conforms_in_box(tets, {0, 0, 0}, {3, 3, 3}));
    EXPECT_NEAR(mesh_volume(tets), 27, 1e-10);
    EXPECT_GT(tets.cells.size(), before);
    before = tets.cells.size();
    EXPECT_THAT(tets.notes, Contains(testing::StartsWith("162 quadratic tetrahedra became ")));
    EXPECT_THAT(tets.notes,
                Contains(testing::AllOf(HasSubstr("largest geometric error 0.0"),
                                        HasSubstr("of field \"pressure\" 0.0"), testing::Not(HasSubstr("more than")))));
  }
}

TEST(CurvedCells, that_are_collapsed_agree_too) {
  // A quarter of a cylinder: quadratic hexahedra around the axis, their inner side collapsed onto
  // it.
  CellMesh mesh;
  const auto add_point = [&](double radius, double angle, double z) {
    mesh.points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    return mesh.points.size() - 1;
  };
  std::map<std::array<int, 3>, std::uint64_t> ids;  // by half steps of radius, angle, height
  const auto point = [&](int r, int a, int z) {
    if (r == 0) a = 0;
    const auto [found, is_new] = ids.try_emplace({r, a, z}, 0);
    if (is_new) found->second = add_point(r / 2.0, a * std::acos(0.0) / 4, z / 2.0);
    return found->second;
  };
  const ShapeFunctions shape(CellKind::quadratic_hexahedron, 20);
  for (int a = 0; a < 4; a += 2)
    for (int r = 0; r < 4; r += 2) {
      Ids nodes;
      for (const auto& place : shape.node_places())
        nodes.push_back(point(r + static_cast<int>(2 * place[0]), a + static_cast<int>(2 * place[1]),
                              static_cast<int>(2 * place[2])));
      add_cell(mesh, CellKind::quadratic_hexahedron, nodes);
    }
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    CellMesh shuffled = mesh;
    shuffle_points(shuffled, seed);
    const NeutralMesh tets = subdivide(std::move(shuffled), {.max_error = 0.01});
    const double pi = std::acos(-1.0);
    EXPECT_NEAR(mesh_volume(tets), pi, 0.1);
    EXPECT_TRUE(conforms(tets, [](const Point& a, const Point& b, const Point& c) {
      const auto all = [&](auto&& is) { return is(a) && is(b) && is(c); };
      return all([](const Point& p) { return p[2] == 0; }) || all([](const Point& p) { return p[2] == 1; }) ||
             all([](const Point& p) { return std::abs(p[0]) < 1e-12; }) ||
             all([](const Point& p) { return std::abs(p[1]) < 1e-12; }) ||
             all([](const Point& p) { return std::abs(std::hypot(p[0], p[1]) - 2) < 1e-2; });
    }));
  }
}

TEST(CurvedCells, say_when_the_error_asked_for_is_not_reached) {
  CellMesh mesh = cells_with_random_values(CellKind::quadratic_linear_wedge, 12, field_cases()[7].corners);
  // Along t the field is linear, across the triangles it is as wild as one edge allows.
  for (std::size_t n = 0; n < 12; ++n) mesh.point_fields[0].values[mesh.cell_nodes[n]] = n == 6 || n == 9 ? 1 : 0;
  EXPECT_THAT(subdivide(mesh, {.max_error = 0.05}).notes, testing::Not(Contains(HasSubstr("more than"))));
  EXPECT_THAT(subdivide(mesh, {.max_error = 1e-5, .finest = 0.25}).notes,
              Contains(HasSubstr("more than the 1e-05 requested")));
}

/// A straight quadratic tetrahedron with a linear, a curved and a far more curved field.
CellMesh tetrahedron_with_three_fields() {
  CurvedMeshMaker maker(straight);
  maker.add(CellKind::quadratic_tetrahedron, 10, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  add_field(maker.mesh, "flat", [](double x, double y, double z) { return x + y - z; });
  add_field(maker.mesh, "gentle", [](double x, double, double) { return x + 0.05 * x * x; });
  add_field(maker.mesh, "steep", [](double x, double, double) { return x * x; });
  return maker.mesh;
}

TEST(CurvedCells, are_cut_for_the_errors_of_the_fields_named_alone) {
  const CellMesh mesh = tetrahedron_with_three_fields();
  const auto count = [&](std::vector<std::string> names, double error = 0.005) {
    return subdivide(mesh, {.max_error = error, .fields = std::move(names)}).cells.size();
  };
  EXPECT_EQ(count({"flat"}), 1U);
  EXPECT_GT(count({"gentle"}), 1U);
  EXPECT_GT(count({"steep"}), count({"gentle"}));
  EXPECT_EQ(count({}), count({"steep", "flat"}));
  EXPECT_EQ(count({"steep.x"}), count({"steep"}));
  EXPECT_EQ(count({"steepest"}), 1U) << "only a dot ends a name";

  const NeutralMesh tets = subdivide(mesh, {.max_error = 0.005, .fields = {"gentle"}});
  ASSERT_EQ(tets.point_fields.size(), 3U);
  for (std::size_t p = 0; p < tets.points.size(); ++p)
    EXPECT_NEAR(tets.point_fields[2].values[p], tets.points[p][0] * tets.points[p][0], 1e-12)
        << "the others come along";
}

TEST(CurvedCells, say_what_they_were_cut_for) {
  const CellMesh mesh = tetrahedron_with_three_fields();
  const auto notes = [&](double error, std::vector<std::string> names = {}) {
    return subdivide(mesh, {.max_error = error, .fields = std::move(names)}).notes;
  };
  EXPECT_THAT(notes(0.005),
              Contains("1 curved cell cut finer than the corners require: 100 % of the cuts for field \"steep\""))
      << "wherever the gentle one strays too far, the steep one does more";
  EXPECT_THAT(notes(0.005, {"gentle"}), Contains(HasSubstr("100 % of the cuts for field \"gentle\"")));
  EXPECT_THAT(notes(0.005, {"gentle"}), testing::Not(Contains(HasSubstr("steep"))));
  EXPECT_THAT(notes(0.005, {"flat"}), testing::Not(Contains(HasSubstr("cut finer"))));

  CurvedMeshMaker maker([](const Point& p) { return Point{p[0], p[1] + 0.2 * p[0] * (1 - p[0]), p[2]}; });
  maker.add(CellKind::quadratic_tetrahedron, 10, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  EXPECT_THAT(subdivide(maker.mesh, {.max_error = 0.01}).notes,
              Contains("1 curved cell cut finer than the corners require: 100 % of the cuts for the shape"));
  // Along x the shape strays, along z a field.
  add_field(maker.mesh, "bowl", [](double, double, double z) { return z * z; });
  EXPECT_THAT(subdivide(maker.mesh, {.max_error = 0.01}).notes,
              Contains(testing::AllOf(HasSubstr("% of the cuts for field \"bowl\", "), HasSubstr(" % for the shape"))));
}

TEST(CurvedCells, pass_on_what_has_no_data_and_nothing_else) {
  CellMesh mesh = cells_with_random_values(CellKind::triquadratic_hexahedron, 27, field_cases()[6].corners);
  mesh.point_fields[0].values[mesh.cell_nodes[0]] = std::nan("");
  const NeutralMesh tets = subdivide(mesh, {.max_error = 0.05});
  std::size_t without = 0;
  for (std::size_t p = 0; p < tets.points.size(); ++p) {
    const bool has_data = !std::isnan(tets.point_fields[0].values[p]);
    const Point& at = tets.points[p];
    const bool is_on_far_side = at[0] == 1 || at[1] == 1 || at[2] == 1;
    EXPECT_TRUE(has_data || !is_on_far_side) << "node 0 does not count there";
    without += has_data ? 0 : 1;
  }
  EXPECT_GE(without, 1U);
}

TEST(CurvedCells, keep_single_precision_fields_in_single_precision) {
  CellMesh mesh = cells_with_random_values(CellKind::quadratic_hexahedron, 20, field_cases()[4].corners);
  for (double& value : mesh.point_fields[0].values) value = static_cast<double>(static_cast<float>(value));
  mesh.point_fields[0].was_single_precision = true;
  const NeutralMesh tets = subdivide(mesh, {.max_error = 0.02});
  EXPECT_GT(tets.points.size(), 20U);
  for (const double value : tets.point_fields[0].values)
    EXPECT_EQ(value, static_cast<double>(static_cast<float>(value)));
}

TEST(CurvedCells, of_order_one_are_linear_cells) {
  CurvedMeshMaker maker(straight);
  maker.add(CellKind::lagrange_hexahedron, 8, field_cases()[4].corners);
  const NeutralMesh tets = subdivide(maker.mesh);
  EXPECT_EQ(tets.cells.size(), 6U);
  EXPECT_THAT(tets.notes, testing::ElementsAre("1 Lagrange hexahedron became 6 tetrahedra"));
}

/// Found by fuzzing: one tetrahedron of a damaged file, with the middle of an edge at one of its
/// ends, was cut until memory was full.
TEST(CurvedCells, that_would_be_cut_without_end_are_refused) {
  CellMesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0.1, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
  add_cell(mesh, CellKind::quadratic_tetrahedron, {0, 1, 2, 3, 4, 1, 5, 6, 8, 7});
  expect_error(ErrorCode::resource, "points or tetrahedra for 1 curved cells", [&] { subdivide(mesh); });
}

TEST(CurvedCells, refuse_node_counts_with_the_cell) {
  CellMesh mesh;
  mesh.points.resize(30);
  mesh.cell_ids = {42};
  add_cell(mesh, CellKind::lagrange_hexahedron, Ids(28, 0));
  expect_error(ErrorCode::unsupported, "cell 42: found a Lagrange hexahedron of 28 nodes", [&] { subdivide(mesh); });
}

}  // namespace
}  // namespace rhoray::tests

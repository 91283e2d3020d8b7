#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "preprocess/subdivide.h"
#include "tests/preprocess/mesh/subdivide/cell_meshes.h"
#include "tests/support/conformity.h"
#include "tests/support/expect_error.h"

namespace rhoray::tests {
namespace {

using preprocess::NeutralMesh;
using preprocess::subdivide;
using testing::Contains;
using testing::HasSubstr;
using Point = std::array<double, 3>;

struct Shape {
  CellKind kind;
  std::vector<Point> corners;
  double volume;
  std::set<std::size_t> tet_counts;
};

std::vector<Shape> planar_shapes() {
  const std::vector<Point> pentagon{{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 2, 0}, {0, 1, 0}};             // area 4
  const std::vector<Point> hexagon{{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}, {-1, 1, 0}};  // area 6
  const auto prism = [](std::vector<Point> base) {
    const std::size_t n = base.size();
    for (std::size_t i = 0; i < n; ++i) base.push_back({base[i][0], base[i][1], 3});
    return base;
  };
  return {
      {CellKind::voxel,
       {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 3, 0}, {0, 0, 4}, {2, 0, 4}, {0, 3, 4}, {2, 3, 4}},
       24,
       {5, 6}},
      {CellKind::hexahedron,
       {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {1, 1, 3}, {3, 1, 3}, {3, 3, 3}, {1, 3, 3}},
       28,
       {5, 6}},
      {CellKind::wedge, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 0, 3}, {0, 2, 3}}, 3, {3}},
      {CellKind::wedge, {{0, 0, 0}, {0, 2, 0}, {1, 0, 0}, {0, 0, 3}, {0, 2, 3}, {1, 0, 3}}, 3, {3}},
      {CellKind::pyramid, {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {5, 1, 3}}, 4, {2}},
      {CellKind::pentagonal_prism, prism(pentagon), 12, {9}},
      {CellKind::hexagonal_prism, prism(hexagon), 18, {12}},
  };
}

CellMesh one_cell(CellKind kind, const std::vector<Point>& corners) {
  CellMesh mesh;
  mesh.points.assign(corners.begin(), corners.end());
  Ids ids(corners.size());
  std::iota(ids.begin(), ids.end(), 0);
  add_cell(mesh, kind, ids);
  return mesh;
}

bool all_are_positive(const NeutralMesh& mesh) {
  return std::all_of(mesh.cells.begin(), mesh.cells.end(), [&](const auto& cell) { return volume6(mesh, cell) > 0; });
}

TEST(LinearCells, are_cut_into_positive_tetrahedra_of_the_same_volume_whatever_their_ids) {
  for (const Shape& shape : planar_shapes()) {
    std::set<std::size_t> counts;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      CellMesh mesh = one_cell(shape.kind, shape.corners);
      shuffle_points(mesh, seed);
      const NeutralMesh tets = subdivide(std::move(mesh));
      SCOPED_TRACE(static_cast<int>(shape.kind));
      ASSERT_NEAR(mesh_volume(tets), shape.volume, 1e-12);
      ASSERT_TRUE(all_are_positive(tets));
      ASSERT_EQ(tets.points.size(), shape.corners.size()) << "no point is added to a convex cell";
      const FaceCensus census = census_of_faces(tets);
      ASSERT_EQ(census.crowded + census.one_side, 0U);
      counts.insert(tets.cells.size());
    }
    EXPECT_EQ(counts, shape.tet_counts) << static_cast<int>(shape.kind);
  }
}

TEST(LinearCells, of_every_kind_agree_on_their_faces) {
  std::set<CellKind> met;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    CellMesh mesh = MixedMesh(5, 0.2, seed).mesh;
    met.insert(mesh.kinds.begin(), mesh.kinds.end());
    const NeutralMesh tets = subdivide(std::move(mesh));
    EXPECT_TRUE(conforms_in_box(tets, {0, 0, 0}, {5, 5, 5})) << seed;
    EXPECT_NEAR(mesh_volume(tets), 125, 1e-10) << seed;
  }
  EXPECT_EQ(met.size(), 7U);
}

TEST(LinearCells, would_not_agree_if_a_diagonal_went_by_the_corner_order) {
  // The check itself: two cubes side by side whose common face is cut both ways.
  NeutralMesh tets;
  tets.points = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 0}};
  tets.cells = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 5}, {1, 3, 2, 5}};
  const auto nowhere = [](const Point& a, const Point& b, const Point& c) {
    return a[0] != 0 || b[0] != 0 || c[0] != 0;
  };
  EXPECT_FALSE(conforms(tets, nowhere));
  tets.cells = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 2, 1, 5}, {0, 3, 2, 5}};
  EXPECT_TRUE(conforms(tets, nowhere));
}

/// A quarter of a cylinder about z in three rings; the innermost hexahedra are collapsed onto the
/// axis.
CellMesh quarter_cylinder(bool axis_has_one_id) {
  CellMesh mesh;
  constexpr std::uint64_t around = 6, outward = 3, upward = 3;
  const auto point = [&](std::uint64_t a, std::uint64_t r, std::uint64_t z) {
    if (r == 0 && axis_has_one_id) a = 0;
    return (z * (outward + 1) + r) * (around + 1) + a;
  };
  for (std::uint64_t z = 0; z <= upward; ++z)
    for (std::uint64_t r = 0; r <= outward; ++r)
      for (std::uint64_t a = 0; a <= around; ++a) {
        // Straight rings: the volume is that of a polygon.
        const double t = static_cast<double>(a) / around, radius = static_cast<double>(r);
        mesh.points.push_back({radius * (1 - t), radius * t, static_cast<double>(z)});
      }
  for (std::uint64_t z = 0; z < upward; ++z)
    for (std::uint64_t r = 0; r < outward; ++r)
      for (std::uint64_t a = 0; a < around; ++a)
        add_cell(mesh, CellKind::hexahedron,
                 {point(a, r, z), point(a, r + 1, z), point(a + 1, r + 1, z), point(a + 1, r, z), point(a, r, z + 1),
                  point(a, r + 1, z + 1), point(a + 1, r + 1, z + 1), point(a + 1, r, z + 1)});
  return mesh;
}

TEST(LinearCells, that_are_collapsed_still_agree) {
  for (const bool one_id : {true, false})
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      CellMesh mesh = quarter_cylinder(one_id);
      shuffle_points(mesh, seed);
      const NeutralMesh tets = subdivide(std::move(mesh));
      EXPECT_NEAR(mesh_volume(tets), 3 * 4.5, 1e-12);
      const auto is_outside = [](const Point& a, const Point& b, const Point& c) {
        const auto all = [&](auto&& is) { return is(a) && is(b) && is(c); };
        return all([](const Point& p) { return p[2] == 0; }) || all([](const Point& p) { return p[2] == 3; }) ||
               all([](const Point& p) { return p[0] < 1e-12; }) || all([](const Point& p) { return p[1] < 1e-12; }) ||
               all([](const Point& p) { return std::abs(p[0] + p[1] - 3) < 1e-12; });
      };
      EXPECT_TRUE(conforms(tets, is_outside)) << one_id << " " << seed;
      for (const auto& cell : tets.cells) EXPECT_EQ(std::set(cell.begin(), cell.end()).size(), 4U);
    }
}

TEST(LinearCells, that_are_collapsed_to_a_wedge_a_pyramid_or_a_tetrahedron_have_its_volume) {
  const std::vector<Point> cube{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  struct Case {
    Ids corners;
    double volume;
  };
  for (const Case& row : std::vector<Case>{{{0, 1, 2, 2, 4, 5, 6, 6}, 1 / 2.0},
                                           {{0, 1, 2, 3, 4, 4, 4, 4}, 1 / 3.0},
                                           {{0, 1, 2, 2, 4, 4, 4, 4}, 1 / 6.0},
                                           {{0, 1, 2, 3, 0, 1, 2, 3}, 0}})
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      CellMesh mesh;
      mesh.points.assign(cube.begin(), cube.end());
      add_cell(mesh, CellKind::hexahedron, row.corners);
      shuffle_points(mesh, seed);
      const NeutralMesh tets = subdivide(std::move(mesh));
      EXPECT_NEAR(mesh_volume(tets), row.volume, 1e-14);
      EXPECT_EQ(tets.cells.empty(), row.volume == 0);
      if (row.volume == 0) {
        EXPECT_THAT(tets.notes, Contains(HasSubstr("1 cell of zero volume")));
      }
      for (const auto& cell : tets.cells) EXPECT_GT(volume6(tets, cell), 0);
    }
}

TEST(LinearCells, that_are_not_convex_get_a_point_inside_where_tetrahedra_would_overlap) {
  // A cube with one corner pushed in: from corner 0 not all faces are seen.
  const std::vector<Point> dented{{0.6, 0.3, 0.3}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1},       {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  CellMesh mesh = one_cell(CellKind::hexahedron, dented);
  add_field(mesh, "plane", [](double x, double y, double z) { return 1 + 2 * x - y + 3 * z; });
  int centered = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    CellMesh shuffled = mesh;
    shuffle_points(shuffled, seed);
    const NeutralMesh tets = subdivide(std::move(shuffled));
    ASSERT_TRUE(tets.notes.size() == 1 || tets.points.size() == 9);
    EXPECT_TRUE(std::all_of(tets.cells.begin(), tets.cells.end(),
                            [&](const auto& cell) { return volume6(tets, cell) > -1e-12; }));
    if (tets.points.size() != 9) continue;
    ++centered;
    EXPECT_THAT(tets.notes, Contains(HasSubstr("1 point added inside cells")));
    const Point& p = tets.points.back();
    EXPECT_NEAR(tets.point_fields[0].values.back(), 1 + 2 * p[0] - p[1] + 3 * p[2], 1e-12);
  }
  EXPECT_GT(centered, 20);
}

/// The prism over an outline in the plane z = 0, as a polyhedron.
CellMesh prism_over(const std::vector<Point>& outline, double height) {
  CellMesh mesh;
  const std::uint64_t n = outline.size();
  mesh.points.assign(outline.begin(), outline.end());
  for (const Point& p : outline) mesh.points.push_back({p[0], p[1], p[2] + height});
  std::vector<Ids> faces(2);
  for (std::uint64_t i = 0; i < n; ++i) {
    faces[0].insert(faces[0].begin(), i);
    faces[1].push_back(n + i);
    faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  add_polyhedron(mesh, faces);
  return mesh;
}

TEST(Polyhedra, are_seen_from_a_point_inside_that_is_not_the_mean_of_their_corners) {
  // A box with a long spike, whose many corners draw the mean into it.
  CellMesh mesh;
  mesh.points = {{0, 0, 0},  {10, 0, 0},  {10, 10, 0}, {0, 10, 0}, {0, 0, 1},
                 {10, 0, 1}, {10, 10, 1}, {0, 10, 1},  {5, 5, 0.9}};
  const std::vector<Ids> sides{{0, 3, 2, 1}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<Ids> faces = sides;
  for (const auto& [a, b] : {std::pair{4U, 5U}, std::pair{5U, 6U}, std::pair{6U, 7U}, std::pair{7U, 4U}})
    faces.push_back({a, b, 8});
  add_polyhedron(mesh, faces);
  const NeutralMesh tets = subdivide(std::move(mesh));
  EXPECT_NEAR(mesh_volume(tets), 100 - 100 * 0.1 / 3, 1e-10);
  EXPECT_TRUE(all_are_positive(tets));
}

TEST(Polyhedra, that_no_point_sees_whole_are_told_of) {
  // A U: its kernel is empty.
  CellMesh mesh =
      prism_over({{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}, 1);
  const NeutralMesh tets = subdivide(std::move(mesh));
  EXPECT_NEAR(mesh_volume(tets), 7, 1e-12) << "what overlaps counts twice and once against";
  EXPECT_THAT(tets.notes, Contains(HasSubstr("1 cell has no inner point that sees all faces")));
}

TEST(Polyhedra, equal_to_hexahedra_are_cut_like_them_on_their_faces) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    CellMesh hexahedron = one_cell(CellKind::hexahedron, planar_shapes()[1].corners);
    CellMesh polyhedron;
    polyhedron.points = hexahedron.points;
    add_polyhedron(polyhedron, hexahedron_faces({0, 1, 2, 3, 4, 5, 6, 7}));
    shuffle_points(hexahedron, seed);
    shuffle_points(polyhedron, seed);
    const NeutralMesh a = subdivide(std::move(hexahedron)), b = subdivide(std::move(polyhedron));
    EXPECT_EQ(census_of_faces(a).outer, census_of_faces(b).outer);
    EXPECT_NEAR(mesh_volume(b), 28, 1e-12);
  }
}

TEST(Polyhedra, that_are_open_or_cut_short_are_refused_with_the_cell) {
  const auto refused = [](std::vector<Ids> faces, Ids stream, const std::string& words) {
    CellMesh mesh;
    mesh.points.resize(8);
    mesh.cell_ids = {17};
    if (stream.empty())
      add_polyhedron(mesh, faces);
    else
      add_cell(mesh, CellKind::polyhedron, stream);
    expect_error(ErrorCode::invalid, "cell 17: found " + words, [&] { subdivide(std::move(mesh)); });
  };
  std::vector<Ids> faces = hexahedron_faces({0, 1, 2, 3, 4, 5, 6, 7});
  faces.pop_back();
  refused(faces, {}, "a polyhedron with 1 face at the edge");
  refused({}, {2, 3, 0, 1, 2}, "1 faces; expected 2");
  refused({}, {1, 5, 0, 1, 2}, "a face of 5 corners where 3 numbers are left");
  refused({}, {1, 2, 0, 1}, "a face of 2 corners");
  refused({}, {1, 3, 0, 1, 8}, "point 8; expected 0 to 7");
  refused({}, {1, 3, 0, 1, 2, 5}, "1 numbers after the last face");
  refused({}, {~std::uint64_t{0}, ~std::uint64_t{0}, 0}, "a face of 18446744073709551615 corners");
}

TEST(Subdivide, keeps_tetrahedra_as_they_are) {
  CellMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  add_cell(mesh, CellKind::tetrahedron, {0, 2, 1, 3});
  mesh.notes = {"a note"};
  const NeutralMesh tets = subdivide(mesh);
  EXPECT_EQ(tets.cells[0], (std::array<std::uint64_t, 4>{0, 2, 1, 3}));
  EXPECT_TRUE(tets.cell_ids.empty());
  EXPECT_THAT(tets.notes, testing::ElementsAre("a note"));
}

TEST(Subdivide, tells_where_each_tetrahedron_comes_from_and_repeats_cell_fields) {
  CellMesh mesh = MixedMesh(3, 0, 4).mesh;
  add_cell(mesh, CellKind::tetrahedron, {0, 1, 2, 3});
  preprocess::NeutralField field;
  field.name = "pair";
  field.component_count = 2;
  for (std::uint64_t c = 0; c < mesh.kinds.size(); ++c) {
    mesh.cell_ids.push_back(10 + 3 * c);
    field.values.push_back(static_cast<double>(c));
    field.values.push_back(-static_cast<double>(c));
  }
  mesh.cell_fields.push_back(field);
  const std::size_t cell_count = mesh.kinds.size();
  const NeutralMesh tets = subdivide(std::move(mesh));
  ASSERT_EQ(tets.cell_ids.size(), tets.cells.size());
  EXPECT_TRUE(std::is_sorted(tets.cell_ids.begin(), tets.cell_ids.end()));
  EXPECT_EQ(std::set(tets.cell_ids.begin(), tets.cell_ids.end()).size(), cell_count);
  for (std::size_t t = 0; t < tets.cells.size(); ++t) {
    EXPECT_EQ(tets.cell_fields[0].values[2 * t], static_cast<double>((tets.cell_ids[t] - 10) / 3));
    EXPECT_EQ(tets.cell_fields[0].values[2 * t + 1], -tets.cell_fields[0].values[2 * t]);
  }
}

TEST(Subdivide, counts_what_became_of_every_kind) {
  CellMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {3, 0, 0}};
  for (int i = 0; i < 1000; ++i) add_cell(mesh, CellKind::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
  add_cell(mesh, CellKind::pyramid, {1, 2, 6, 5, 8});
  const NeutralMesh tets = subdivide(std::move(mesh));
  EXPECT_THAT(tets.notes,
              testing::ElementsAre("1,000 hexahedra became 6,000 tetrahedra", "1 pyramid became 2 tetrahedra"));
}

TEST(Subdivide, refuses_nodes_that_are_not_there_and_errors_that_make_no_sense) {
  CellMesh mesh = one_cell(CellKind::wedge, planar_shapes()[2].corners);
  mesh.cell_nodes[4] = 6;
  expect_error(ErrorCode::invalid, "cell 0: found point 6; expected 0 to 5", [&] { subdivide(mesh); });
  CellMesh short_one;
  short_one.points.resize(8);
  add_cell(short_one, CellKind::hexahedron, {0, 1, 2, 3, 4, 5, 6});
  expect_error(ErrorCode::invalid, "cell 0: found 7 nodes; expected 8", [&] { subdivide(short_one); });
  for (const double error : {0.0, -1.0, std::nan("")})
    expect_error(ErrorCode::usage, "largest error", [&] { subdivide(short_one, {.max_error = error}); });
}

}  // namespace
}  // namespace rhoray::tests

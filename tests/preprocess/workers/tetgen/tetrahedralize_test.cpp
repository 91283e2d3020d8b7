#include "preprocess/tetrahedralize.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "formats/base/error.h"
#include "tests/preprocess/workers/tetgen/surfaces.h"
#include "tests/support/sanitizers.h"

namespace rhoray::tests {
namespace {

using preprocess::tetrahedralize;
using preprocess::TetrahedralizeOptions;
using testing::AllOf;
using testing::HasSubstr;

double total_volume(const NeutralMesh& mesh) {
  double sum = 0;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) sum += cell_volume(mesh, cell);
  return sum;
}

/// Volume by the number in cell field "region".
std::map<double, double> region_volumes(const NeutralMesh& mesh) {
  std::map<double, double> volumes;
  EXPECT_EQ(mesh.cell_fields.size(), 1u);
  EXPECT_EQ(mesh.cell_fields.at(0).name, "region");
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    volumes[mesh.cell_fields[0].values.at(cell)] += cell_volume(mesh, cell);
  return volumes;
}

struct Refusal {
  ErrorCode error_code;
  std::string text;
  std::string hint;
};

Refusal refusal_of(const NeutralSurface& surface, const TetrahedralizeOptions& options = {}) {
  try {
    const NeutralMesh mesh = tetrahedralize(surface, options);
    ADD_FAILURE() << "was filled with " << mesh.cells.size() << " tetrahedra";
  } catch (const Error& error) {
    return {error.code(), error.what(), error.hint()};
  }
  return {};
}

TEST(Tetrahedralize, fills_a_box_with_cells_in_positive_order_that_add_up_to_its_volume) {
  const NeutralMesh mesh = tetrahedralize(box({1, 2, 3}, {3, 5, 7}));
  EXPECT_NEAR(total_volume(mesh), 24, 24e-12);
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) EXPECT_GT(cell_volume(mesh, cell), 0) << cell;
  EXPECT_TRUE(mesh.cell_fields.empty()) << "one region without a seed needs no numbers";
}

TEST(Tetrahedralize, takes_facets_with_more_than_three_corners) {
  NeutralSurface cube;
  for (std::size_t i = 0; i < 8; ++i)
    cube.points.push_back({static_cast<double>(i & 1), static_cast<double>(i / 2 & 1), static_cast<double>(i / 4)});
  add_facet(cube, {0, 2, 3, 1});
  add_facet(cube, {4, 5, 7, 6});
  add_facet(cube, {0, 1, 5, 4});
  add_facet(cube, {2, 6, 7, 3});
  add_facet(cube, {0, 4, 6, 2});
  add_facet(cube, {1, 3, 7, 5});
  EXPECT_NEAR(total_volume(tetrahedralize(cube)), 1, 1e-12);
}

TEST(Tetrahedralize, keeps_every_cell_below_the_largest_volume) {
  const NeutralMesh mesh = tetrahedralize(box({0, 0, 0}, {1, 1, 1}), {.max_volume = 1e-3});
  EXPECT_NEAR(total_volume(mesh), 1, 1e-12);
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) EXPECT_LE(cell_volume(mesh, cell), 1e-3);
}

TEST(Tetrahedralize, numbers_nested_spheres_by_their_seeds) {
  NeutralSurface spheres;
  add_sphere(spheres, 10, 3);
  const std::size_t outer_count = spheres.facet_offsets.size() - 1;
  add_sphere(spheres, 4, 3);
  const double outer = enclosed_volume(spheres, 0, outer_count);
  const double inner = enclosed_volume(spheres, outer_count, spheres.facet_offsets.size() - 1);
  spheres.regions = {{.seed = {7, 0, 0}, .attribute = 12}, {.seed = {0, 0, 0}, .attribute = 5}};
  const auto volumes = region_volumes(tetrahedralize(spheres));
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_NEAR(volumes.at(12), outer - inner, 1e-12 * outer);
  EXPECT_NEAR(volumes.at(5), inner, 1e-12 * inner);
}

TEST(Tetrahedralize, numbers_regions_without_seeds_by_itself) {
  NeutralSurface spheres;
  add_sphere(spheres, 10, 2);
  add_sphere(spheres, 4, 2);
  EXPECT_EQ(region_volumes(tetrahedralize(spheres)).size(), 2u);
  EXPECT_TRUE(tetrahedralize(spheres, {.regions = false}).cell_fields.empty());
}

TEST(Tetrahedralize, limits_the_volume_in_one_region_only) {
  NeutralSurface boxes = box({0, 0, 0}, {3, 3, 3});
  add_box(boxes, {1, 1, 1}, {2, 2, 2});
  boxes.regions = {{.seed = {0.5, 0.5, 0.5}, .attribute = 1},
                   {.seed = {1.5, 1.5, 1.5}, .attribute = 2, .max_volume = 0.002}};
  const NeutralMesh mesh = tetrahedralize(boxes);
  double largest_outside = 0;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    if (mesh.cell_fields.at(0).values[cell] == 2)
      EXPECT_LE(cell_volume(mesh, cell), 0.002);
    else
      largest_outside = std::max(largest_outside, cell_volume(mesh, cell));
  }
  EXPECT_GT(largest_outside, 0.01);
}

TEST(Tetrahedralize, leaves_holes_empty) {
  NeutralSurface boxes = box({0, 0, 0}, {3, 3, 3});
  add_box(boxes, {1, 1, 1}, {2, 2, 2});
  boxes.holes = {{1.5, 1.5, 1.5}};
  EXPECT_NEAR(total_volume(tetrahedralize(boxes)), 26, 26e-12);
}

TEST(Tetrahedralize, keeps_an_opening_in_a_face_open) {
  // A box with a square tunnel: its top and bottom are faces of two rings, the inner one open.
  NeutralSurface tunnel;
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] :
         std::vector<std::pair<double, double>>{{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}})
      tunnel.points.push_back({x, y, z});
  std::uint64_t face = 0;
  for (const std::uint64_t level : {0u, 8u}) {
    add_facet(tunnel, {level, level + 1, level + 2, level + 3});
    add_facet(tunnel, {level + 4, level + 5, level + 6, level + 7});
    tunnel.facet_faces.insert(tunnel.facet_faces.end(), {face, face});
    tunnel.openings.push_back({.face = face++, .seed = {1.5, 1.5, level == 0 ? 0.0 : 1.0}});
  }
  for (const std::uint64_t ring : {0u, 4u})
    for (std::uint64_t i = 0; i < 4; ++i) {
      const std::uint64_t a = ring + i, b = ring + (i + 1) % 4;
      add_facet(tunnel, {a, b, b + 8, a + 8});
      tunnel.facet_faces.push_back(face++);
    }
  EXPECT_NEAR(total_volume(tetrahedralize(tunnel)), 8, 8e-12);
}

TEST(Tetrahedralize, grades_cells_by_the_sizes_wanted_at_points) {
  NeutralSurface bar;
  constexpr int steps = 40;
  // A bar along x, sampled along its edges, with wanted sizes from 0.05 to 0.5.
  for (int i = 0; i <= steps; ++i)
    for (const auto& [y, z] : std::vector<std::pair<double, double>>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      bar.points.push_back({0.1 * i, y, z});
      bar.point_sizes.push_back(0.05 + 0.45 * i / steps);
    }
  for (std::uint64_t i = 0; i < steps; ++i)
    for (std::uint64_t j = 0; j < 4; ++j) {
      const std::uint64_t a = 4 * i + j, b = 4 * i + (j + 1) % 4;
      add_facet(bar, {a, b, b + 4});
      add_facet(bar, {a, b + 4, a + 4});
    }
  for (const std::uint64_t end : {std::uint64_t{0}, std::uint64_t{4 * steps}}) {
    add_facet(bar, {end, end + 1, end + 2});
    add_facet(bar, {end, end + 2, end + 3});
  }
  const auto mean_volume_ratio = [](const NeutralMesh& mesh) {
    double left = 0, right = 0, left_count = 0, right_count = 0;
    for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
      double x = 0;
      for (const std::uint64_t corner : mesh.cells[cell]) x += mesh.points[corner][0] / 4;
      (x < 1 ? left : x > 3 ? right : x) += cell_volume(mesh, cell);
      (x < 1 ? left_count : x > 3 ? right_count : x) += 1;
    }
    return right / right_count / (left / left_count);
  };
  const NeutralMesh graded = tetrahedralize(bar), even = tetrahedralize(bar, {.use_point_sizes = false});
  EXPECT_NEAR(total_volume(graded), 4, 4e-12);
  EXPECT_GT(mean_volume_ratio(graded), 8);
  EXPECT_LT(mean_volume_ratio(even), 3);
  // Without quality, sizes alone still refine.
  EXPECT_GT(tetrahedralize(bar, {.quality = 0}).cells.size(),
            2 * tetrahedralize(bar, {.quality = 0, .use_point_sizes = false}).cells.size());
}

TEST(Tetrahedralize, merges_points_with_the_same_coordinates) {
  const NeutralSurface shared = box({0, 0, 0}, {1, 1, 1});
  NeutralSurface soup;
  for (const std::uint64_t corner : shared.facet_corners) {
    soup.facet_corners.push_back(soup.points.size());
    soup.points.push_back(shared.points[corner]);
  }
  soup.facet_offsets = shared.facet_offsets;
  const NeutralMesh mesh = tetrahedralize(soup);
  EXPECT_NEAR(total_volume(mesh), 1, 1e-12);
  EXPECT_THAT(mesh.notes, testing::Contains(HasSubstr("28 points")));
}

TEST(Tetrahedralize, says_where_a_surface_is_open) {
  NeutralSurface open = box({0, 0, 0}, {1, 1, 2});
  open.facet_corners.resize(33);  // without the last triangle: corners 1, 7, 5 of the side x = 1
  open.facet_offsets.pop_back();
  const Refusal refusal = refusal_of(open);
  EXPECT_EQ(refusal.error_code, ErrorCode::invalid);
  EXPECT_THAT(refusal.text, AllOf(HasSubstr("3 open edges"), HasSubstr("(1, 0, 0) to (1, 1, 2)")));
  EXPECT_THAT(refusal.hint, HasSubstr("close"));
}

TEST(Tetrahedralize, says_where_more_than_two_facets_meet) {
  NeutralSurface boxes = box({0, 0, 0}, {1, 1, 1});
  add_box(boxes, {1, 1, 0}, {2, 2, 1});  // touches the first along one edge
  const Refusal refusal = refusal_of(boxes);
  EXPECT_EQ(refusal.error_code, ErrorCode::invalid);
  EXPECT_THAT(refusal.text, AllOf(HasSubstr("1 edge where more than two"), HasSubstr("4 at (1, 1, 0) to (1, 1, 1)")));
}

TEST(Tetrahedralize, says_where_two_facets_cross) {
  NeutralSurface boxes = box({0, 0, 0}, {4, 4, 4});
  // A spike whose tip alone comes through the side x = 4, at y = 1, z = 2.5.
  const std::uint64_t b = boxes.points.size();
  boxes.points.insert(boxes.points.end(), {{3.5, 1, 2.5}, {6, 0.5, 2}, {6, 1.5, 2}, {6, 1, 3.2}});
  add_facet(boxes, {b, b + 1, b + 2});
  add_facet(boxes, {b, b + 2, b + 3});
  add_facet(boxes, {b, b + 3, b + 1});
  add_facet(boxes, {b + 1, b + 3, b + 2});
  const Refusal refusal = refusal_of(boxes);
  EXPECT_EQ(refusal.error_code, ErrorCode::invalid);
  EXPECT_THAT(refusal.text,
              AllOf(HasSubstr("3 pairs of facets intersect"), HasSubstr("and 12 at (4,"), HasSubstr("expected none")));
}

TEST(Tetrahedralize, sees_facets_folded_onto_their_neighbour) {
  // Triangle 0, 1, 4 lies in the plane of its neighbour 0, 1, 2, on the same side of their edge.
  NeutralSurface folded;
  folded.points = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {1, 1, 0}};
  add_facet(folded, {0, 2, 1});
  add_facet(folded, {0, 1, 4});
  add_facet(folded, {1, 3, 4});
  add_facet(folded, {3, 0, 4});
  add_facet(folded, {0, 3, 2});
  add_facet(folded, {3, 1, 2});
  add_facet(folded, {0, 1, 3});
  folded.regions = {{.seed = {1, 1, 1}, .attribute = 1}};  // walls are legal, crossings are not
  EXPECT_THAT(refusal_of(folded).text, AllOf(HasSubstr("pairs of facets intersect"), HasSubstr("facets 0 and 1 at")));
}

TEST(Tetrahedralize, says_which_facets_are_there_twice) {
  NeutralSurface twice = box({0, 0, 0}, {1, 1, 1});
  add_facet(twice, {3, 2, 0});
  EXPECT_THAT(refusal_of(twice).text, HasSubstr("1 duplicate facet"));
}

TEST(Tetrahedralize, refuses_input_on_which_tetgen_would_abort) {
  NeutralSurface flat = box({0, 0, 0}, {1, 1, 1});
  for (Point& p : flat.points) p[2] = p[0] + 2 * p[1];  // one slanted plane; sums are exact
  for (std::size_t i = 0; i < 4; ++i) flat.points[i + 4][0] += 8, flat.points[i + 4][2] += 8;
  EXPECT_THAT(refusal_of(flat).text, HasSubstr("lie in one plane"));

  NeutralSurface not_a_number = box({0, 0, 0}, {1, 1, 1});
  not_a_number.points[3][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal_of(not_a_number).text, AllOf(HasSubstr("1 point"), HasSubstr("point 3 is (1, nan, 0)")));

  NeutralSurface line = box({0, 0, 0}, {1, 1, 1});
  line.points.push_back({2, 0, 0});
  add_facet(line, {0, 1, 8});
  EXPECT_THAT(refusal_of(line).text, AllOf(HasSubstr("1 facet without area"), HasSubstr("facet 12 at (1, 0, 0)")));

  EXPECT_THAT(refusal_of({}).text, HasSubstr("0 points and 0 facets"));
}

TEST(Tetrahedralize, turns_a_crossing_that_tetgen_finds_into_a_sentence) {
  // Facets with four corners are left to TetGen: two boxes that overlap.
  NeutralSurface boxes;
  for (const double x : {0.0, 0.5}) {
    const std::uint64_t b = boxes.points.size();
    for (std::size_t i = 0; i < 8; ++i)
      boxes.points.push_back(
          {x + static_cast<double>(i & 1), x + static_cast<double>(i / 2 & 1), x + static_cast<double>(i / 4)});
    for (const auto& q : std::vector<std::array<std::uint64_t, 4>>{
             {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
      add_facet(boxes, {b + q[0], b + q[1], b + q[2], b + q[3]});
  }
  const Refusal refusal = refusal_of(boxes);
  EXPECT_EQ(refusal.error_code, ErrorCode::invalid);
  EXPECT_THAT(refusal.text, AllOf(HasSubstr("intersect"), HasSubstr("facet "), HasSubstr("around (")));
}

TEST(Tetrahedralize, refuses_what_encloses_nothing) {
  NeutralSurface open = box({0, 0, 0}, {1, 1, 1});
  open.facet_corners.resize(33);
  open.facet_offsets.pop_back();
  open.regions = {{.seed = {0.5, 0.5, 0.5}, .attribute = 1}};  // walls are legal: TetGen is asked
  EXPECT_THAT(refusal_of(open).text, HasSubstr("encloses nothing"));
}

TEST(Tetrahedralize, refuses_seeds_that_would_be_ignored) {
  NeutralSurface seeds = box({0, 0, 0}, {1, 1, 1});
  seeds.regions = {{.seed = {0.5, 0.5, 0.5}, .attribute = 1}, {.seed = {3, 3, 3}, .attribute = 2}};
  EXPECT_THAT(refusal_of(seeds).text, AllOf(HasSubstr("region 1, (3, 3, 3)"), HasSubstr("outside of every region")));
  seeds.regions[1].seed = {0.25, 0.25, 0.75};
  EXPECT_THAT(refusal_of(seeds).text, HasSubstr("has a seed already"));
  seeds.regions.clear();
  seeds.holes = {{5, 5, 5}};
  EXPECT_THAT(refusal_of(seeds).text, HasSubstr("the seed of hole 0, (5, 5, 5)"));
}

TEST(Tetrahedralize, refuses_requests_without_sense) {
  const NeutralSurface cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(refusal_of(cube, {.quality = 0.5}).error_code, ErrorCode::usage);
  EXPECT_EQ(refusal_of(cube, {.max_volume = -1}).error_code, ErrorCode::usage);
}

TEST(Tetrahedralize, stops_at_the_limits_of_time_and_memory) {
  const NeutralSurface cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(refusal_of(cube, {.max_volume = 1e-8, .time_limit_s = 1}).error_code, ErrorCode::resource);
  if (!sanitized) {
    EXPECT_EQ(refusal_of(cube, {.max_volume = 1e-8, .memory_limit_bytes = std::uint64_t{96} << 20}).error_code,
              ErrorCode::resource);
  }
}

}  // namespace
}  // namespace rhoray::tests

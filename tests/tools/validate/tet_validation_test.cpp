#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "tests/tools/validate/support.h"
#include "tools/validate/exact_tets.h"
#include "tools/validate/tet_surface.h"
#include "tools/validate/triangle_tree.h"

namespace rhoray::tests {
namespace {

/// A ball in an uneven mesh.
const ValidatedFile& ball() {
  static const ValidatedFile file(
      box_mesh({.cells = {10, 10, 10}, .jitter = 0.15, .grading = 2}, distance_field({0.5, 0.5, 0.5})));
  return file;
}
const validate::RayQuery query{.isovalue = 0.3, .samples = 10'000};

double cell_edge() {
  return 0.1;
}

TEST(TetValidation, finds_nothing_wrong_with_the_renderer) {
  const validate::Report report = ball().report(query);
  EXPECT_TRUE(report.holds()) << json_of(report).dump(1);
  const validate::RayCounts all = report.total();
  EXPECT_GT(all.hits, 8'000U);
  EXPECT_LT(all.hits, all.rays);
  EXPECT_GT(all.redecided, 100U) << "are rays still aimed at what cells share?";
  EXPECT_LT(all.grazes, all.rays / 100);
  EXPECT_LT(report.largest("depth", "box"), 1e-12);
}

TEST(TetValidation, catches_a_renderer_that_drops_hits) {
  const auto tracer = dropping_one_hit_in_a_thousand(ball().renderer(query.isovalue));
  const validate::Report report = ball().report(query, tracer);
  expect_caught("hits_dropped", report);
  EXPECT_GE(found(report, "missed"), 8);
  EXPECT_LE(found(report, "missed"), static_cast<double>(report.total().hits) / 1000);
}

TEST(TetValidation, catches_a_renderer_whose_hits_lie_a_thousandth_of_a_cell_too_far) {
  const auto tracer = shifting_hits(ball().renderer(query.isovalue), 1e-3 * cell_edge());
  const validate::Report report = ball().report(query, tracer);
  expect_caught("hits_shifted", report);
  EXPECT_EQ(found(report, "elsewhere"), static_cast<double>(report.total().hits));
  EXPECT_NEAR(quantiles(report, "depth", "box").p99, 1e-4 / std::sqrt(3), 1e-9);
}

TEST(TetValidation, holds_a_proving_method_against_the_bounds_that_it_states) {
  const render::Method certified{.algorithm = render::Method::Algorithm::certified};
  const validate::Report honest = ball().report(query, ball().renderer(query.isovalue, certified));
  EXPECT_TRUE(honest.holds());
  EXPECT_GT(honest.largest("bound stated by the method", "box"), 0);
  EXPECT_GT(honest.largest("bound, surface to renderer", "box"), 0);
  // For all methods, the renderer's own errors are far below the limits. These are not, and no
  // bound covers them.
  const validate::Report boastful = ball().report(
      query, understating_bounds(shifting_hits(ball().renderer(query.isovalue, certified), 1e-4 * cell_edge())));
  expect_caught("bounds_said_to_be_0", boastful);
  EXPECT_GT(found(boastful, "elsewhere"), 0);
}

TEST(TetValidation, catches_a_renderer_that_reports_the_second_hit) {
  const auto tracer = reporting_the_second_hit(ball().renderer(query.isovalue), 1e-6);
  const validate::Report report = ball().report(query, tracer);
  expect_caught("second_hit", report);
  EXPECT_GT(found(report, "elsewhere") + found(report, "missed"), 50);
}

TEST(TetValidation, catches_hits_where_there_is_nothing_and_normals_that_are_wrong) {
  const validate::Report invented = ball().report(query, inventing_hits(ball().renderer(query.isovalue), 1));
  expect_caught("hits_invented", invented);
  EXPECT_GT(found(invented, "false"), 5);
  const validate::Report turned = ball().report(query, turning_normals(ball().renderer(query.isovalue)));
  EXPECT_GT(found(turned, "largest normal error, degrees"), 1);
  expect_caught("normals_turned", turned);
  expect_caught("normals_lost", ball().report(query, losing_normals(ball().renderer(query.isovalue))));
}

TEST(TetValidation, knows_which_tetrahedron_was_hit_where_several_have_one_id) {
  preprocess::NeutralMesh mesh =
      box_mesh({.cells = {6, 6, 6}, .jitter = 0.15, .grading = 2}, distance_field({0.5, 0.5, 0.5}));
  mesh.cell_ids.resize(mesh.cells.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) mesh.cell_ids[c] = c / 6;
  const ValidatedFile file(mesh);
  const validate::Report report = file.report({.isovalue = 0.3, .samples = 2'000});
  EXPECT_TRUE(report.holds()) << json_of(report).dump(1);
  EXPECT_GT(quantiles(report, "normal", "degrees").count, 1'000U);
}

TEST(TetValidation, sends_the_same_rays_for_the_same_seed) {
  EXPECT_EQ(json_of(ball().report(query)).dump(), json_of(ball().report(query)).dump());
  validate::RayQuery other = query;
  other.seed = 2;
  EXPECT_NE(json_of(ball().report(query)).dump(), json_of(ball().report(other)).dump());
}

TEST(TetValidation, measures_every_pixel_of_a_picture) {
  validate::RayQuery with_picture = query;
  with_picture.samples = 100;
  with_picture.camera_rays = render::camera_rays(
      ball().dataset(), render::fit_camera(ball().dataset().bounds(), render::named_view("iso"), 1), 32, 32);
  const validate::Shots picture = ball().compare(with_picture, ball().renderer(query.isovalue)).picture;
  ASSERT_EQ(picture.findings.size(), 1024U);
  std::size_t hits = 0;
  for (std::size_t pixel = 0; pixel < picture.findings.size(); ++pixel) {
    hits += !picture.hits[pixel].is_miss();
    EXPECT_EQ(picture.hits[pixel].is_miss(), std::isnan(picture.findings[pixel].distance_cells));
  }
  EXPECT_GT(hits, 60U);
}

TEST(TetValidation, of_a_surface_that_is_not_there_expects_only_misses) {
  validate::RayQuery beyond = query;
  beyond.isovalue = 100;
  const validate::Report report = ball().report(beyond);
  EXPECT_EQ(report.triangles, 0U);
  EXPECT_EQ(report.total().hits, 0U);
  EXPECT_EQ(found(report, "missed"), 0);
}

TEST(TetSurface, of_a_linear_field_is_the_plane) {
  const ValidatedFile file(box_mesh({.cells = {3, 4, 5}, .jitter = 0.1}, linear_field({0, 0, 1})));
  const auto surface = extract_surface(file.tets(), 0.3);
  double area = 0;
  for (std::size_t t = 0; t < surface.triangles.corners.size(); ++t) {
    area += surface.triangles.normal(t).length() / 2;
    EXPECT_NEAR(surface.triangles.center(t).z, 0.3, 1e-15);
  }
  EXPECT_NEAR(area, 1, 1e-14);
}

TEST(TetSurface, of_a_ball_is_closed) {
  const auto surface = extract_surface(ball().tets(), 0.3);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& corners : surface.triangles.corners)
    for (std::size_t c = 0; c < 3; ++c) ++edges[std::minmax(corners[c], corners[(c + 1) % 3])];
  ASSERT_GT(edges.size(), 1000U);
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 2);
}

TEST(ExactTets, knows_where_a_plane_is_also_along_edges_and_through_vertices) {
  const ValidatedFile file(box_mesh({.cells = {4, 4, 4}}, linear_field({0, 0, 1})));
  const validate::TetField field = file.tets();
  const double iso = 0.375;  // half-way through a layer of cells
  const auto surface = extract_surface(field, iso);
  const validate::ExactTets judge(field, surface.straddling, iso);
  for (const double x : {0.0, 0.25, 0.3, 0.5, 1.0})
    for (const double y : {0.0, 0.25, 0.7, 1.0}) {
      const auto crossing = judge.first_crossing({{x, y, -1}, {0, 0, 2}});
      ASSERT_TRUE(crossing) << x << " " << y;
      EXPECT_NEAR(crossing->t, 0.6875, 1e-13) << x << " " << y;
      EXPECT_EQ(judge.crossing_in({{x, y, -1}, {0, 0, 2}}, crossing->cell), crossing->t);
    }
  EXPECT_FALSE(judge.first_crossing({{0.5, 0.5, -1}, {0, 0, -1}})) << "looks away";
  EXPECT_FALSE(judge.first_crossing({{0.5, 0.5, 0.5}, {0, 0, 1}})) << "starts beyond";
  EXPECT_FALSE(judge.first_crossing({{-1, 0.5, iso}, {1, 0, 0}})) << "inside from where it comes in";
}

TEST(ExactTets, counts_a_point_that_is_met_from_below_and_none_met_from_above) {
  // A ridge: 1/2 - |z - 1/2|, with its crest of 1/2 at z = 1/2.
  const ValidatedFile file(box_mesh({.cells = {2, 2, 2}}, [](const Vec3& p) { return 0.5 - std::abs(p.z - 0.5); }));
  const validate::TetField field = file.tets();
  const auto crossing_at = [&](double iso, const render::Ray& ray) {
    const auto surface = extract_surface(field, iso);
    return validate::ExactTets(field, surface.straddling, iso).first_crossing(ray);
  };
  const render::Ray up{{0.3, 0.4, -1}, {0, 0, 1}};
  ASSERT_TRUE(crossing_at(0.5, up));
  EXPECT_NEAR(crossing_at(0.5, up)->t, 1.5, 2e-13);
  EXPECT_FALSE(crossing_at(0.75, up));
  EXPECT_NEAR(crossing_at(0.25, up)->t, 1.25, 2e-13);
}

TEST(ExactTets, sees_the_surface_that_a_cell_without_volume_carries) {
  // A flat cell on top of another. At the corners of its square the field is 0 and 1 alternately.
  // The square is therefore cut along one diagonal seen from above, and along the other from below.
  preprocess::NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, -1}};
  mesh.cells = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  preprocess::NeutralField values;
  values.name = "value";
  values.values = {0, 1, 0, 1, 0};
  mesh.point_fields.push_back(values);
  const ValidatedFile file(mesh);
  const validate::TetField field = file.tets();
  const auto surface = extract_surface(field, 0.5);
  ASSERT_EQ(surface.straddling.size(), 2U);
  const validate::ExactTets judge(field, surface.straddling, 0.5);
  // Over the half of the square without a cell below, there is only the flat cell.
  const auto crossing = judge.first_crossing({{0.375, 0.5, 3}, {0, 0, -1}});
  ASSERT_TRUE(crossing);
  EXPECT_EQ(formats::TetMesh(file.dataset().file()).cell_id(crossing->cell), 0U);
  EXPECT_NEAR(crossing->t, 3, 1e-12);
  EXPECT_FALSE(judge.first_crossing({{0.0625, 0.125, 3}, {0, 0, -1}})) << "both sides lie below there";
}

TEST(TriangleTree, finds_the_first_triangle_and_the_nearest_point) {
  validate::Triangles triangles;
  triangles.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}, {1, 0, 2}, {0, 1, 2}};
  triangles.corners = {{0, 1, 2}, {3, 4, 5}, {0, 1, 1}};
  const validate::TriangleTree tree(triangles);
  const auto met = tree.first_on({{0.2, 0.2, 5}, {0, 0, -2}});
  ASSERT_TRUE(met);
  EXPECT_EQ(met->triangle, 1U);
  EXPECT_DOUBLE_EQ(met->t, 1.5);
  EXPECT_FALSE(tree.first_on({{2, 2, 5}, {0, 0, -1}}));
  EXPECT_EQ(tree.nearest({0.25, 0.25, 0.5}), Vec3(0.25, 0.25, 0));
}

}  // namespace
}  // namespace rhoray::tests

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/support/made_grid.h"
#include "tests/tools/validate/support.h"
#include "tools/validate/grid_reference.h"
#include "tools/validate/grid_surface.h"

namespace rhoray::tests {
namespace {

/// The signal of Marschner and Lobb in 24^3 samples.
const ValidatedFile& waves() {
  static const Index3 count(24, 24, 24);
  static const ValidatedFile file(
      sampled_volume<float>(count, lattice_over({{-1, -1, -1}, {1, 1, 1}}, count), marschner_lobb_field()));
  return file;
}
const validate::RayQuery query{.isovalue = 0.5, .samples = 2'000};

double cell_edge() {
  return 2.0 / 23;
}

TEST(GridValidation, finds_nothing_wrong_with_the_renderer) {
  const validate::Report report = waves().report(query);
  EXPECT_TRUE(report.holds()) << json_of(report).dump(1);
  const validate::RayCounts all = report.total();
  EXPECT_GT(all.hits, 1'500U);
  EXPECT_LT(all.undecided, all.rays / 20);
  EXPECT_LT(report.largest("depth", "cells"), 1e-10);
  EXPECT_LT(report.largest("renderer to surface", "cells"), 1e-10);
  EXPECT_LT(report.largest("surface to renderer", "cells"), 1e-10);
  EXPECT_LT(report.largest("renderer to mesh", "cells"), 1);
  EXPECT_GT(report.measures.front().quantiles.count, 1'000U);
}

TEST(GridValidation, catches_a_renderer_that_drops_hits) {
  const auto tracer = dropping_one_hit_in_a_thousand(waves().renderer(query.isovalue));
  const validate::Report report = waves().report(query, tracer);
  expect_caught("hits_dropped", report);
  EXPECT_GE(found(report, "missed"), 1);
}

TEST(GridValidation, catches_a_renderer_whose_hits_lie_a_thousandth_of_a_cell_too_far) {
  const auto tracer = shifting_hits(waves().renderer(query.isovalue), 1e-3 * cell_edge());
  const validate::Report report = waves().report(query, tracer);
  expect_caught("hits_shifted", report);
  EXPECT_GT(found(report, "elsewhere"), 0.99 * static_cast<double>(report.total().hits));
  EXPECT_GT(report.largest("depth", "cells"), 0.9e-3);
  EXPECT_GT(found(report, "renderer to surface, cells"), 0.9e-3);
  EXPECT_LE(found(report, "renderer to surface, cells"), 1.001e-3);
  EXPECT_NEAR(found(report, "surface to renderer, cells"), 1e-3 * cell_edge(), 1e-9) << "shifted in the grid's frame";
}

TEST(GridValidation, holds_a_proving_method_against_the_bounds_that_it_states) {
  const render::Method certified{.algorithm = render::Method::Algorithm::certified};
  const validate::Report honest = waves().report(query, waves().renderer(query.isovalue, certified));
  EXPECT_TRUE(honest.holds());
  EXPECT_GT(honest.largest("bound stated by the method", "cells"), 0);
  EXPECT_GT(honest.largest("bound, surface to renderer", "cells"), 0);
  const validate::Report boastful =
      waves().report(query, understating_bounds(waves().renderer(query.isovalue, certified)));
  expect_caught("bounds_said_to_be_0", boastful);
  EXPECT_GT(found(boastful, "elsewhere"), 0);
}

TEST(GridValidation, measures_the_distance_from_the_surface_also_where_a_ray_grazes_it) {
  // Where rays run down the wave's flanks at a small angle, depth is not distance.
  const auto tracer = shifting_hits(waves().renderer(query.isovalue), 1e-3 * cell_edge());
  const validate::Report report = waves().report(query, tracer);
  const validate::Quantiles distance = quantiles(report, "renderer to surface", "cells");
  const validate::Quantiles depth = quantiles(report, "depth", "cells");
  EXPECT_LT(distance.p50, 0.95 * depth.p50);
  EXPECT_GE(distance.count, depth.count);
}

TEST(GridValidation, catches_a_renderer_that_reports_the_second_hit) {
  const auto tracer = reporting_the_second_hit(waves().renderer(query.isovalue), 1e-6 * cell_edge());
  const validate::Report report = waves().report(query, tracer);
  expect_caught("second_hit", report);
  EXPECT_GT(found(report, "elsewhere") + found(report, "missed"), 10);
}

TEST(GridValidation, catches_hits_where_there_is_nothing_and_normals_that_are_wrong) {
  const validate::Report invented = waves().report(query, inventing_hits(waves().renderer(query.isovalue), 3));
  expect_caught("hits_invented", invented);
  EXPECT_GT(found(invented, "false"), 3);
  const validate::Report turned = waves().report(query, turning_normals(waves().renderer(query.isovalue)));
  EXPECT_GT(found(turned, "largest normal error, degrees"), 1);
  expect_caught("normals_turned", turned);
  expect_caught("normals_lost", waves().report(query, losing_normals(waves().renderer(query.isovalue))));
}

TEST(GridValidation, takes_uneven_axes_gaps_in_the_data_and_turned_grids) {
  const auto bump = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (i >= 8 && j < 4) return std::numeric_limits<float>::quiet_NaN();
    const auto square = [](std::int64_t n, double middle) { return std::pow(static_cast<double>(n) - middle, 2); };
    return static_cast<float>(std::sqrt(square(i, 5.2) + square(j, 5.1) + square(k, 4.9)));
  };
  MadeGridChoice choice{.sample_count = {12, 11, 10}, .brick_edge = 4, .is_sparse = true};
  choice.axes[0] = {0, 1, 1.5, 3, 3.25, 4, 6, 7, 8, 8.5, 9, 12};
  MadeGrid made = made_grid(choice, {{"bump", bump}});
  made.description.world_from_grid = {{0, 2, 0}, {-3, 0, 0}, {0, 0.5, 1}, {100, 200, -50}};
  const TemporaryFolder folder;
  write_file(folder / "bump.rho", made.file());
  const render::Dataset dataset = render::Dataset::load(folder / "bump.rho");
  const validate::GridField field(formats::BrickGrid(dataset.file()), "bump");
  const auto tracer = [&](std::span<const render::Ray> rays, std::span<render::Hit> hits) {
    render::RayCaster(dataset, 3, {}).first_crossings(rays, hits);
  };
  const validate::RayQuery about{.isovalue = 3, .samples = 2'000};
  const auto compare = [&](const validate::Tracer& by) {
    return validate::compare_grid(field, render::world_from_ray_frame(dataset), about, by, [](std::uint64_t) {}).report;
  };
  const validate::Report report = compare(tracer);
  EXPECT_TRUE(report.holds()) << json_of(report).dump(1);
  EXPECT_GT(report.total().hits, 1'000U);
  expect_caught("hits_dropped", compare(dropping_one_hit_in_a_thousand(tracer)));
}

/// Here the mesher fails: all points from which it starts lie in one plane.
TEST(GridValidation, does_without_the_mesh_where_the_mesher_fails) {
  const ValidatedFile file(sampled_volume<std::int16_t>({9, 6, 5}, Affine{}, [](const Vec3& p) { return 10 * p.x; }));
  const validate::Report report = file.report({.isovalue = 30, .samples = 2'000});
  EXPECT_TRUE(report.holds()) << json_of(report).dump(1);
  EXPECT_GT(report.total().hits, 500U);
  EXPECT_THAT(report.notes, testing::Contains(testing::HasSubstr("CGAL found an error of its own")));
  // Without triangles no ray starts beside the surface.
  const Json json = json_of(report);
  for (const Json& check : json.at("checks")) {
    const bool is_measured = check.at("check") != "surface to renderer, cells";
    EXPECT_EQ(check.at("found").is_null(), !is_measured) << check;
    EXPECT_EQ(check.at("holds"), is_measured ? Json(true) : Json()) << check;
  }
  EXPECT_TRUE(json.at("hausdorff").at(1).at("cells").is_null());
}

TEST(GridReference, decides_where_rounding_cannot) {
  const Index3 count(5, 5, 5);
  const ValidatedFile file(sampled_volume<double>(count, Affine{}, linear_field({1, 0, 0})));
  const validate::GridField field = file.grid();
  const validate::GridReference judge(field, 1.5);
  const render::Ray ray{{-1, 0.3, 0.7}, {1, 0, 0}};
  EXPECT_EQ(judge.is_inside(ray, 2.5), true) << "at the isovalue is inside";
  EXPECT_EQ(judge.is_inside(ray, std::nextafter(2.5, 0)), false);
  EXPECT_FALSE(judge.is_clearly_inside(ray, 2.5));
  EXPECT_FALSE(judge.is_inside(ray, 0.5)) << "outside the grid";
  EXPECT_NEAR(judge.crossing_near(ray, 2.4, 1e-15, 0.5).value(), 2.5, 1e-14);
  EXPECT_FALSE(judge.crossing_near(ray, 1.4, 1e-15, 0.5));
  EXPECT_NEAR(judge.first_proved(ray, 0, 10, 0.25).value(), 2.5, 1e-14);
  EXPECT_FALSE(judge.first_proved(ray, 0, 2.4, 0.25));
}

TEST(GridReference, knows_the_cubic_along_a_ray) {
  // x y z along (s, s, s) is s^3: 1/8 at 1/2.
  const Index3 count(3, 3, 3);
  const ValidatedFile file(sampled_volume<double>(count, Affine{}, product_field()));
  const validate::GridField field = file.grid();
  const validate::GridReference judge(field, 0.125);
  const auto t = judge.first_proved({{-1, -1, -1}, {1, 1, 1}}, 0, 10, 0.1);
  ASSERT_TRUE(t);
  EXPECT_NEAR(*t, 1.5, 1e-14);
}

TEST(GridSurface, shows_every_ball_and_lies_where_it_says) {
  // Two balls of radius 3 and 5, apart.
  const Index3 count(40, 20, 20);
  const Field balls = [](const Vec3& p) {
    return std::min((p - Vec3(9.3, 9.6, 9.4)).length() - 5, (p - Vec3(28.2, 9.1, 9.7)).length() - 3);
  };
  const ValidatedFile file(sampled_volume<double>(count, Affine{}, balls));
  const validate::GridField field = file.grid();
  const auto points = validate::edge_points(field, 0, 10'000, 1);
  EXPECT_EQ(points.edge_count, points.points_index.size());
  for (const Vec3& p : points.points_index) EXPECT_NEAR(field.value(p).value(), 0, 1e-14);
  const validate::GridSurface surface = validate::mesh_surface(field, 0, points, {.facet_count = 4'000});
  EXPECT_EQ(surface.stopped_because, "");
  double small = 0, large = 0;
  for (std::size_t t = 0; t < surface.triangles.corners.size(); ++t) {
    (surface.triangles.center(t).x < 19 ? large : small) += surface.triangles.normal(t).length() / 2;
    EXPECT_LT(surface.offsets[t], 0.1);
  }
  EXPECT_NEAR(large, 4 * std::numbers::pi * 25, 10);
  EXPECT_NEAR(small, 4 * std::numbers::pi * 9, 6);
  for (const Vec3& p : surface.triangles.points) EXPECT_NEAR(field.value(p).value(), 0, 1e-6);
}

TEST(GridSurface, stops_when_it_costs_too_much_and_says_so) {
  const validate::GridField field = waves().grid();
  const auto points = validate::edge_points(field, 0.5, 10'000, 1);
  const auto surface = validate::mesh_surface(field, 0.5, points, {.facet_count = 4'000, .most_evaluations = 100'000});
  EXPECT_THAT(surface.stopped_because, testing::HasSubstr("as often as it may"));
  EXPECT_EQ(surface.offsets.size(), surface.triangles.corners.size());
}

}  // namespace
}  // namespace rhoray::tests

#include "preprocess/grid/resample/certify.h"

#include <gtest/gtest.h>

#include <random>

#include "preprocess/grid/resample/locate.h"
#include "tests/preprocess/grid/resample/support.h"

namespace rhoray::preprocess {
namespace {

/// The largest difference by brick, found by brute force.
std::vector<double> largest_differences(const Sampled& sampled, int order) {
  std::vector<double> largest(sampled.touched.bricks.size(), 0.0);
  sampled.for_each_difference(order, [&](const Index3& leaf, double difference) {
    double& of_brick = largest[sampled.touched.slot({leaf.x / 8, leaf.y / 8, leaf.z / 8})];
    of_brick = std::max(of_brick, difference);
  });
  return largest;
}

/// Expects that the certificate is not exceeded by what was found, and not far above it.
void expect_bound(const Sampled& sampled, int order, double gap) {
  const FieldErrors& errors = sampled.certificates.fields[0];
  const std::vector<double> found = largest_differences(sampled, order);
  ASSERT_EQ(errors.max.size(), found.size());
  double largest = 0;
  for (std::size_t slot = 0; slot < found.size(); ++slot) {
    EXPECT_LE(found[slot], errors.max[slot] * (1 + 1e-12) + 1e-14) << slot;
    EXPECT_GE(std::max(found[slot] * gap, errors.attained * 1.051), errors.max[slot] - 1e-5) << slot;
    largest = std::max(largest, found[slot]);
  }
  EXPECT_GT(largest, 0.01) << "is there anything to be certified?";
  EXPECT_GE(largest * gap, errors.max_error);
  EXPECT_LE(errors.attained, errors.max_error);
  EXPECT_LE(errors.rms_error, errors.attained);
  EXPECT_GE(errors.attained * 1.051, errors.max_error);
}

// What a dense search misses near the maximum, on top of the twentieth that is promised.
constexpr double gap = 1.05 * 1.05;

TEST(Certify, bounds_what_brute_force_finds_in_every_brick_and_hardly_more_in_the_worst) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {3, 3, 3}, .jitter = 0.15}, tests::marschner_lobb_field(2));
  expect_bound(Sampled(mesh, {.longest_axis = 14}), 40, gap);
}

TEST(Certify, bounds_a_rough_field_on_cells_smaller_and_larger_than_the_steps) {
  expect_bound(
      Sampled(with_random_values(tests::box_mesh({.cells = {2, 2, 2}, .jitter = 0.1}), 1), {.longest_axis = 18}), 80,
      gap);
  expect_bound(Sampled(with_random_values(tests::box_mesh({.cells = {5, 5, 5}, .jitter = 0.1}), 2),
                       {.sample_count = {4, 11, 6}}),
               30, gap);
}

TEST(Certify, bounds_the_error_where_vertices_are_samples) {
  expect_bound(Sampled(with_random_values(tests::box_mesh({.cells = {4, 4, 4}}), 3), {.sample_count = {9, 9, 9}}), 40,
               gap);
}

TEST(Certify, bounds_the_error_around_holes) {
  NeutralMesh mesh = with_random_values(tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.1}), 4);
  std::mt19937_64 random(4);
  Array<std::array<std::uint64_t, 4>> kept;
  for (const auto& cell : mesh.cells)
    if (random() % 16 != 0) kept.push_back(cell);
  mesh.cells = kept;
  const Sampled sampled(mesh, {.longest_axis = 22});
  EXPECT_LT(sampled.samples.inside_count, static_cast<std::uint64_t>(volume(sampled.lattice.count)));
  EXPECT_GT(sampled.samples.extended_count, 100U);
  EXPECT_NEAR(sampled.certificates.fields[0].coverage, 1, 1e-9);
  expect_bound(sampled, 30, gap);
  EXPECT_EQ(sampled.bare_point_count, 0U);
}

TEST(Certify, compares_with_every_cell_where_cells_overlap) {
  const NeutralMesh mesh = with_random_values(tests::strewn_mesh(40, 0.5, 1, 6), 5);
  const Sampled sampled(mesh, {.longest_axis = 20});
  EXPECT_GT(sampled.samples.overlap_count, 50U);
  expect_bound(sampled, 44, gap);
}

TEST(Certify, knows_nothing_of_cells_without_data) {
  NeutralMesh mesh = with_random_values(tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.1}), 6);
  mesh.point_fields[0].values[62] = std::nan("");
  const Sampled sampled(mesh, {.longest_axis = 24});
  expect_bound(sampled, 40, gap);
}

TEST(Certify, finds_slivers_no_worse_than_their_values) {
  const NeutralMesh mesh = with_random_values(tests::strewn_mesh(60, 0.5, 1e-7, 8), 7);
  const Sampled sampled(mesh, {.longest_axis = 20});
  for (const double error : sampled.certificates.fields[0].max) EXPECT_LE(error, 1.06);
}

TEST(Certify, is_at_rounding_for_a_linear_field) {
  for (const bool single : {false, true}) {
    const NeutralMesh mesh =
        tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.15}, tests::linear_field({3, -2, 5}, 100), single);
    const Sampled sampled(mesh, {.longest_axis = 30});
    const double rounding = single ? 0x1p-21 * 106 : 0x1p-46 * 106;
    EXPECT_LE(sampled.certificates.fields[0].attained, single ? 0x1p-22 * 106 : rounding);
    if (!single)
      sampled.for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
        const auto p = sampled.place(i, j, k);
        EXPECT_NEAR(sampled.sample(i, j, k), 100 + 3 * p[0] - 2 * p[1] + 5 * p[2], rounding);
      });
    EXPECT_LE(sampled.certificates.fields[0].max_error, 1e-6 * 10 + rounding);
  }
}

TEST(Certify, finds_a_quarter_of_the_error_at_half_the_spacing_until_the_cells_are_larger_than_the_steps) {
  // Steps of 1/3, 1/6, 1/12 on cells of 1/24 see the field's own curvature: second order. Steps far
  // below the cells see kinks, a jump in the gradient times the step: first order.
  const tests::Field field = [](const Vec3& p) { return std::sin(3 * p.x) * std::cos(2 * p.y + 1) * std::exp(p.z); };
  const auto error_with = [&](std::int64_t cells, std::int64_t samples) {
    const NeutralMesh mesh = tests::box_mesh({.cells = {cells, cells, cells}}, field);
    return Sampled(mesh, {.longest_axis = samples}).certificates.fields[0].max_error;
  };
  const double third = error_with(24, 4), sixth = error_with(24, 7), twelfth = error_with(24, 13);
  EXPECT_NEAR(third / sixth, 4, 0.8);
  EXPECT_NEAR(sixth / twelfth, 4, 0.8);
  const double coarse = error_with(3, 20), fine = error_with(3, 39);
  EXPECT_NEAR(coarse / fine, 2, 0.4);
}

TEST(Probes, are_spread_evenly_over_the_places_in_a_cell_whatever_share_of_the_rows_has_them) {
  const SampleLattice lattice = choose_samples(Box3({0, 0, 0}, {32, 16, 16}), {.sample_count = {33, 17, 17}});
  for (const std::int64_t step : {1, 2, 4}) {
    std::array<std::vector<double>, 3> places;
    std::int64_t bricks_left = step * step;
    for (std::int64_t b = 0; b < 16 && bricks_left > 0; ++b, --bricks_left) {
      const PointRows rows = rows_of_probes(lattice, {b % 4, b / 4 % 2, b / 8}, step);
      EXPECT_EQ(rows.size, Index3(8, 8, 8));
      for (std::int64_t k = 0; k < 8; k += step)
        for (std::int64_t j = 0; j < 8; j += step) {
          const auto row = static_cast<std::size_t>(k * 8 + j);
          places[0].push_back(rows.shift[row]);
          places[1].push_back(rows.y[row] - std::floor(rows.y[row]));
          places[2].push_back(rows.z[row] - std::floor(rows.z[row]));
        }
    }
    for (auto& on_axis : places) {
      ASSERT_EQ(on_axis.size(), 64U);
      std::sort(on_axis.begin(), on_axis.end());
      for (std::size_t i = 0; i < 64; ++i) EXPECT_EQ(on_axis[i], (static_cast<double>(i) + 0.5) / 64) << step;
    }
  }
}

}  // namespace
}  // namespace rhoray::preprocess

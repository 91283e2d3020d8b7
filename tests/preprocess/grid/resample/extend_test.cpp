#include "preprocess/grid/resample/extend.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/preprocess/grid/resample/support.h"

// A leaf cell has a trilinear field only where all of its eight samples have values. Samples beside
// a thin mesh had none: 98 % of a plate was lost, and --max-error called this a success.
namespace rhoray::preprocess {
namespace {

/// Every point moved by `place`, and then a field "value".
template <class Place>
NeutralMesh moved(NeutralMesh mesh, const Place& place, const tests::Field& field) {
  for (auto& point : mesh.points) point = tests::to_array(place(tests::to_vec3(point)));
  mesh.point_fields.clear();
  tests::add_point_field(mesh, "value", field);
  return mesh;
}

/// A plate of 10 x 10 x `thickness`, tilted against all axes.
NeutralMesh plate(double thickness, const tests::Field& field, std::int64_t cells = 12) {
  const Vec3 u = Vec3(2, 1, 0.5).normalized(), w = u.cross(Vec3(-0.3, 1, 0.4)).normalized(), v = w.cross(u);
  return moved(
      tests::box_mesh({.cells = {cells, cells, 1}}),
      [&](const Vec3& p) { return 10 * p.x * u + 10 * p.y * v + thickness * p.z * w; }, field);
}

/// A piece of a sphere's shell.
NeutralMesh shell(double radius, double thickness, const tests::Field& field) {
  return moved(
      tests::box_mesh({.cells = {20, 20, 1}}),
      [&](const Vec3& p) {
        const double a = 2 * p.x, b = 1.4 * p.y - 0.7, r = radius + thickness * p.z;
        return Vec3(r * std::cos(a) * std::cos(b), r * std::sin(a) * std::cos(b), r * std::sin(b));
      },
      field);
}

/// Expects that every point of the mesh has a value and that what is found there is below the
/// bounds of all bricks.
/// @return  the largest difference that was found
double expect_covered_and_bounded(const Sampled& sampled, int order) {
  const FieldErrors& errors = sampled.certificates.fields[0];
  EXPECT_NEAR(errors.coverage, 1, 1e-9);
  double largest = 0;
  sampled.for_each_difference(order, [&](const Index3& leaf, double difference) {
    const std::uint32_t slot = sampled.touched.slot({leaf.x / 8, leaf.y / 8, leaf.z / 8});
    EXPECT_LE(difference, errors.max[slot] * (1 + 1e-12) + 1e-13) << leaf;
    largest = std::max(largest, difference);
  });
  EXPECT_EQ(sampled.bare_point_count, 0U);
  EXPECT_LE(largest, errors.max_error);
  return largest;
}

std::size_t value_count(const Sampled& sampled) {
  std::size_t count = 0;
  sampled.for_each_sample(
      [&](std::int64_t i, std::int64_t j, std::int64_t k) { count += !std::isnan(sampled.sample(i, j, k)); });
  return count;
}

TEST(Extend, continues_a_linear_field_beside_a_plate_thinner_than_a_step) {
  const tests::Field linear = tests::linear_field({1, -2, 3}, 1e3);
  const Sampled sampled(plate(0.3, linear), {.spacing = {1, 1, 1}});
  const auto leaves = static_cast<double>(volume(sampled.lattice.count - Index3(1, 1, 1)));
  EXPECT_LT(static_cast<double>(sampled.samples.inside_count), 0.1 * leaves) << "is the plate thin?";
  EXPECT_GT(sampled.samples.extended_count, 3 * sampled.samples.inside_count);
  EXPECT_LE(expect_covered_and_bounded(sampled, 20), 1e-10);
  EXPECT_LE(sampled.certificates.fields[0].max_error, 1e-6 * 60) << "differences of this size are not told apart";
  sampled.for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double value = sampled.sample(i, j, k);
    const auto p = sampled.place(i, j, k);
    const Vec3 world = sampled.mesh.origin + Vec3(p[0], p[1], p[2]);
    if (std::isnan(value)) return;
    EXPECT_NEAR(value, linear(world), 1e-9);
  });
}

TEST(Extend, continues_a_field_across_a_plate_no_farther_than_by_its_range) {
  // From 0 to 1 across 0.02 steps: continued, the samples would be at 50 and beyond.
  NeutralMesh mesh = plate(0.02, tests::linear_field({0, 0, 0}));
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    mesh.point_fields[0].values[p] = p < mesh.points.size() / 2 ? 0 : 1;
  const Sampled sampled(mesh, {.spacing = {1, 1, 1}});
  double low = 0, high = 0;
  sampled.for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double value = sampled.sample(i, j, k);
    if (std::isnan(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  });
  EXPECT_GE(low, -1);
  EXPECT_LE(high, 2);
  EXPECT_GT(expect_covered_and_bounded(sampled, 20), 0.05) << "and the certificate tells what this costs";
}

TEST(Extend, covers_a_thin_curved_shell_within_the_certificate) {
  const tests::Field wave = [](const Vec3& p) { return std::sin(p.x) + std::cos(0.7 * p.y) * p.z; };
  const Sampled sampled(shell(6, 0.2, wave), {.longest_axis = 21});
  EXPECT_GT(sampled.samples.extended_count, 3 * sampled.samples.inside_count);
  const double largest = expect_covered_and_bounded(sampled, 24);
  EXPECT_GT(largest, 0.01);
  EXPECT_LE(sampled.certificates.fields[0].max_error, 0.35) << "of a range of 9 with steps of a twelfth of a wave";
  EXPECT_GE(1.06 * largest, sampled.certificates.fields[0].max_error);
}

NeutralMesh with_notch(std::int64_t cells, const tests::Field& field) {
  NeutralMesh mesh = tests::box_mesh({.cells = {cells, cells, cells}, .box = Box3({0, 0, 0}, {8, 8, 8})}, field);
  Array<std::array<std::uint64_t, 4>> kept;
  for (const auto& cell : mesh.cells) {
    Vec3 middle(0, 0, 0);
    for (const std::uint64_t v : cell) middle += 0.25 * tests::to_vec3(mesh.points[v]);
    if (!(middle.x > 4 && middle.y > 4 && middle.z > 4)) kept.push_back(cell);
  }
  mesh.cells = kept;
  return mesh;
}

TEST(Extend, covers_a_re_entrant_corner) {
  const tests::Field bowl = [](const Vec3& p) { return 0.01 * p.dot(p); };
  const Sampled sampled(with_notch(8, bowl), {.spacing = {0.9, 1.1, 0.7}});
  EXPECT_GT(sampled.samples.extended_count, 50U);
  const double largest = expect_covered_and_bounded(sampled, 16);
  EXPECT_GT(largest, 0.001);
  EXPECT_LE(sampled.certificates.fields[0].max_error, 0.02) << "of a range of 1.92";
}

TEST(Extend, gives_no_value_where_the_mesh_ends_in_planes_of_samples) {
  const Sampled sampled(with_notch(4, tests::linear_field({1, 1, 1})), {.spacing = {1, 1, 1}});
  EXPECT_EQ(sampled.lattice.count, Index3(9, 9, 9));
  EXPECT_EQ(sampled.samples.inside_count, 9U * 9 * 9 - 4 * 4 * 4);
  EXPECT_EQ(sampled.samples.extended_count, 0U);
  EXPECT_EQ(value_count(sampled), sampled.samples.inside_count);
  expect_covered_and_bounded(sampled, 8);
}

TEST(Extend, tells_that_two_sides_of_a_narrow_gap_want_different_values) {
  NeutralMesh mesh = tests::box_mesh({.cells = {6, 6, 3}, .box = Box3({0, 0, 0}, {6, 6, 3.4})});
  const NeutralMesh upper = tests::box_mesh({.cells = {6, 6, 3}, .box = Box3({0, 0, 3.6}, {6, 6, 7})});
  const std::size_t count = mesh.points.size();
  for (const auto& cell : upper.cells)
    mesh.cells.push_back({cell[0] + count, cell[1] + count, cell[2] + count, cell[3] + count});
  mesh.points.insert(mesh.points.end(), upper.points.begin(), upper.points.end());
  tests::add_point_field(mesh, "value", [](const Vec3& p) { return p.z < 3.5 ? 0.0 : 1.0; });
  const Sampled sampled(mesh, {.spacing = {1, 1, 1}});
  EXPECT_EQ(value_count(sampled), 7U * 7 * 8) << "inside, every leaf cell with the gap has samples of both sides";
  const double largest = expect_covered_and_bounded(sampled, 10);
  EXPECT_GT(largest, 0.3);
  EXPECT_LT(largest, 0.7);
}

TEST(Extend, puts_values_no_farther_than_one_step_from_the_mesh) {
  const Sampled sampled(with_random_values(tests::strewn_mesh(12, 0.2, 0.2, 9), 2), {.longest_axis = 40});
  std::vector<double> nearest(static_cast<std::size_t>(volume(sampled.lattice.count)),
                              std::numeric_limits<double>::infinity());
  const auto number = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<std::size_t>((k * sampled.lattice.count.y + j) * sampled.lattice.count.x + i);
  };
  constexpr int order = 60;
  for (const auto& cell : sampled.mesh.cells)
    for (int a = 0; a <= order; ++a)
      for (int b = 0; a + b <= order; ++b)
        for (int c = 0; a + b + c <= order; ++c) {
          const std::array<int, 4> counts{a, b, c, order - a - b - c};
          std::array<double, 3> p{};
          for (std::size_t v = 0; v < 4; ++v)
            for (std::size_t axis = 0; axis < 3; ++axis)
              p[axis] += counts[v] * sampled.mesh.points[cell[v]][axis] / order;
          const std::array<double, 3> s = sampled.lattice.in_steps(p);
          for (int near = 0; near < 64; ++near) {
            Index3 at;
            double distance = 0;
            for (int axis = 0; axis < 3; ++axis) {
              at[axis] = std::clamp<std::int64_t>(
                  static_cast<std::int64_t>(s[static_cast<std::size_t>(axis)]) + (near >> 2 * axis & 3) - 1, 0,
                  sampled.lattice.count[axis] - 1);
              distance =
                  std::max(distance, std::abs(static_cast<double>(at[axis]) - s[static_cast<std::size_t>(axis)]));
            }
            double& least = nearest[number(at.x, at.y, at.z)];
            least = std::min(least, distance);
          }
        }
  std::size_t outside = 0;
  sampled.for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (std::isnan(sampled.sample(i, j, k))) return;
    EXPECT_LE(nearest[number(i, j, k)], 1.3) << Index3(i, j, k);  // and what the points are apart
    ++outside;
  });
  EXPECT_EQ(outside, sampled.samples.inside_count + sampled.samples.extended_count);
  EXPECT_GT(sampled.samples.extended_count, 500U);
  expect_covered_and_bounded(sampled, 30);
}

TEST(Extend, continues_a_field_into_cells_where_it_has_no_data) {
  NeutralMesh mesh = tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.1}, tests::linear_field({1, 2, 3}));
  tests::add_point_field(mesh, "whole", tests::linear_field({3, 2, 1}));
  mesh.point_fields[0].values[62] = std::nan("");
  const Sampled sampled(mesh, {.longest_axis = 24});
  EXPECT_GT(sampled.samples.extended_count, 20U);
  EXPECT_LE(expect_covered_and_bounded(sampled, 30), 1e-12);
  EXPECT_LT(value_count(sampled), 24U * 24 * 24) << "and not into all of them";
  EXPECT_EQ(sampled.certificates.fields[1].coverage, 1);
  EXPECT_LE(sampled.certificates.fields[1].attained, 1e-12) << "the other field has nothing to do with it";
}

TEST(Extend, holds_for_cells_strewn_at_random) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Sampled sampled(with_random_values(tests::strewn_mesh(30, 0.3, 0.05, seed), seed), {.longest_axis = 18});
    expect_covered_and_bounded(sampled, 40);
    EXPECT_LE(sampled.certificates.fields[0].max_error, 2.0) << "values are 0 to 1";
  }
}

}  // namespace
}  // namespace rhoray::preprocess

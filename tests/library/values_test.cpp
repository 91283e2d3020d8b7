// Values at points, and the largest values along rays.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"

namespace rhoray::tests {
namespace {

struct Found {
  std::vector<double> values;
  std::vector<std::uint64_t> cells;
};

Found found_at(const FieldSampler& sampler, const std::vector<Vec3>& points) {
  std::vector<double> numbers;
  for (const Vec3& p : points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  Found found{std::vector<double>(points.size()), std::vector<std::uint64_t>(points.size())};
  sampler.at({std::span<const double>(numbers), {static_cast<std::int64_t>(points.size()), 3}}, found.values,
             found.cells);
  return found;
}

TEST(FieldSamplers, interpolate_between_samples) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> value(-5, 5);
  const Samples<double> samples = samples_of<double>(7, 6, 5, [&](auto, auto, auto) { return value(random); });
  const Dataset grid =
      pack({.fields = {samples.field("f")}, .spacing = {0.5, 2, 0.25}, .origin = {-1, 10, 3}}, AxisOrder::zyx);
  const auto sample = [&](int i, int j, int k) {
    return samples.values[static_cast<std::size_t>((k * 6 + j) * 7 + i)];
  };
  std::vector<Vec3> points;
  std::vector<double> expected;
  std::vector<std::uint64_t> cells;
  std::uniform_real_distribution<double> share(0, 1);
  for (int n = 0; n < 500; ++n) {
    const double x = 6 * share(random), y = 5 * share(random), z = 4 * share(random);
    const int i = static_cast<int>(x), j = static_cast<int>(y), k = static_cast<int>(z);
    points.push_back({-1 + 0.5 * x, 10 + 2 * y, 3 + 0.25 * z});
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
      sum += (a ? x - i : i + 1 - x) * (b ? y - j : j + 1 - y) * (c ? z - k : k + 1 - z) * sample(i + a, j + b, k + c);
    }
    expected.push_back(sum);
    cells.push_back(static_cast<std::uint64_t>((k * 5 + j) * 6 + i));
  }
  const Found found = found_at(FieldSampler(grid), points);
  for (std::size_t p = 0; p < points.size(); ++p) EXPECT_NEAR(found.values[p], expected[p], 1e-12);
  EXPECT_EQ(found.cells, cells);
}

TEST(FieldSamplers, know_faces_and_the_border_and_nothing_outside) {
  const Samples<float> samples =
      samples_of<float>(4, 4, 4, [](auto i, auto j, auto k) { return i + 10 * j + 100 * k; });
  const FieldSampler sampler(pack({.fields = {samples.field("f")}}, AxisOrder::zyx));
  const Found inside = found_at(sampler, {{1, 2, 1.5}, {0, 0, 0}, {3, 3, 3}, {3, 0.5, 0}, {0.25, 3, 1}});
  EXPECT_EQ(inside.values, (std::vector<double>{171, 0, 333, 8, 130.25}));
  EXPECT_EQ(inside.cells[1], 0U);
  EXPECT_EQ(inside.cells[2], 26U);
  const Found outside = found_at(sampler, {{-0.001, 1, 1}, {1, 3.001, 1}, {1, 1, 1e300}, {-1e300, 0, 0}});
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_TRUE(std::isnan(outside.values[p]));
    EXPECT_EQ(outside.cells[p], no_cell);
  }
}

TEST(FieldSamplers, find_nothing_in_absent_cells_but_on_their_faces) {
  const Samples<float> samples = samples_of<float>(
      5, 4, 4, [](auto i, auto j, auto k) { return i == 4 && j == 0 && k == 0 ? NAN : static_cast<double>(i); });
  const FieldSampler sampler(pack({.fields = {samples.field("f")}}, AxisOrder::zyx));
  const Found found = found_at(sampler, {{3.5, 0.5, 0.5}, {3, 0.5, 0.5}, {3.5, 1, 0.5}, {3.5, 1.5, 0.5}, {4, 0, 0}});
  EXPECT_TRUE(std::isnan(found.values[0]));
  EXPECT_EQ(found.values[1], 3) << "of the neighbour with data";
  EXPECT_EQ(found.cells[1], 2U);
  EXPECT_EQ(found.values[2], 3.5);
  EXPECT_EQ(found.values[3], 3.5);
  EXPECT_TRUE(std::isnan(found.values[4]));
  EXPECT_EQ(found.cells[4], no_cell);
}

TEST(FieldSamplers, interpolate_in_a_mesh_far_from_the_origin) {
  constexpr double offset = 1e6;
  const MadeMesh mesh = box_mesh(3, {{offset, -offset, 0}, {offset + 3, -offset + 3, 3}});
  // Linear between the points of every cell, so that each point of the mesh has this value.
  const auto field = [&](const Vec3& p) { return (p.x - offset) - 2 * (p.y + offset) + 0.5 * p.z; };
  const std::vector<double> values = mesh.point_values(field);
  MeshArrays arrays = mesh.arrays();
  arrays.point_fields = {{.name = "f", .values = std::span<const double>(values)}};
  const FieldSampler sampler(pack(arrays));
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> share(0, 3);
  std::vector<Vec3> points;
  for (int n = 0; n < 200; ++n) points.push_back({offset + share(random), -offset + share(random), share(random)});
  points.push_back({offset, -offset, 0});                // a corner
  points.push_back({offset + 1, -offset + 1, 1});        // a point that many cells share
  points.push_back({offset + 1.5, -offset + 1.5, 1.5});  // on the diagonals
  const Found found = found_at(sampler, points);
  for (std::size_t p = 0; p < points.size(); ++p) {
    EXPECT_NEAR(found.values[p], field(points[p]), 1e-8);
    ASSERT_LT(found.cells[p], 162U);
    // The cell is one of the cube that holds the point.
    if (p < 200) {
      const auto cube = [](double x) { return static_cast<std::uint64_t>(x); };
      EXPECT_EQ(found.cells[p] / 6,
                (cube(points[p].z) * 3 + cube(points[p].y + offset)) * 3 + cube(points[p].x - offset));
    }
  }
  const Found outside =
      found_at(sampler, {{offset - 0.01, -offset + 1, 1}, {0, 0, 0}, {offset + 1, -offset + 1, 3.01}});
  for (const double value : outside.values) EXPECT_TRUE(std::isnan(value));
}

TEST(FieldSamplers, take_floats_and_any_strides) {
  const Dataset grid = gyroid_grid();
  const FieldSampler sampler(grid);
  const std::vector<float> records{9, 1.5F, 4, 5.25F, 9, -2.25F, 3, 6.5F};
  const std::array<std::int64_t, 2> shape{2, 3}, strides{-16, 4};
  std::vector<double> values(2);
  sampler.at(ArrayView(records.data() + 5, ElementType::F32, shape, strides), values);
  EXPECT_EQ(values, found_at(sampler, {{-2.25, 3, 6.5}, {1.5, 4, 5.25}}).values);
}

/// A field x of samples at whole numbers: the largest value is at the end of the ray's way.
TEST(LargestValues, of_a_ramp_are_where_the_ray_leaves_it) {
  const Samples<float> samples = samples_of<float>(9, 5, 5, [](auto i, auto, auto) { return i; });
  const Dataset grid = pack({.fields = {samples.field("x")}}, AxisOrder::zyx);
  MadeRays rays;
  rays.add({-2, 1.3, 2.2}, {2, 0, 0});   // leaves at x = 8, t = 5
  rays.add({20, 1.3, 2.2}, {-1, 0, 0});  // enters at x = 8, t = 12
  rays.add({3, -1, 2}, {0.5, 1, 0});     // from (3.5, 0, 2) to (5.5, 4, 2), t = 5
  rays.add({-2, 1.3, 9}, {2, 0, 0});     // passes no data
  const double expected[] = {8, 8, 5.5}, expected_t[] = {5, 12, 5};
  for (const Accuracy accuracy : {Accuracy::float64, Accuracy::certified, Accuracy::exact}) {
    const bool proves = accuracy != Accuracy::float64;
    std::vector<double> t(4), value(4), error(4), again(4);
    std::vector<std::uint64_t> cell(4);
    RayScratch scratch;
    RenderContext context;
    const FieldSampler sampler(grid, "x", accuracy);
    sampler.largest_values(
        rays.rays(),
        {.t = t, .error = proves ? std::span<double>(error) : std::span<double>(), .value = value, .cell = cell},
        scratch);
    sampler.largest_values(rays.rays(), {.value = again}, context);
    for (std::size_t ray = 0; ray < 3; ++ray) {
      EXPECT_NEAR(value[ray], expected[ray], proves ? error[ray] + 1e-14 : 1e-9) << ray;
      EXPECT_NEAR(t[ray], expected_t[ray], 1e-6);
      EXPECT_EQ(value[ray], again[ray]);
      EXPECT_LT(cell[ray], 128U);
      EXPECT_TRUE(!proves || error[ray] <= 1e-4);
    }
    EXPECT_EQ(t[3], std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(value[3]));
    EXPECT_EQ(cell[3], no_cell);
  }
}

TEST(FieldSamplers, of_a_field_without_values_find_no_data) {
  const Samples<float> samples =
      samples_of<float>(4, 4, 4, [](auto, auto, auto) { return std::numeric_limits<float>::quiet_NaN(); });
  const FieldSampler sampler(pack({.fields = {samples.field("f")}}, AxisOrder::zyx), {}, Accuracy::certified);
  const Found found = found_at(sampler, {{1, 1, 1}, {1.5, 0.5, 2.5}});
  for (const double value : found.values) EXPECT_TRUE(std::isnan(value));
  EXPECT_EQ(found.cells, (std::vector<std::uint64_t>{no_cell, no_cell}));
  MadeRays rays;
  rays.add({-1, 1.5, 1.5}, {1, 0, 0});
  std::vector<double> t(1), value(1);
  RayScratch scratch;
  sampler.largest_values(rays.rays(), {.t = t, .value = value}, scratch);
  EXPECT_TRUE(std::isinf(t[0]) && std::isnan(value[0]));
}

TEST(LargestValues, are_not_below_any_value_along_the_ray) {
  for (const Dataset& data : {gyroid_grid(), ball_mesh()}) {
    const MadeRays rays = random_rays(data.bounds(), 40);
    std::vector<double> t(40), value(40), error(40);
    RayScratch scratch;
    const FieldSampler sampler(data, {}, Accuracy::certified);
    sampler.largest_values(rays.rays(), {.t = t, .error = error, .value = value}, scratch);
    std::size_t hits = 0;
    for (std::size_t ray = 0; ray < 40; ++ray) {
      std::vector<Vec3> points;
      for (int n = 0; n <= 400; ++n) points.push_back(rays.at(ray, n / 100.0));
      double largest = -std::numeric_limits<double>::infinity();
      for (const double each : found_at(sampler, points).values)
        if (each > largest) largest = each;
      if (std::isinf(largest)) continue;
      ++hits;
      EXPECT_GE(value[ray] + error[ray], largest - 1e-12);
      EXPECT_LE(value[ray] - error[ray], largest + 0.1);
      EXPECT_NEAR(found_at(sampler, {rays.at(ray, t[ray])}).values[0], value[ray], 1e-4);
    }
    EXPECT_GT(hits, 20U);
  }
}

}  // namespace
}  // namespace rhoray::tests

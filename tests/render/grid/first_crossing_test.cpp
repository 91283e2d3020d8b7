#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Ray;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Vec3 to_vec3(const Index3& i) {
  return {static_cast<double>(i.x), static_cast<double>(i.y), static_cast<double>(i.z)};
}

/// Rays from around the box [0, size] towards a random point in it.
std::vector<Ray> rays_around(const Vec3& size, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  for (std::size_t r = 0; r < count; ++r) {
    const Vec3 direction = dice.direction();
    rays.push_back({.origin = dice.point({0, 0, 0}, size) - 2 * size.length() * direction, .direction = direction});
  }
  return rays;
}

TEST(GridFirstCrossing, meets_the_plane_of_a_linear_field_at_its_exact_t) {
  const Vec3 slope(0.3, -0.7, 0.2);
  const Index3 samples(17, 12, 21);
  TracedDataset traced(sampled_volume<double>(samples, {}, linear_field(slope, 1)));
  int hits = 0;
  for (const Ray& ray : rays_around({16, 11, 20}, 2000, 1)) {
    for (const double iso : {0.0, -1.25, 3.0}) {
      const auto part = part_in_box(ray, {0, 0, 0}, {16, 11, 20});
      if (!part) continue;
      const double t = (iso - 1 - slope.dot(ray.origin)) / slope.dot(ray.direction);
      const Hit hit = traced.first_crossing(ray, iso);
      if (std::min(std::abs(t - (*part)[0]), std::abs(t - (*part)[1])) < 1e-9) continue;
      ASSERT_EQ(hit.is_miss(), t < (*part)[0] || t > (*part)[1]);
      if (hit.is_miss()) continue;
      EXPECT_NEAR(hit.t, t, 1e-11);
      EXPECT_EQ(hit.value, iso);
      EXPECT_LT((hit.gradient - slope).length(), 1e-13);
      const Index3 cell = cell_of(ray.at(hit.t), samples - Index3(1, 1, 1));
      const Vec3 inside = ray.at(hit.t) - to_vec3(cell);
      if (std::min({inside.x, inside.y, inside.z}) > 1e-9 && std::max({inside.x, inside.y, inside.z}) < 1 - 1e-9) {
        EXPECT_EQ(hit.cell, static_cast<std::uint64_t>((cell.z * 11 + cell.y) * 16 + cell.x));
      }
      ++hits;
    }
  }
  EXPECT_GT(hits, 1500);
}

TEST(GridFirstCrossing, meets_the_saddle_x_y_z_where_it_is) {
  Affine map;
  map.origin = {-4.5, -3.5, -4.5};
  TracedDataset traced(sampled_volume<double>({10, 8, 10}, map, product_field()));
  int hits = 0;
  for (Ray ray : rays_around({9, 7, 9}, 2000, 2)) {
    ray.origin += map.origin;
    const double iso = 2.5;
    const Hit hit = traced.first_crossing(ray, iso);
    const auto part = part_in_box(ray, map.origin, map.origin + Vec3(9, 7, 9));
    if (!part) continue;
    const auto field = product_field();
    // The cubic along the ray is the field itself; the side must not change before the hit.
    const double end = hit.is_miss() ? (*part)[1] : hit.t;
    const bool starts_inside = field(ray.at((*part)[0])) >= iso;
    for (int i = 1; i < 400; ++i) {
      const double t = (*part)[0] + (end - (*part)[0]) * i / 400;
      const double off = field(ray.at(t)) - iso;
      EXPECT_TRUE((off >= 0) == starts_inside || std::abs(off) < 1e-10);
    }
    if (hit.is_miss()) continue;
    EXPECT_NEAR(field(ray.at(hit.t)), iso, 1e-10);
    const Vec3 p = ray.at(hit.t);
    EXPECT_LT((hit.gradient - Vec3(p.y * p.z, p.x * p.z, p.x * p.y)).length(), 1e-10);
    ++hits;
  }
  EXPECT_GT(hits, 1000);
}

// Against an independent implementation of the interpolant: zero at the hit, one side before it.
TEST(GridFirstCrossing, is_the_first_change_of_side_of_the_interpolant) {
  const Index3 count(14, 15, 13), cells(13, 14, 12);
  const Samples samples = [](const Index3& at) {
    const double r = (to_vec3(at) - Vec3(6.3, 7.1, 5.8)).length();
    return static_cast<double>(
        static_cast<float>(r + 0.8 * std::sin(3 * static_cast<double>(at.x + 2 * at.y + 5 * at.z))));
  };
  TracedDataset traced(volume_of<float>(count, [&](const Index3& at) { return static_cast<float>(samples(at)); }));
  int hits = 0, misses = 0;
  for (const Ray& ray : rays_around(to_vec3(cells), 1000, 3)) {
    const double iso = 4.2;
    const Hit hit = traced.first_crossing(ray, iso);
    const auto part = part_in_box(ray, {0, 0, 0}, to_vec3(cells));
    if (!part) continue;
    const auto value = [&](double t) {
      return static_cast<double>(interpolated(samples, cell_of(ray.at(t), cells), ray.at(t)));
    };
    const bool starts_inside = value((*part)[0] + 1e-10) >= iso;
    const double end = hit.is_miss() ? (*part)[1] : hit.t;
    for (int i = 1; i < 600; ++i) {
      const double off = value((*part)[0] + (end - (*part)[0]) * i / 600) - iso;
      ASSERT_TRUE((off >= 0) == starts_inside || std::abs(off) < 1e-9);
    }
    hit.is_miss() ? ++misses : ++hits;
    if (!hit.is_miss()) {
      EXPECT_NEAR(value(hit.t), iso, 1e-11);
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(misses, 30);
}

template <class T>
class GridFirstCrossingOf : public testing::Test {};
using Types =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(GridFirstCrossingOf, Types);

TYPED_TEST(GridFirstCrossingOf, samples_of_every_type_finds_the_same_surface) {
  const auto make = [](auto type) {
    return volume_of<decltype(type)>(
        {9, 7, 8}, [](const Index3& at) { return static_cast<decltype(type)>(10 * at.x + at.y * at.z); });
  };
  TracedDataset traced(make(TypeParam{})), reference(make(double{}));
  for (const Ray& ray : rays_around({8, 6, 7}, 300, 4)) {
    EXPECT_TRUE(same_bits(traced.first_crossing(ray, 43.5), reference.first_crossing(ray, 43.5)));
    EXPECT_TRUE(same_bits(traced.largest_value(ray), reference.largest_value(ray)));
  }
}

TYPED_TEST(GridFirstCrossingOf, the_full_range_of_a_type_is_not_cut_off) {
  using T = TypeParam;
  // Doubles within 1e300: sums of the largest ones would overflow.
  constexpr T low = std::is_same_v<T, double> ? static_cast<T>(-1e300) : std::numeric_limits<T>::lowest();
  constexpr T high = std::is_same_v<T, double> ? static_cast<T>(1e300) : std::numeric_limits<T>::max();
  TracedDataset traced(volume_of<T>({2, 2, 9}, [&](const Index3& at) { return at.z < 4 ? low : high; }));
  const Ray ray{.origin = {0.5, 0.5, -1}, .direction = {0, 0, 1}};
  const Hit hit = traced.first_crossing(ray, static_cast<double>(low) / 4 + static_cast<double>(high) / 4);
  EXPECT_GT(hit.t, 4);
  EXPECT_LT(hit.t, 5);
  EXPECT_EQ(traced.largest_value(ray).value, static_cast<double>(high));
}

/// Fields with every kind of cell: smooth, noisy, plateaus at the isovalue, holes without data.
std::vector<std::function<double(const Index3&)>> fields_of_all_kinds() {
  const auto noise = [](const Index3& at, std::int64_t kinds) {
    const auto hash = static_cast<std::uint64_t>((at.z * 1009 + at.y) * 1013 + at.x) * 0x9e3779b97f4a7c15U;
    return static_cast<std::int64_t>((hash >> 35) % static_cast<std::uint64_t>(kinds));
  };
  return {
      [](const Index3& at) { return 6 - (to_vec3(at) - Vec3(9, 8, 10)).length(); },
      [=](const Index3& at) { return static_cast<double>(noise(at, 1000)) - 500; },
      [=](const Index3& at) { return static_cast<double>(noise(at, 3)) - 1; },
      [=](const Index3& at) { return at.x < 9 ? 0.0 : static_cast<double>(noise(at, 3)) - 1; },
      [=](const Index3& at) { return noise(at, 20) == 0 ? nan : 6 - (to_vec3(at) - Vec3(9, 8, 10)).length(); },
      [=](const Index3& at) { return at.y >= 7 && at.y <= 8 + noise(at, 4) ? nan
                                     : at.y < 7                            ? 5.0
                                                                           : -5.0; },
      [](const Index3& at) { return at.x + at.z > 22 ? nan : static_cast<double>(at.y + at.z) - 20; },
  };
}

TEST(GridFirstCrossing, is_the_same_with_and_without_hierarchy_bit_for_bit) {
  int hits = 0;
  for (const auto& field : fields_of_all_kinds())
    for (const int factor : {2, 3, 4}) {
      TracedDataset traced(volume_of<double>({20, 18, 23}, field), {.macro_factor = factor, .macro_level_count = 2});
      for (const Ray& ray : stressful_rays({19, 17, 22}, 700, 5)) {
        const Hit with = traced.first_crossing(ray, 0), without = traced.first_crossing(ray, 0, false);
        ASSERT_TRUE(same_bits(with, without)) << ray.origin << " + t " << ray.direction << ": " << with.t << " in cell "
                                              << with.cell << ", " << without.t << " in cell " << without.cell;
        hits += !with.is_miss();
      }
    }
  EXPECT_GT(hits, 3000);
}

TEST(GridFirstCrossing, is_the_same_in_bricks_and_in_linear_order_bit_for_bit) {
  for (const auto& field : fields_of_all_kinds()) {
    TracedDataset bricked(volume_of<double>({20, 18, 23}, field)),
        linear(volume_of<double>({20, 18, 23}, field), {.order = preprocess::SampleOrder::linear});
    for (const Ray& ray : stressful_rays({19, 17, 22}, 400, 6)) {
      ASSERT_TRUE(same_bits(bricked.first_crossing(ray, 0), linear.first_crossing(ray, 0)));
      ASSERT_TRUE(same_bits(bricked.largest_value(ray), linear.largest_value(ray)));
    }
  }
}

TEST(GridFirstCrossing, from_inside_is_where_the_ray_comes_out) {
  TracedDataset traced(sampled_volume<double>({21, 21, 21}, {}, [](const Vec3& p) { return 7 - std::abs(p.x - 10); }));
  const Hit out = traced.first_crossing({.origin = {10, 9.5, 9.5}, .direction = {1, 0, 0}}, 2);
  EXPECT_NEAR(out.t, 5, 1e-13);
  const Hit at_the_surface = traced.first_crossing({.origin = {15, 9.5, 9.5}, .direction = {-1, 0, 0}}, 2);
  EXPECT_NEAR(at_the_surface.t, 10, 1e-13) << "the start counts as inside: the next change is the hit (R31)";
}

TEST(GridFirstCrossing, gives_no_surface_where_the_ray_enters_or_leaves_the_volume) {
  TracedDataset traced(volume_of<std::uint8_t>({5, 5, 5}, [](const Index3&) { return 200; }));
  for (const Ray& ray : rays_around({4, 4, 4}, 200, 7)) {
    EXPECT_TRUE(traced.first_crossing(ray, 100).is_miss());
    EXPECT_TRUE(traced.first_crossing(ray, 200).is_miss());
    EXPECT_TRUE(traced.first_crossing(ray, 300).is_miss());
  }
}

// D07. A macrocell's range does not include its cells without data. A ray once kept its side across
// a skipped macrocell, although it left it through such cells, and hit a surface that does not
// exist.
TEST(GridFirstCrossing, gives_no_surface_against_a_region_without_data) {
  for (const bool use_hierarchy : {false, true})
    for (int first = 6; first < 13; ++first) {
      TracedDataset traced(volume_of<float>({20, 20, 20}, [=](const Index3& at) {
        if (at.x == first || at.x == first + 1) return static_cast<float>(nan);
        return at.x < first ? 10.0F : -10.0F;
      }));
      for (const Ray& ray : rays_around({19, 19, 19}, 100, 8))
        EXPECT_TRUE(traced.first_crossing(ray, 0, use_hierarchy).is_miss()) << "no data from " << first;
    }
}

TEST(GridFirstCrossing, goes_on_behind_a_region_without_data) {
  TracedDataset traced(volume_of<double>(
      {30, 8, 8}, [](const Index3& at) { return at.x >= 8 && at.x <= 12 ? nan : static_cast<double>(at.x) - 20.5; }));
  for (const bool use_hierarchy : {false, true})
    EXPECT_NEAR(traced.first_crossing({.origin = {-3, 3.3, 4.4}, .direction = {1, 0, 0}}, 0, use_hierarchy).t, 23.5,
                1e-13);
}

TEST(GridFirstCrossing, counts_the_work_that_it_did) {
  TracedDataset traced(volume_of<std::uint8_t>({65, 9, 9}, [](const Index3& at) { return at.x < 60 ? 0 : 100; }));
  traced.first_crossing({.origin = {-1, 4.5, 4.5}, .direction = {1, 0, 0}}, 50);
  EXPECT_EQ(traced.scratch.counters.cells_solved, 1U);
  EXPECT_LE(traced.scratch.counters.cells_visited, 4U);
  EXPECT_GE(traced.scratch.counters.macrocells_visited, 3U);
  traced.scratch.counters = {};
  traced.first_crossing({.origin = {-1, 4.5, 4.5}, .direction = {1, 0, 0}}, 50, false);
  EXPECT_EQ(traced.scratch.counters.cells_visited, 60U);
  EXPECT_EQ(traced.scratch.counters.macrocells_visited, 0U);
}

TEST(GridFirstCrossing, and_largest_value_do_not_look_into_cells_that_a_ray_only_touches) {
  // Along the body diagonal: 12 cells are passed through, and two more are touched at every lattice
  // point.
  TracedDataset traced(sampled_volume<float>({13, 13, 13}, {}, linear_field({1, 1, 1})));
  const Ray ray{.origin = {-1, -1, -1}, .direction = {1, 1, 1}};
  EXPECT_TRUE(traced.first_crossing(ray, 50, false).is_miss());
  EXPECT_EQ(traced.scratch.counters.cells_visited, 12U);
  traced.scratch.counters = {};
  EXPECT_EQ(traced.largest_value(ray, render::Method{}, false, false).value, 36);
  EXPECT_EQ(traced.scratch.counters.cells_visited, 12U);
}

TEST(GridFirstCrossing, is_a_miss_for_rays_that_are_none) {
  TracedDataset traced(sampled_volume<double>({5, 5, 5}, {}, linear_field({1, 1, 1})));
  for (const Vec3& direction : {Vec3(0, 0, 0), Vec3(nan, 1, 1), Vec3(1, nan, 0)}) {
    EXPECT_TRUE(traced.first_crossing({.origin = {1, 1, 1}, .direction = direction}, 6).is_miss());
    EXPECT_TRUE(traced.largest_value({.origin = {1, 1, 1}, .direction = direction}).is_miss());
  }
  EXPECT_TRUE(traced.first_crossing({.origin = {nan, 1, 1}, .direction = {1, 0, 0}}, 6).is_miss());
}

}  // namespace
}  // namespace rhoray::tests

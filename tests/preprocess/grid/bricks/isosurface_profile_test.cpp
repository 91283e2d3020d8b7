#include "preprocess/values/isosurface_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "formats/automatic_isovalue.h"
#include "formats/base/parallel.h"
#include "formats/brick_grid.h"
#include "preprocess/pack_volume.h"
#include "preprocess/values/summarize.h"
#include "tests/support/fields.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

const std::array<std::vector<double>, 3> even;

/// A field over a lattice around the origin, summarised and profiled.
template <class T = float>
formats::FieldSummary profiled(const Index3& count, const Vec3& spacing, const std::function<double(const Vec3&)>& f,
                               const std::array<std::vector<double>, 3>& axes = even) {
  std::vector<T> samples;
  for (std::int64_t k = 0; k < count.z; ++k)
    for (std::int64_t j = 0; j < count.y; ++j)
      for (std::int64_t i = 0; i < count.x; ++i) {
        const std::array<std::int64_t, 3> index{i, j, k};
        Vec3 p;
        for (std::size_t a = 0; a < 3; ++a) {
          const int axis = static_cast<int>(a);
          const double position = axes[a].empty()
                                      ? static_cast<double>(index[a]) - static_cast<double>(count[axis] - 1) / 2
                                      : axes[a][static_cast<std::size_t>(index[a])];
          p[axis] = position * spacing[axis];
        }
        samples.push_back(static_cast<T>(f(p)));
      }
  formats::FieldSummary field = summarize(std::span<const T>(samples), "f", "");
  const Affine map{{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z}, {0, 0, 0}};
  profile_isosurfaces(std::span<const T>(samples), {count, map, axes}, field);
  return field;
}

std::size_t bin_of(const formats::FieldSummary& field, double value) {
  return formats::histogram_bin(field.range, field.histogram.size(), value);
}

double middle_of(const formats::FieldSummary& field, std::size_t bin) {
  return std::lerp(field.range.lo, field.range.hi,
                   (static_cast<double>(bin) + 0.5) / static_cast<double>(field.histogram.size()));
}

TEST(IsosurfaceProfile, knows_planes_across_an_axis) {
  // Patches of a plane across an axis are its area itself, and 1.5 is divided out.
  for (const Vec3& spacing : {Vec3(1, 1, 1), Vec3(0.5, 2, 3)}) {
    const auto field = profiled({21, 31, 11}, spacing, [](const Vec3& p) { return 7 * p.x; });
    for (std::size_t bin = 1; bin < 255; ++bin) {
      ASSERT_NEAR(field.mean_gradient[bin], 7 * 1.5, 0.01);
      ASSERT_NEAR(field.isosurface_area[bin] * 1.5, 30 * spacing.y * 10 * spacing.z, 0.5);
    }
  }
}

TEST(IsosurfaceProfile, knows_spheres) {
  // Distance from the origin: the area of a sphere, and a gradient of 1.
  for (const Vec3& spacing : {Vec3(1, 1, 1), Vec3(0.8, 1.5, 1.1)})
    for (const std::int64_t size : {96, 130}) {
      const auto field = profiled({size, size, size}, spacing, [](const Vec3& p) { return p.length(); });
      const double tolerance = size == 96 ? 0.02 : 0.06;  // a fifth of its rows
      for (const double share : {0.2, 0.3, 0.4}) {
        const std::size_t bin = bin_of(field, share * static_cast<double>(size) * 0.8);
        const double radius = middle_of(field, bin);
        EXPECT_NEAR(field.isosurface_area[bin] / (4 * std::numbers::pi * radius * radius), 1, tolerance) << size;
        EXPECT_NEAR(field.mean_gradient[bin], 1, tolerance);
      }
    }
}

TEST(IsosurfaceProfile, measures_steps_that_differ_along_an_axis) {
  std::array<std::vector<double>, 3> axes;
  for (int i = -40; i <= 40; ++i) axes[1].push_back(0.5 * i + 0.004 * i * std::abs(i));
  const auto field = profiled(
      {61, 81, 61}, {1, 1, 1}, [](const Vec3& p) { return p.length(); }, axes);
  const std::size_t bin = bin_of(field, 20);
  const double radius = middle_of(field, bin);
  EXPECT_NEAR(field.isosurface_area[bin] / (4 * std::numbers::pi * radius * radius), 1, 0.02);
  EXPECT_NEAR(field.mean_gradient[bin], 1, 0.02);
}

TEST(IsosurfaceProfile, leaves_out_samples_without_data) {
  const auto field = profiled({64, 64, 64}, {1, 1, 1}, [](const Vec3& p) {
    return p.x > 0 ? std::numeric_limits<double>::quiet_NaN() : p.length();
  });
  const std::size_t bin = bin_of(field, 20);
  const double radius = middle_of(field, bin);
  EXPECT_NEAR(field.isosurface_area[bin] / (2 * std::numbers::pi * radius * radius), 1, 0.05);
  EXPECT_NEAR(field.mean_gradient[bin], 1, 0.03);
}

TEST(IsosurfaceProfile, says_nothing_where_there_is_nothing_to_say) {
  for (const double value : {3.0, std::numeric_limits<double>::infinity()}) {
    const auto field = profiled({4, 4, 4}, {1, 1, 1}, [&](const Vec3&) { return value; });
    EXPECT_THAT(field.mean_gradient, testing::IsEmpty());
    EXPECT_THAT(field.isosurface_area, testing::IsEmpty());
  }
  const auto steep = profiled<double>({4, 4, 4}, {1e-200, 1, 1}, [](const Vec3& p) { return p.x > 0 ? 1e300 : 0; });
  EXPECT_THAT(steep.mean_gradient, testing::IsEmpty()) << "a gradient that no double holds";
  const auto wide = profiled<double>({4, 4, 4}, {1, 1, 1}, [](const Vec3& p) { return p.x > 0 ? 1.7e308 : -1.7e308; });
  for (const double gradient : wide.mean_gradient) EXPECT_TRUE(std::isfinite(gradient));
  // Half a bin would be 0.002 and 1.4 times as wide as the smallest number.
  for (const double range : {0x1p-1074, 0x1p-1074 * 716}) {
    const auto narrow = profiled<double>({4, 4, 4}, {1, 1, 1}, [&](const Vec3& p) { return p.x > 0 ? range : 0; });
    EXPECT_EQ(narrow.range.hi, range);
    EXPECT_THAT(narrow.isosurface_area, testing::IsEmpty());
  }
}

TEST(IsosurfaceProfile, is_the_same_with_any_number_of_threads) {
  const auto make = [](unsigned threads) {
    const ThreadLimit limit(threads);
    return profiled({130, 120, 90}, {1, 0.7, 1}, [](const Vec3& p) { return std::sin(p.x) + p.y * p.z; });
  };
  const auto one = make(1), four = make(4);
  EXPECT_EQ(one.mean_gradient, four.mean_gradient);
  EXPECT_EQ(one.isosurface_area, four.isosurface_area);
}

/// Blurred balls inside each other, with noise: 0 outside, then a value for each radius.
double phantom(const Vec3& p, std::initializer_list<std::pair<double, double>> balls, double noise) {
  double value = noise, outside = 0;
  for (const auto& [radius, inside] : balls) {
    value += (inside - outside) * 0.5 * std::erfc((p.length() - radius) / 1.2);
    outside = inside;
  }
  return value;
}

TEST(AutomaticIsovalue, parts_the_two_materials_of_a_blurred_and_noisy_phantom) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 40);
  const auto field = profiled<std::int16_t>({64, 64, 64}, {1, 1, 1}, [&](const Vec3& p) {
    return phantom(p, {{20, 1000}}, noise(random));
  });
  const auto chosen = formats::automatic_isovalue(field);
  EXPECT_TRUE(chosen->is_valley);
  EXPECT_NEAR(chosen->value, 500, 60);
  EXPECT_THAT(chosen->other_valleys, testing::IsEmpty());
}

TEST(AutomaticIsovalue, finds_skin_and_names_bone) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 40);
  const auto field = profiled<std::int16_t>({80, 80, 80}, {1, 1, 1}, [&](const Vec3& p) {
    return phantom(p, {{33, 1000}, {20, 1700}}, noise(random)) - 1000;
  });
  const auto chosen = formats::automatic_isovalue(field);
  EXPECT_TRUE(chosen->is_valley);
  EXPECT_NEAR(chosen->value, -500, 80);
  EXPECT_THAT(chosen->other_valleys, testing::ElementsAre(testing::DoubleNear(350, 80)));
}

TEST(AutomaticIsovalue, of_noise_alone_is_otsus_threshold) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 40);
  const auto field = profiled({48, 48, 48}, {1, 1, 1}, [&](const Vec3&) { return noise(random); });
  const auto chosen = formats::automatic_isovalue(field);
  EXPECT_FALSE(chosen->is_valley);
  EXPECT_EQ(chosen->value, formats::otsu_threshold(field));
}

TEST(PackVolume, stores_the_profile_of_isosurfaces) {
  const auto volume = tests::volume_of<float>(
      {40, 40, 40}, [](const Index3& p) { return static_cast<float>((Vec3(p) - Vec3(20, 20, 20)).length()); });
  const tests::TemporaryFolder folder;
  pack_volume(volume, folder / "ball.rho", {});
  const formats::BrickGrid grid(formats::PackedFile::open(folder / "ball.rho"));
  EXPECT_EQ(grid.file().version(), "1.8");
  const formats::FieldSummary& field = grid.description().fields[0];
  ASSERT_EQ(field.mean_gradient.size(), field.histogram.size());
  EXPECT_NEAR(field.mean_gradient[bin_of(field, 15)], 1, 0.03);
}

}  // namespace
}  // namespace rhoray::preprocess

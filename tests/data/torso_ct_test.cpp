#include "data/recipes/torso_ct.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "data/recipes/torso_scene.h"
#include "formats/base/parallel.h"
#include "preprocess/import_volume.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

std::string torso_ct(const TemporaryFolder& folder, const Index3& size) {
  recipes::write_torso_ct(folder / "ct.nhdr", size, true);
  return read_file(folder / "ct.raw");
}

TEST(TorsoCt, shows_each_tissue_where_the_formulas_put_it) {
  const TemporaryFolder folder;
  const Index3 n(86, 60, 136);  // voxels of 5 mm
  recipes::write_torso_ct(folder / "ct.nhdr", n, false);
  const auto volume = preprocess::import_volume(folder / "ct.nhdr");
  ASSERT_EQ(volume.type, formats::ElementType::I16);
  EXPECT_EQ(volume.sample_count, n);
  int air = 0, lung = 0, heart = 0;
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i) {
        const Vec3 p =
            volume.world_from_grid.point(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
        std::int16_t hu = 0;
        std::memcpy(&hu, volume.samples.data() + 2 * (i + n.x * (j + n.y * k)), sizeof hu);
        constexpr double clear = 25;  // so far off, no surface is seen any more
        if (recipes::torso::skin(p) > clear) {
          EXPECT_NEAR(hu, -1000, 45) << p;
          ++air;
        } else if (std::min(recipes::torso::left_lung(p), recipes::torso::right_lung(p)) < -clear) {
          EXPECT_NEAR(hu, -830, 45) << p;
          ++lung;
        } else if (recipes::torso::heart(p) < -clear && recipes::torso::bone(p) > clear) {
          EXPECT_NEAR(hu, 65, 45) << p;
          ++heart;
        }
      }
  EXPECT_GT(air, 80000);
  EXPECT_GT(lung, 800);
  EXPECT_GT(heart, 160);
}

TEST(TorsoCt, lies_in_the_world_where_the_formulas_do) {
  // Along rows from the right, the first crossing of half-way between air and fat against the
  // skin's formula.
  const TemporaryFolder folder;
  const Index3 n(86, 60, 68);  // voxels of 5 mm x 5 mm x 10 mm
  recipes::write_torso_ct(folder / "ct.nhdr", n, false);
  const auto volume = preprocess::import_volume(folder / "ct.nhdr");
  const auto world = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return volume.world_from_grid.point(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
  };
  int compared = 0;
  for (std::int64_t k = 10; k < 50; k += 3)
    for (std::int64_t j = 28; j < 33; ++j) {
      const auto hu = [&](std::int64_t i) {
        std::int16_t sample = 0;
        std::memcpy(&sample, volume.samples.data() + 2 * (i + n.x * (j + n.y * k)), sizeof sample);
        return static_cast<double>(sample);
      };
      constexpr double half = (-1000 - 95) / 2.0;
      std::int64_t i = 0;
      while (hu(i + 1) < half) ++i;
      const double share = (half - hu(i)) / (hu(i + 1) - hu(i));
      const double seen = (1 - share) * world(i, j, k).x + share * world(i + 1, j, k).x;
      double inside = 0, outside = -215;
      while (inside - outside > 1e-6) {
        const double x = (inside + outside) / 2;
        (recipes::torso::skin({x, world(i, j, k).y, world(i, j, k).z}) < 0 ? inside : outside) = x;
      }
      EXPECT_NEAR(seen, inside, 1.0);
      ++compared;
    }
  EXPECT_EQ(compared, 14 * 5);
}

TEST(TorsoCt, crosses_half_way_at_the_skin) {
  // Along the line through the body from the front, the voxel whose middle lies on the skin is half
  // air, half fat, and one and a half voxels off there is nothing of the other.
  const Vec3 spacing(1, 1, 1);
  double inside = 0, outside = -140;
  while (inside - outside > 1e-9) {
    const double y = (inside + outside) / 2;
    (recipes::torso::skin({0, y, 100}) < 0 ? inside : outside) = y;
  }
  EXPECT_NEAR(recipes::ct_value({0, inside, 100}, spacing), (-1000 - 95) / 2.0, 5);
  EXPECT_EQ(recipes::ct_value({0, inside - 1.5, 100}, spacing), -1000);
  EXPECT_NEAR(recipes::ct_value({0, inside + 2, 100}, spacing), -95, 1e-9);
}

TEST(TorsoCt, has_bone_around_marrow) {
  const Vec3 spacing(0.5, 0.5, 0.5), vertebra(0, 68, 390);  // the middle of a vertebral body
  ASSERT_LT(recipes::torso::bone(vertebra), -5);
  EXPECT_NEAR(recipes::ct_value(vertebra, spacing), 320, 1e-9);
  double largest = 0;
  for (double y = 20; y < 68; y += 0.25) largest = std::max(largest, recipes::ct_value({0, y, 390}, spacing));
  EXPECT_NEAR(largest, 1150, 1e-9);
}

TEST(TorsoCt, is_the_same_for_any_number_of_threads) {
  const TemporaryFolder folder;
  const std::string many = torso_ct(folder, {24, 20, 37});
  const ThreadLimit one_thread(1);
  EXPECT_EQ(many, torso_ct(folder, {24, 20, 37}));
  EXPECT_EQ(many.size(), 24u * 20 * 37 * 2);
}

TEST(TorsoCt, has_noise_of_twelve_units_without_a_bias) {
  double sum = 0, sum2 = 0, neighbours = 0;
  constexpr int count = 200'000;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double noise = recipes::ct_noise(i);
    EXPECT_LE(std::abs(noise), 42);
    sum += noise;
    sum2 += noise * noise;
    neighbours += noise * recipes::ct_noise(i + 1);
  }
  EXPECT_NEAR(sum / count, 0, 0.1);
  EXPECT_NEAR(std::sqrt(sum2 / count), 12, 0.1);
  EXPECT_NEAR(neighbours / count, 0, 1.5);
}

}  // namespace
}  // namespace rhoray::tests

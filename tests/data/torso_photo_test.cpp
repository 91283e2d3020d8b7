#include "data/recipes/torso_photo.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "data/recipes/torso_ct.h"
#include "data/recipes/torso_scene.h"
#include "formats/base/parallel.h"
#include "preprocess/import_volume.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using recipes::tissue_light;

TEST(TorsoPhoto, is_registered_with_the_ct_and_shows_each_tissue_where_the_formulas_put_it) {
  const TemporaryFolder folder;
  const Index3 n(43, 30, 68);  // texels of 10 mm
  recipes::write_torso_photo(folder / "photo.nhdr", n, false);
  recipes::write_torso_ct(folder / "ct.nhdr", n, false);
  preprocess::ImportVolumeOptions colors;
  colors.colors = true;
  const auto photo = preprocess::import_volume(folder / "photo.nhdr", colors);
  const auto ct = preprocess::import_volume(folder / "ct.nhdr");
  EXPECT_EQ(photo.component_count, 3);
  EXPECT_EQ(photo.sample_count, n);
  EXPECT_EQ(photo.world_from_grid, ct.world_from_grid);
  EXPECT_EQ(photo.length_unit, "mm");
  int gel = 0, body = 0;
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i) {
        const Vec3 p = photo.world_from_grid.point(Vec3(Index3(i, j, k)));
        const std::byte* texel = photo.samples.data() + 3 * (i + n.x * (j + n.y * k));
        const auto red = std::to_integer<int>(texel[0]), blue = std::to_integer<int>(texel[2]);
        const double skin = recipes::torso::skin(p);
        if (skin > 25) {
          ASSERT_GT(blue, red) << p;
          ++gel;
        } else if (skin < 0) {
          ASSERT_GT(red, blue) << p;
          ++body;
        }
      }
  EXPECT_GT(gel, 10000);
  EXPECT_GT(body, 10000);
}

TEST(TorsoPhoto, shows_at_a_surface_what_lies_under_it) {
  constexpr double reach = 2;
  // Along the row from the front to the middle of the belly: gel, skin, fat, muscle.
  const Vec3 from(30, -150, 300), step(0, 0.05, 0);
  Vec3 p = from;
  const auto until = [&](double skin) {
    while (recipes::torso::skin(p) > skin) p += step;
    return tissue_light(p, reach);
  };
  const Vec3 gel = until(3), skin = until(0), fat = until(-5), muscle = until(-9 + 0.9 * reach);
  EXPECT_GT(gel.z, gel.x);
  EXPECT_GT(skin.x, skin.z);
  EXPECT_GT(fat.y, 0.3) << "yellow";
  EXPECT_LT(muscle.y, 0.5 * fat.y) << "red, before the surface between fat and muscle is reached";
}

TEST(TorsoPhoto, is_the_same_for_any_number_of_threads) {
  const TemporaryFolder folder;
  const auto made = [&] {
    recipes::write_torso_photo(folder / "a.nhdr", {21, 15, 19}, true);
    return read_file(folder / "a.raw");
  };
  const std::string many = made();
  const ThreadLimit one(1);
  EXPECT_TRUE(made() == many);
}

}  // namespace
}  // namespace rhoray::tests

#include "tools/lab/peers/pixel_rays.h"

#include <gmock/gmock.h>

#include "preprocess/pack_volume.h"
#include "render/ray_caster.h"
#include "tests/tools/lab/small_grid.h"

namespace rhoray::tests {
namespace {

TEST(PixelRays, are_those_that_render_sends) {
  const TemporaryFolder folder;
  preprocess::NeutralVolume grid = ball_grid(8);
  grid.world_from_grid = {{0.5, 0, 0}, {0, 2, 0}, {0, 0, 3}, {0, 0, 0}};
  preprocess::pack_volume(grid, folder / "grid.rho");
  const render::Dataset dataset = render::Dataset::load(folder / "grid.rho");
  const render::Camera camera{.position = {1, -30, 7}, .target = {2, 3, 5}, .up = {0.1, 0, 1}, .vertical_fov_deg = 40};
  constexpr int width = 7, height = 5;
  const auto rays = render::camera_rays(dataset, camera, width, height);
  // In the frame of the samples: world coordinates divided by the spacing.
  const study::PixelRays<double> pixels(camera, width, height, {2, 0.5, 1.0 / 3});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const render::Ray& ray = rays[static_cast<std::size_t>(y * width + x)];
      const auto direction = pixels.through(x, y);
      EXPECT_NEAR(direction.x, ray.direction.x, 1e-14);
      EXPECT_NEAR(direction.y, ray.direction.y, 1e-14);
      EXPECT_NEAR(direction.z, ray.direction.z, 1e-14);
      EXPECT_NEAR(pixels.origin().x, ray.origin.x, 1e-13);
      EXPECT_NEAR(pixels.origin().y, ray.origin.y, 1e-13);
      EXPECT_NEAR(pixels.origin().z, ray.origin.z, 1e-13);
    }
}

}  // namespace
}  // namespace rhoray::tests

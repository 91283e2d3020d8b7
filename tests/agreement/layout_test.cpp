#include "tests/agreement/pictures.h"

namespace rhoray::tests {

// Bricks only change where a sample is stored: every channel of every picture is the same, bit for
// bit.
TEST(Layout, bricked_and_linear_volumes_give_the_same_bits) {
  const TemporaryFolder folder;
  const auto dataset = noise_volume<std::uint16_t>({37, 30, 41}, 6, 11);
  const render::Dataset linear = packed(folder, "linear.rho", dataset, {.order = preprocess::SampleOrder::linear});
  for (const std::int64_t edge : {2, 3, 4, 8}) {
    const render::Dataset bricked = packed(folder, concat("bricks", edge, ".rho"), dataset, {.brick_edge = edge});
    for (const render::Mode mode : {render::Mode::isosurface, render::Mode::mip}) {
      render::Scene scene = oblique_scene(linear, 4.5);
      scene.layers[0].mode = mode;
      const render::Framebuffer expected = picture(linear, scene);
      EXPECT_GT(hit_count(expected), 4000u);
      expect_same_bits(expected, picture(bricked, scene));
    }
  }
}

}  // namespace rhoray::tests

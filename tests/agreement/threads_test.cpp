#include "tests/agreement/pictures.h"

namespace rhoray::tests {

namespace {

void expect_threads_change_nothing(const render::Dataset& dataset, render::Scene scene) {
  for (const render::Mode mode : {render::Mode::isosurface, render::Mode::mip}) {
    scene.layers[0].mode = mode;
    render::FrameOptions options{.width = 131, .height = 97, .channels = all_channels, .threads = 1};
    render::Framebuffer expected, found;
    const render::FrameStatistics one = render::render(dataset, scene, options, expected);
    EXPECT_EQ(one.rays, 131u * 97u);
    EXPECT_EQ(one.hits, hit_count(expected));
    for (const unsigned threads : {2u, 8u}) {
      options.threads = threads;
      const render::FrameStatistics many = render::render(dataset, scene, options, found);
      expect_same_bits(expected, found);
      EXPECT_EQ(one.macrocells_visited, many.macrocells_visited);
      EXPECT_EQ(one.cells_visited, many.cells_visited);
      EXPECT_EQ(one.cells_solved, many.cells_solved);
    }
  }
}

}  // namespace

TEST(Threads, one_two_and_eight_give_the_same_picture_and_counts) {
  const TemporaryFolder folder;
  const render::Dataset grid = packed(folder, "grid", noise_volume<std::int16_t>({40, 33, 50}, 20, 3));
  expect_threads_change_nothing(grid, oblique_scene(grid, 15.5));
  const render::Dataset mesh = packed(folder, "mesh", box_mesh({.cells = {8, 8, 8}, .jitter = 0.1}, product_field()));
  expect_threads_change_nothing(mesh, oblique_scene(mesh, 0.2));
}

}  // namespace rhoray::tests

// X05. Pictures of one pixel, of one row or column, of prime sizes and of more than 2^14 pixels on
// a side. Such sizes do not divide evenly into tiles and packets of rays; a wrong remainder reads
// or writes out of bounds.
#include <gtest/gtest.h>

#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"

namespace rhoray::tests {
namespace {

TEST(OddPictures, are_made_of_the_answers_to_single_rays) {
  const TemporaryFolder folder;
  const render::Dataset grid = packed(folder, "grid.rho", noise_volume<float>({9, 10, 11}, 6, 3));
  const render::Dataset mesh =
      packed(folder, "mesh.rho", box_mesh({.cells = {3, 4, 3}}, distance_field({0.5, 0.5, 0.5})));
  std::size_t left_over = 0;
  for (const auto& [dataset, isovalue] : {std::pair{&grid, 3.0}, {&mesh, 0.3}})
    for (const auto& [width, height] :
         {std::pair{1, 1}, {1, 7}, {13, 1}, {97, 89}, {16411, 1}, {1, 16411}, {2, 3001}, {1031, 3}}) {
      const render::Scene scene = oblique_scene(*dataset, isovalue);
      const render::Framebuffer made = picture(*dataset, scene, {.width = width, .height = height, .threads = 2});
      ASSERT_EQ(made.depth.size(), static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      render::RayCaster alone(*dataset, isovalue, {});
      std::size_t pixel = 0, hits = 0;
      for (const render::Ray& ray : render::camera_rays(*dataset, scene.camera, width, height)) {
        const render::Hit hit = alone.first_crossing(ray);
        hits += !hit.is_miss();
        ASSERT_EQ(made.depth[pixel], static_cast<float>(hit.t)) << width << " x " << height << ", " << pixel;
        ASSERT_EQ(made.cell[pixel], hit.is_miss() ? render::Framebuffer::no_cell : hit.cell);
        ++pixel;
      }
      EXPECT_GT(hits, 0U) << width << " x " << height;
      left_over += width % 8 != 0 && height % 8 != 0;
    }
  EXPECT_EQ(left_over, 16U) << "a size comes out even: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests

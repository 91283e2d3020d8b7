#include "preprocess/export_grid.h"
#include "preprocess/pack_colors.h"
#include "preprocess/pack_volume.h"
#include "tests/agreement/pictures.h"
#include "tests/preprocess/workers/vdb/support.h"
#include "tests/support/colors.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

class TexturedVdb : public Vdb {};

TEST_F(TexturedVdb, is_covered_as_the_packed_grid_of_the_same_samples) {
  const Affine turned{{0.1, 2, 0}, {3, 0, 0.1}, {0, 0.2, -0.7}, {10, 20, 30}};
  const auto hill = [](const Index3& s) {
    const Vec3 from_middle(static_cast<double>(s.x - 18), static_cast<double>(s.y - 10), static_cast<double>(s.z - 15));
    return static_cast<float>(20 - from_middle.length());
  };
  pack_volume(volume_of<float>({37, 21, 30}, hill, turned), folder_ / "a.rho");
  export_vdb(folder_ / "a.rho", folder_ / "a.vdb");
  pack_colors(colors_of({19, 11, 15}, 3, telling_texel,
                        {2.0 * turned.x_axis, 2.0 * turned.y_axis, 2.0 * turned.z_axis, turned.origin}),
              folder_ / "c.rho");
  const render::Dataset packed = render::Dataset::load(folder_ / "a.rho"), sparse = loaded(folder_ / "a.vdb");
  render::Scene scene = oblique_scene(packed, 10);
  scene.layers[0].material.texture = render::Texture::load(folder_ / "c.rho");
  const render::Framebuffer expected = picture(packed, scene), found = picture(sparse, scene);
  EXPECT_GT(hit_count(expected), 400U);
  ASSERT_EQ(found.cell, expected.cell);
  for (std::size_t i = 0; i < expected.color.size(); ++i) ASSERT_NEAR(found.color[i], expected.color[i], 1e-4);
  scene.layers[0].material.texture.reset();
  EXPECT_NE(picture(packed, scene).color, expected.color);
}

}  // namespace
}  // namespace rhoray::preprocess

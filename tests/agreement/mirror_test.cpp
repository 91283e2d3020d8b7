#include "tests/agreement/pictures.h"

namespace rhoray::tests {

namespace {

Affine mirrored_in_x(Affine map) {
  map.x_axis.x = -map.x_axis.x;
  map.y_axis.x = -map.y_axis.x;
  map.z_axis.x = -map.z_axis.x;
  map.origin.x = -map.origin.x;
  return map;
}

render::Camera mirrored_in_x(render::Camera camera) {
  camera.position.x = -camera.position.x;
  camera.target.x = -camera.target.x;
  camera.up.x = -camera.up.x;
  return camera;
}

/// Checks that the hits of `a` are those of `b` mirrored left to right.
void expect_turned(const render::Framebuffer& a, const render::Framebuffer& b) {
  EXPECT_GT(hit_count(a), 900u);
  std::size_t mask_differs = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const auto p = static_cast<std::size_t>(y * a.width + x),
                 q = static_cast<std::size_t>(y * a.width + a.width - 1 - x);
      const bool hit = a.cell[p] != render::Framebuffer::no_cell;
      if (hit != (b.cell[q] != render::Framebuffer::no_cell)) {
        ++mask_differs;
        continue;
      }
      if (!hit) continue;
      // Rounding of the float channel; the fields have no tangents here.
      ASSERT_NEAR(a.depth[p], b.depth[q], 1e-5 * a.depth[p]);
      ASSERT_NEAR(a.normal[3 * p], -b.normal[3 * q], 1e-4);
      ASSERT_NEAR(a.normal[3 * p + 1], b.normal[3 * q + 1], 1e-4);
      ASSERT_NEAR(a.normal[3 * p + 2], b.normal[3 * q + 2], 1e-4);
    }
  EXPECT_EQ(mask_differs, 0u);
}

}  // namespace

// The samples stay and the map into the world is mirrored, as in files with a negative direction.
TEST(Mirror, a_volume_with_a_mirrored_axis_gives_the_mirrored_picture) {
  const TemporaryFolder folder;
  const Index3 count(23, 31, 19);
  const Affine map{{0.9, 0.2, 0}, {-0.3, 1.1, 0.1}, {0.05, 0, 2}, {5, -3, 4}};
  const auto sample = [](const Index3& at) {
    return static_cast<float>(std::sin(0.3 * static_cast<double>(at.x)) + std::cos(0.2 * static_cast<double>(at.y)) +
                              0.1 * static_cast<double>(at.z));
  };
  const render::Dataset plain = packed(folder, "plain", volume_of<float>(count, sample, map));
  const render::Dataset mirrored = packed(folder, "mirrored", volume_of<float>(count, sample, mirrored_in_x(map)));
  render::Scene scene = oblique_scene(plain, 1.0);
  const render::Framebuffer expected = picture(plain, scene);
  scene.camera = mirrored_in_x(scene.camera);
  expect_turned(expected, picture(mirrored, scene));
}

// The samples are in the opposite order on an axis of the opposite direction: the same field, hence
// the same picture.
TEST(Mirror, reversed_samples_on_a_reversed_axis_give_the_same_picture) {
  const TemporaryFolder folder;
  const Index3 count(23, 31, 19);
  const Affine map{{0.9, 0.2, 0}, {-0.3, 1.1, 0.1}, {0.05, 0, 2}, {5, -3, 4}};
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return std::sin(0.3 * static_cast<double>(i)) + std::cos(0.2 * static_cast<double>(j)) +
           0.1 * static_cast<double>(k);
  };
  const render::Dataset plain = packed(folder, "plain",
                                       volume_of<double>(
                                           count, [&](const Index3& at) { return value(at.x, at.y, at.z); }, map));
  Affine reversed = map;
  reversed.origin += static_cast<double>(count.x - 1) * map.x_axis;
  reversed.x_axis = -map.x_axis;
  const render::Dataset other =
      packed(folder, "reversed",
             volume_of<double>(
                 count, [&](const Index3& at) { return value(count.x - 1 - at.x, at.y, at.z); }, reversed));
  const render::Scene scene = oblique_scene(plain, 1.0);
  const render::Framebuffer a = picture(plain, scene), b = picture(other, scene);
  EXPECT_GT(hit_count(a), 900u);
  std::size_t mask_differs = 0;
  for (std::size_t p = 0; p < a.pixel_count(); ++p) {
    const bool hit = a.cell[p] != render::Framebuffer::no_cell;
    mask_differs += hit != (b.cell[p] != render::Framebuffer::no_cell);
    if (hit) {
      ASSERT_NEAR(a.depth[p], b.depth[p], 1e-5 * a.depth[p]);
    }
  }
  EXPECT_EQ(mask_differs, 0u);
}

TEST(Mirror, a_mirrored_mesh_gives_the_mirrored_picture) {
  const TemporaryFolder folder;
  const auto mesh = box_mesh({.cells = {6, 7, 8}, .jitter = 0.15, .grading = 3}, distance_field({0.4, 0.5, 0.6}));
  auto other = mesh;
  for (auto& p : other.points) p[0] = -p[0];
  const render::Dataset plain = packed(folder, "plain", mesh), mirrored = packed(folder, "mirrored", other);
  render::Scene scene = oblique_scene(plain, 0.3);
  const render::Framebuffer expected = picture(plain, scene);
  scene.camera = mirrored_in_x(scene.camera);
  expect_turned(expected, picture(mirrored, scene));
}

}  // namespace rhoray::tests

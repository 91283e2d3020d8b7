#include "tests/agreement/pictures.h"

namespace rhoray::tests {

namespace {

/// The ray meets the plane where offset + slope . (eye + t direction) = isovalue.
void expect_plane(const render::Framebuffer& found, const render::Camera& camera, const Vec3& slope, double offset,
                  double isovalue, double tolerance) {
  std::size_t checked = 0;
  const Vec3 forward = (camera.target - camera.position).normalized(), right = forward.cross(camera.up).normalized(),
             down = forward.cross(right);
  for (int y = 0; y < found.height; ++y)
    for (int x = 0; x < found.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * found.width + x);
      if (found.cell[pixel] == render::Framebuffer::no_cell) continue;
      const double half = camera.orthographic_height / 2;
      const Vec3 eye = camera.position + half * ((2 * x + 1.0) / found.width - 1) * right +
                       half * ((2 * y + 1.0) / found.height - 1) * down;
      const double t = (isovalue - offset - slope.dot(eye)) / slope.dot(forward);
      ASSERT_NEAR(found.depth[pixel], t, tolerance);
      const Vec3 normal(found.normal[3 * pixel], found.normal[3 * pixel + 1], found.normal[3 * pixel + 2]);
      const Vec3 expected = slope.normalized() * (slope.dot(forward) > 0 ? -1 : 1);
      ASSERT_NEAR((normal - expected).length(), 0, 1e-6);  // the channel is a float
      ++checked;
    }
  EXPECT_GT(checked, 400u);
}

}  // namespace

// Trilinear and tetrahedral interpolation both reproduce a linear field, so all three computations
// yield one plane.
TEST(LinearField, looks_the_same_in_tetrahedra_in_a_grid_and_in_closed_form) {
  const TemporaryFolder folder;
  const Box3 box({-2, 1, 5}, {1, 3, 9});
  const Index3 count(14, 17, 12);
  int planes = 0;
  for (const Vec3& slope : {Vec3(1, 0, 0), Vec3(0, -2, 0), Vec3(0.3, 0.4, 0.9), Vec3(-5, 0.01, 2)}) {
    const Field field = linear_field(slope, 0.7);
    const render::Dataset grid =
        packed(folder, concat("g", planes), sampled_volume<double>(count, lattice_over(box, count), field));
    const render::Dataset mesh =
        packed(folder, concat("m", planes), box_mesh({.cells = {7, 6, 5}, .box = box, .jitter = 0.15}, field));
    ++planes;
    const double isovalue = field(box.center()) + 0.01;
    const render::Scene scene = oblique_scene(grid, isovalue, true);
    const render::Framebuffer from_grid = picture(grid, scene), from_mesh = picture(mesh, scene);
    // Depths are about 10 and floats have 24 bits, so the channel itself rounds by 1e-6.
    expect_plane(from_grid, scene.camera, slope, 0.7, isovalue, 2e-6);
    expect_plane(from_mesh, scene.camera, slope, 0.7, isovalue, 2e-6);

    // Both data sets end at the same box. Only a ray through its very edge may hit one and miss the
    // other by rounding.
    std::size_t differ = 0;
    for (std::size_t pixel = 0; pixel < from_grid.pixel_count(); ++pixel)
      differ += (from_grid.cell[pixel] == render::Framebuffer::no_cell) !=
                (from_mesh.cell[pixel] == render::Framebuffer::no_cell);
    EXPECT_EQ(differ, 0u);
  }
}

TEST(LinearField, has_its_maximum_where_the_ray_enters_or_leaves_the_box) {
  const TemporaryFolder folder;
  const Box3 box({0, 0, 0}, {1, 1, 1});
  const Field field = linear_field({0.3, -0.4, 0.9}, 2);
  const Index3 count(9, 9, 9);
  const render::Dataset grid = packed(folder, "g", sampled_volume<double>(count, lattice_over(box, count), field));
  const render::Dataset mesh = packed(folder, "m", box_mesh({.cells = {4, 4, 4}, .jitter = 0.15}, field));
  render::Scene scene = oblique_scene(grid, 0, true);
  scene.layers[0].mode = render::Mode::mip;
  const render::Framebuffer from_grid = picture(grid, scene), from_mesh = picture(mesh, scene);
  EXPECT_GT(hit_count(from_grid), 3000u);
  std::size_t differ = 0;
  for (std::size_t pixel = 0; pixel < from_grid.pixel_count(); ++pixel) {
    const bool hit_grid = from_grid.cell[pixel] != render::Framebuffer::no_cell;
    differ += hit_grid != (from_mesh.cell[pixel] != render::Framebuffer::no_cell);
    if (!hit_grid || from_mesh.cell[pixel] == render::Framebuffer::no_cell) continue;
    // A few roundings of values near 3.
    ASSERT_NEAR(from_grid.value[pixel], from_mesh.value[pixel], 1e-12);
  }
  EXPECT_EQ(differ, 0u);
}

}  // namespace rhoray::tests

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "preprocess/pack_surface.h"
#include "tests/agreement/pictures.h"
#include "tests/support/surfaces.h"

/// Light on triangles, and their shadows: the same ball as a grid's isosurface and as triangles.
namespace rhoray::tests {
namespace {

using render::Layer;
using render::Light;
using render::Mode;
using render::Scene;

constexpr int edge = 128;
constexpr double radius = 0.4;

struct Shown {
  TemporaryFolder folder;
  /// A floor at z = -0.5, the ball in a grid, the ball of triangles: smaller by up to 3e-5.
  std::vector<render::Dataset> datasets;

  Shown() {
    const auto grid = [&](const char* name, std::int64_t edge_samples, const Box3& box, const Field& field) {
      const Index3 samples(edge_samples, edge_samples, edge_samples);
      return packed(folder, name, sampled_volume<double>(samples, lattice_over(box, samples), field));
    };
    datasets.push_back(grid("floor.rho", 7, {{-9, -9, -9}, {9, 9, 9}}, linear_field({0, 0, 1})));
    datasets.push_back(grid("grid.rho", 81, {Vec3(-0.45), Vec3(0.45)}, [](const Vec3& p) { return -p.dot(p); }));
    preprocess::pack_surface(moved(round_surface(6), Vec3(0), radius), folder / "ball.rho");
    datasets.push_back(render::Dataset::load(folder / "ball.rho"));
  }
};

Layer floor_layer() {
  Layer layer{.dataset = 0, .isovalue = -0.5, .method = render::method_of(render::Accuracy::float32)};
  layer.material = {.color = {1, 1, 1}, .ambient = 0.25, .specular = 0};
  return layer;
}

Layer ball_layer(bool of_triangles, double opacity) {
  Layer layer = floor_layer();
  layer.material.opacity = opacity;
  layer.material.color = {1, 0.5, 0.25};
  layer.dataset = of_triangles ? 2 : 1;
  layer.isovalue = of_triangles ? 0 : -radius * radius;
  if (!of_triangles) return layer;
  layer.mode = Mode::triangles;
  layer.material.normals = render::Normals::smooth;
  return layer;
}

struct Picture {
  render::Framebuffer pixels;
  render::FrameStatistics statistics;
};

Picture picture_of(const Shown& shown, const Scene& scene, unsigned threads = 1) {
  Picture picture;
  picture.statistics =
      render::render(shown.datasets, scene,
                     {.width = edge, .height = edge, .channels = all_channels, .threads = threads}, picture.pixels);
  return picture;
}

Scene scene_of(bool of_triangles, const std::vector<Light>& lights, double opacity = 1) {
  Scene scene;
  scene.layers = {floor_layer(), ball_layer(of_triangles, opacity)};
  scene.lights = lights;
  scene.camera =
      render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 33, .elevation_deg = 31, .zoom = 1.2}, 1);
  scene.background = {0, 0, 0};
  return scene;
}

Light sun(double size = 0) {
  return {.kind = Light::Kind::directional, .place = {1, -0.7, 1.9}, .casts_shadows = true, .size = size};
}

struct Difference {
  std::size_t pixels = 0;  ///< that differ by more than 0.02 of white
  double mean = 0;         ///< of all hits
};

Difference difference_of(const Picture& a, const Picture& b) {
  Difference difference;
  std::size_t count = 0;
  for (std::size_t p = 0; p < a.pixels.pixel_count(); ++p) {
    if (!(a.pixels.depth[p] < std::numeric_limits<float>::infinity())) continue;
    double most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(double{a.pixels.color[4 * p + c]} - double{b.pixels.color[4 * p + c]}));
    difference.pixels += most > 0.02, difference.mean += most, ++count;
  }
  difference.mean /= static_cast<double>(count);
  return difference;
}

TEST(LitTriangles, throw_and_receive_the_shadows_of_the_isosurface_that_they_stand_for) {
  const Shown shown;
  const Light lamp{.kind = Light::Kind::point, .place = {0.3, 0.2, 1.1}, .casts_shadows = true};
  for (const std::vector<Light>& lights : {std::vector{sun()}, std::vector{sun(), lamp}, std::vector{sun(12)}}) {
    const Picture of_grid = picture_of(shown, scene_of(false, lights)),
                  of_triangles = picture_of(shown, scene_of(true, lights));
    const Difference difference = difference_of(of_grid, of_triangles);
    EXPECT_LT(difference.pixels, of_grid.statistics.hits / 100) << "at the edges of shadows";
    EXPECT_LT(difference.mean, 0.001);
    const double rays = static_cast<double>(of_grid.statistics.shadow_rays);
    EXPECT_GT(rays, 3000);
    EXPECT_NEAR(static_cast<double>(of_triangles.statistics.shadow_rays) / rays, 1, 0.01);
    // Without the ball there would be no shadow: the agreement of the pictures is not trivial.
    Scene floor_alone = scene_of(false, lights);
    floor_alone.layers.pop_back();
    EXPECT_GT(difference_of(picture_of(shown, floor_alone), of_grid).pixels, 400U);
  }
}

TEST(LitTriangles, hold_ambient_light_back_as_the_isosurface_does) {
  const Shown shown;
  Picture pictures[2];
  for (const bool of_triangles : {false, true}) {
    Scene scene = scene_of(of_triangles, {{}});
    scene.occlusion = {.samples = 16, .radius = 0.6};
    pictures[of_triangles] = picture_of(shown, scene);
    EXPECT_EQ(pictures[of_triangles].statistics.occlusion_rays, 16 * pictures[of_triangles].statistics.hits);
  }
  const Difference difference = difference_of(pictures[0], pictures[1]);
  EXPECT_LT(difference.pixels, pictures[0].statistics.hits / 100);
  EXPECT_LT(difference.mean, 0.001);
}

TEST(LitTriangles, that_are_clear_show_what_is_behind_as_the_isosurface_does) {
  const Shown shown;
  const Picture of_grid = picture_of(shown, scene_of(false, {sun()}, 0.4)),
                of_triangles = picture_of(shown, scene_of(true, {sun()}, 0.4));
  const Difference difference = difference_of(of_grid, of_triangles);
  EXPECT_LT(difference.pixels, of_grid.statistics.hits / 100);
  EXPECT_LT(difference.mean, 0.001);
  EXPECT_GT(of_grid.statistics.rays_through, 1000U);
  EXPECT_NEAR(static_cast<double>(of_triangles.statistics.rays_through),
              static_cast<double>(of_grid.statistics.rays_through),
              0.01 * static_cast<double>(of_grid.statistics.rays_through));
}

TEST(LitTriangles, are_the_same_for_any_number_of_threads) {
  const Shown shown;
  Scene scene = scene_of(true, {sun(9), {}});
  scene.occlusion = {.samples = 3, .radius = 0.6};
  const Picture one = picture_of(shown, scene), three = picture_of(shown, scene, 3);
  expect_same_bits(one.pixels, three.pixels);
  EXPECT_EQ(one.statistics.shadow_rays, three.statistics.shadow_rays);
}

}  // namespace
}  // namespace rhoray::tests

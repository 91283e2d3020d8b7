#include <gtest/gtest.h>

#include <cmath>

#include "render/ray_caster.h"
#include "tests/render/frame/clipped_pictures.h"

/// Lights together with clip regions.
namespace rhoray::tests {
namespace {

using namespace clipped;
using render::Ray;

/// A ball of radius 0.5 over a plate, both fields on one lattice, and a directional light above.
struct Sundial {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;
  Scene scene;

  Sundial() {
    const Index3 samples(65, 65, 65);
    const auto add = [&](const char* name, const Field& field) {
      datasets.push_back(packed(folder, name, sampled_volume<float>(samples, lattice_over(cube, samples), field)));
    };
    add("ball.rho", [](const Vec3& p) { return 0.25 - (p - Vec3(0, 0, 0.4)).length2(); });
    add("plate.rho", [](const Vec3& p) { return -0.9 - p.z; });
    scene = scene_of({surface(0, 0, render::Accuracy::float32), surface(1, 0, render::Accuracy::float32)});
    scene.lights = {{.kind = render::Light::Kind::directional, .place = {0, 0, 1}, .casts_shadows = true}};
    scene.camera = render::fit_camera(cube, {.azimuth_deg = 0, .elevation_deg = 30}, 1);
    for (Layer& layer : scene.layers) layer.material = {.ambient = 0.2, .specular = 0};
  }
};

TEST(ClippedLight, lets_light_through_what_is_clipped_away) {
  const Sundial dial;
  const std::vector<Ray> rays = camera_rays(dial.datasets[1], dial.scene.camera, edge, edge);
  const Affine& world = world_from_ray_frame(dial.datasets[1]);
  for (const bool plate_is_clipped : {true, false})
    for (const bool cuts_away : {false, true}) {
      // The half of the ball at x > 0.1, or the other one. What remains of the ball is a bowl,
      // which casts the same shadow as its half of the ball.
      Scene scene = dial.scene;
      scene.clip = Clip{.box = Box3({0.1, -3, plate_is_clipped ? -0.5 : -3}, {3, 3, 3}), .cuts_away = cuts_away};
      scene.layers[1].clipped = plate_is_clipped && cuts_away;
      const Picture found = picture_of(dial.datasets, scene);
      std::size_t lit = 0, dark = 0;
      for (std::size_t p = 0; p < rays.size(); ++p) {
        const Vec3 place = world.point(rays[p].at(static_cast<double>(found.pixels.depth[p])));
        if (!(std::abs(place.z + 0.9) < 1e-3)) continue;  // not the plate
        const double radius = std::hypot(place.x, place.y);
        if (std::abs(radius - 0.5) < 0.02 || std::abs(place.x - 0.1) < 0.02) continue;
        const bool is_dark = radius < 0.5 && (place.x > 0.1) != cuts_away;
        EXPECT_NEAR(found.pixels.color[4 * p], 0.78 * (is_dark ? 0.2 : 1), 0.01) << place.x << ' ' << place.y;
        (is_dark ? dark : lit) += 1;
      }
      EXPECT_GT(lit, 300);
      EXPECT_GT(dark, 60);
      EXPECT_GT(found.statistics.shadow_rays, 500);
    }
}

TEST(ClippedLight, makes_no_spots_on_surfaces_under_lights) {
  // Rays towards lights start on the surface, some of them in the region's faces: no surface may
  // shadow itself.
  const TemporaryFolder folder;
  const Index3 samples(33, 33, 33);
  std::vector<render::Dataset> datasets;
  datasets.push_back(packed(folder, "plate.rho",
                            sampled_volume<float>(samples, lattice_over(cube, samples), linear_field({0.1, 0.2, -1}))));
  for (const bool cuts_away : {false, true})
    for (const double place : {0.0, 0.01, -0.3}) {
      Scene scene =
          scene_of({surface(0, 0, render::Accuracy::float32)},
                   Clip{.planes = {{{0, 0, place}, {0.1, 0.2, cuts_away ? 1.0 : -1.0}}}, .cuts_away = cuts_away});
      scene.lights = {{.kind = render::Light::Kind::directional, .place = {-1, -1, 2}, .casts_shadows = true}};
      scene.occlusion.radius = 0.3;
      Scene unlit = scene;
      unlit.lights[0].casts_shadows = false;
      unlit.occlusion.radius = 0;
      const Picture found = picture_of(datasets, scene), expected = picture_of(datasets, unlit);
      for (std::size_t i = 0; i < found.pixels.color.size(); ++i)
        ASSERT_NEAR(found.pixels.color[i], expected.pixels.color[i], 1e-5) << i;
    }
}

}  // namespace
}  // namespace rhoray::tests

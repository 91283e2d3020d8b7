#include "render/effects/effects.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rhoray::tests {
namespace {

using render::EffectSet;
using render::Mode;
using render::Scene;

Scene surface_scene() {
  Scene scene;
  scene.surface = {.color = {0.5, 0.25, 1}, .ambient = 0.2, .specular = 0.4, .shininess = 10};
  return scene;
}

TEST(EffectsCalledFor, are_read_from_the_scene) {
  Scene scene = surface_scene();
  EffectSet set = effects_called_for(scene);
  EXPECT_TRUE(set.diffuse && set.specular && !set.intensity);
  scene.surface.specular = 0;
  EXPECT_FALSE(effects_called_for(scene).specular);
  scene.surface.specular = 1;
  scene.mode = Mode::mip;
  set = effects_called_for(scene);
  EXPECT_TRUE(!set.diffuse && !set.specular && set.intensity);
}

TEST(Shade, lights_a_surface_by_the_angle_to_the_eye) {
  Scene scene = surface_scene();
  const Vec3 eye(0, 0, 1), tilted = Vec3(0, std::sqrt(0.75), 0.5);
  const EffectSet dull{.diffuse = true};
  EXPECT_LT((shade(scene, dull, {eye, eye, 0}) - scene.surface.color).length(), 1e-15);
  EXPECT_LT((shade(scene, dull, {tilted, eye, 0}) - 0.6 * scene.surface.color).length(), 1e-15);
  const Vec3 highlight =
      shade(scene, effects_called_for(scene), {tilted, eye, 0}) - shade(scene, dull, {tilted, eye, 0});
  const double expected = 0.4 * std::pow(0.5, 10);
  EXPECT_LT((highlight - Vec3(expected, expected, expected)).length(), 1e-15);
}

TEST(Shade, lights_a_hit_without_gradient_as_if_it_faced_the_eye) {
  const Scene scene = surface_scene();
  EXPECT_EQ(shade(scene, effects_called_for(scene), {{0, 0, 0}, {0, 0, 1}, 0}),
            shade(scene, effects_called_for(scene), {{0, 0, 1}, {0, 0, 1}, 0}));
}

TEST(Shade, shows_a_projection_as_even_steps_of_grey) {
  Scene scene;
  scene.mode = Mode::mip;
  scene.window = {.lo = 100, .hi = 300};
  const auto grey = [&](double value) { return shade(scene, effects_called_for(scene), {{}, {0, 0, 1}, value}); };
  EXPECT_EQ(grey(100), Vec3(0, 0, 0));
  EXPECT_EQ(grey(50), Vec3(0, 0, 0));
  EXPECT_EQ(grey(300), Vec3(1, 1, 1));
  EXPECT_EQ(grey(999), Vec3(1, 1, 1));
  // Half of the window is half of the sRGB code: its linear light by the standard's formula.
  EXPECT_NEAR(grey(200).x, std::pow((0.5 + 0.055) / 1.055, 2.4), 1e-15);
  EXPECT_NEAR(grey(104).x, 0.02 / 12.92, 1e-15);
  scene.window = {.lo = 5, .hi = 5};
  EXPECT_EQ(grey(4), Vec3(0, 0, 0));
  EXPECT_EQ(grey(5), Vec3(1, 1, 1));
}

}  // namespace
}  // namespace rhoray::tests

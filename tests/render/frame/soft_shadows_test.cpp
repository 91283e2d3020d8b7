#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "formats/base/error.h"
#include "render/frame/camera_rays.h"
#include "tests/render/frame/lit_pictures.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/expect_error.h"

/// Shadows of lights with a size: how much of a light is visible from each point.
namespace rhoray::tests {
namespace {

using namespace lit;

constexpr double floor_height = -0.5;

render::Dataset grid_of(const TemporaryFolder& folder, const char* name, std::int64_t samples, const Box3& box,
                        const Field& field) {
  const Index3 count(samples, samples, samples);
  return packed(folder, name, sampled_volume<double>(count, lattice_over(box, count), field));
}

Scene scene_of(const std::vector<Layer>& layers, const Light& light) {
  Scene scene;
  scene.layers = layers;
  scene.lights = {light};
  scene.camera =
      render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 90, .elevation_deg = 35, .zoom = 1.3}, 1);
  scene.background = {0, 0, 0};
  return scene;
}

Light sun(double degrees, int samples = 16) {
  return {
      .kind = Light::Kind::directional, .place = {0, 0, 1}, .casts_shadows = true, .size = degrees, .samples = samples};
}

Light lamp(const Vec3& place, double radius, int samples = 16) {
  return {.kind = Light::Kind::point, .place = place, .casts_shadows = true, .size = radius, .samples = samples};
}

/// Returns the share of the directions in a uniformly filled cone for which is_so is true, by
/// counting many of them.
double share_of_cone(const Vec3& axis, double half_angle, const std::function<bool(const Vec3&)>& is_so) {
  constexpr int heights = 40, turns = 90;
  const Vec3 across = (std::abs(axis.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).cross(axis).normalized(),
             along = axis.cross(across);
  int count = 0;
  for (int h = 0; h < heights; ++h)
    for (int k = 0; k < turns; ++k) {
      const double z = 1 - (1 - std::cos(half_angle)) * (h + 0.5) / heights, r = std::sqrt(1 - z * z),
                   turn = 2 * std::numbers::pi * (k + 0.5) / turns;
      count += is_so(z * axis + r * std::cos(turn) * across + r * std::sin(turn) * along);
    }
  return static_cast<double>(count) / (heights * turns);
}

struct Errors {
  double sum = 0, largest = 0;
  std::size_t count = 0, partly = 0;

  void add(double found, double share) {
    sum += found - share, largest = std::max(largest, std::abs(found - share));
    ++count, partly += share > 0.01 && share < 0.99;
  }
  double mean() const { return std::abs(sum / static_cast<double>(count)); }
};

/// For the floor's pixels: the share of the light that is shown, minus the true one.
Errors errors_on_floor(const Scene& scene, const Picture& shadowed, const Picture& plain, int every,
                       const std::function<double(const Vec3&)>& share) {
  const render::CameraRays rays(scene.camera, edge, edge);
  Errors errors;
  for (std::size_t p = 0; p < plain.pixels.pixel_count(); p += static_cast<std::size_t>(every)) {
    if (!plain.is_hit(p)) continue;
    const Vec3 place = rays.through_pixel(static_cast<int>(p % edge), static_cast<int>(p / edge))
                           .at(static_cast<double>(plain.pixels.depth[p]));
    if (std::abs(place.z - floor_height) > 1e-4) continue;
    errors.add((shadowed.red(p) - 0.25) / (plain.red(p) - 0.25), share(place));
  }
  return errors;
}

Scene without_shadows(Scene scene) {
  for (Light& light : scene.lights) light.casts_shadows = false;
  return scene;
}

// A sheet over one half of a floor, under a large directional light above: the hidden part of the
// light is beyond a chord.
TEST(SoftShadows, of_half_a_plane_leave_the_share_of_the_sun_that_its_edge_does) {
  const TemporaryFolder folder;
  const Field height = linear_field({0, 0, 1});
  const std::vector<render::Dataset> datasets{grid_of(folder, "floor.rho", 7, {{-9, -9, -9}, {9, 9, 9}}, height),
                                              grid_of(folder, "sheet.rho", 7, {{-9, -9, 0}, {0, 9, 0.4}}, height)};
  constexpr double degrees = 24, sheet_height = 0.2 - floor_height;
  const double half_angle = degrees / 2 * std::numbers::pi / 180;
  for (const int samples : {16, 256}) {
    const Scene scene = scene_of({matte(0, floor_height), matte(1, 0.2)}, sun(degrees, samples));
    const Picture with = picture_of(datasets, scene), plain = picture_of(datasets, without_shadows(scene));
    const Errors errors = errors_on_floor(scene, with, plain, 1, [&](const Vec3& place) {
      return share_of_cone({0, 0, 1}, half_angle,
                           [&](const Vec3& way) { return place.x + sheet_height * way.x / way.z > 0; });
    });
    EXPECT_GT(errors.count, 1500U);
    EXPECT_GT(errors.partly, 250U);
    EXPECT_LT(errors.mean(), 0.003) << samples;
    EXPECT_LT(errors.largest, samples == 16 ? 0.2 : 0.03) << samples;
  }
}

/// A ball of radius 0.4 about the origin over a floor.
std::vector<render::Dataset> ball_over_floor(const TemporaryFolder& folder) {
  return {grid_of(folder, "floor.rho", 7, {{-9, -9, -9}, {9, 9, 9}}, linear_field({0, 0, 1})),
          grid_of(folder, "ball.rho", 81, {{-0.45, -0.45, -0.45}, {0.45, 0.45, 0.45}},
                  [](const Vec3& p) { return -p.dot(p); })};
}

TEST(SoftShadows, of_a_ball_leave_the_share_of_a_lamp_that_it_does_not_hide) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = ball_over_floor(folder);
  for (const Light& light : {lamp({0.2, 0.1, 1.3}, 0.3, 64), lamp({0, 0, 0.9}, 0.45, 64), sun(20, 64)}) {
    const bool is_sun = light.kind == Light::Kind::directional;
    const Scene scene = scene_of({matte(0, floor_height), matte(1, -0.16)}, light);
    const Picture with = picture_of(datasets, scene), plain = picture_of(datasets, without_shadows(scene));
    const Errors errors = errors_on_floor(scene, with, plain, 5, [&](const Vec3& place) {
      const Vec3 to_light = is_sun ? light.place : light.place - place;
      const double half_angle =
          is_sun ? light.size / 2 * std::numbers::pi / 180 : std::asin(light.size / to_light.length());
      return share_of_cone(to_light.normalized(), half_angle, [&](const Vec3& way) {
        const double nearest = std::max(0.0, -place.dot(way));
        return (place + nearest * way).length() > 0.4;
      });
    });
    EXPECT_GT(errors.count, 350U);
    EXPECT_GT(errors.partly, 40U);
    EXPECT_LT(errors.mean(), 0.005);
    EXPECT_LT(errors.largest, 0.1);
  }
}

TEST(SoftShadows, of_a_light_without_a_size_are_sharp_by_one_ray) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = ball_over_floor(folder);
  Scene scene = scene_of({matte(0, floor_height), matte(1, -0.16)}, sun(0, 1));
  const Picture one = picture_of(datasets, scene);
  scene.lights[0].samples = 4096;
  const Picture many = picture_of(datasets, scene);
  expect_same_bits(one.pixels, many.pixels);
  EXPECT_EQ(many.statistics.shadow_rays, one.statistics.shadow_rays);
  EXPECT_GT(one.statistics.shadow_rays, 1000U);
  EXPECT_LE(one.statistics.shadow_rays, one.statistics.hits);
}

// They also do not darken a plane without occluders, however low the light: points of the light
// below the plane get no rays.
TEST(SoftShadows, take_as_many_rays_as_said_and_leave_a_plane_as_it_is) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = ball_over_floor(folder);
  for (const auto& [place, is_whole] : {std::pair{Vec3(0.3, -0.2, 1), true}, {Vec3(5, -1, 0.4), false}}) {
    Scene scene = scene_of({matte(0, floor_height)}, sun(30, 7));
    scene.lights[0].place = place;
    const Picture soft = picture_of(datasets, scene), plain = picture_of(datasets, without_shadows(scene));
    EXPECT_TRUE(equal_bytes(soft.pixels.color, plain.pixels.color));
    EXPECT_EQ(plain.statistics.shadow_rays, 0U);
    if (is_whole)
      EXPECT_EQ(soft.statistics.shadow_rays, 7 * soft.statistics.hits);
    else
      EXPECT_LT(soft.statistics.shadow_rays, 6 * soft.statistics.hits);
    EXPECT_GT(soft.statistics.shadow_rays, 3 * soft.statistics.hits);
  }
}

TEST(SoftShadows, are_the_same_for_any_number_of_threads) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = ball_over_floor(folder);
  Scene scene = scene_of({matte(0, floor_height), matte(1, -0.16)}, sun(10, 5));
  scene.lights.push_back(lamp({0.4, -0.5, 0.7}, 0.1, 3));
  scene.layers[1].material.opacity = 0.5;
  scene.layers.push_back(matte(1, -0.09));
  const Picture one = picture_of(datasets, scene), three = picture_of(datasets, scene, 3);
  expect_same_bits(one.pixels, three.pixels);
  EXPECT_EQ(one.statistics.shadow_rays, three.statistics.shadow_rays);
  render::Framebuffer refined;
  render::RenderContext memory;
  render::refine(datasets, scene, {.width = edge, .height = edge, .channels = all_channels}, {.first_spacing = 4},
                 refined, memory);
  expect_same_bits(one.pixels, refined);
}

TEST(SoftShadows, are_refused_where_a_size_makes_no_sense) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = ball_over_floor(folder);
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const Light& light : {sun(-1), sun(181), sun(nan), lamp({0, 0, 1}, -1), lamp({0, 0, 1}, infinity),
                             lamp({0, 0, 1}, nan), sun(1, 0), sun(1, 4097)})
    expect_error(ErrorCode::usage, "a light of size",
                 [&] { picture_of(datasets, scene_of({matte(0, floor_height)}, light)); });
}

}  // namespace
}  // namespace rhoray::tests

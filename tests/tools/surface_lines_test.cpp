#include "tools/pictures/surface_lines.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/blank_picture.h"
#include "tools/pictures/annotate.h"

/// Lines that lie in surfaces, drawn over finished pictures.
namespace rhoray::tests {
namespace {

using namespace tools;

TEST(SurfaceLines, are_hidden_behind_what_is_nearer_and_have_no_rims) {
  const render::Camera camera =
      render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 30, .elevation_deg = 20}, 1);
  const Projection projection(camera, 400, 400);
  const Vec3 near(0.4, -1, 0), far(0.4, 1, 0), up(0, 0, 0.5);
  const Seen near_seen = projection.of(near), far_seen = projection.of(far);
  render::Framebuffer picture = blank(400, 400, 0.6F);
  for (float& depth : picture.depth) depth = static_cast<float>((near_seen.distance + far_seen.distance) / 2);
  annotate({.camera = camera, .surface_lines = {{{{near - up, near + up}, {far - up, far + up}}, {0, 0, 0}}}}, blocks,
           picture);
  double darkest = 1, brightest = 0;
  const auto y = static_cast<int>(near_seen.at.y);
  for (int x = static_cast<int>(near_seen.at.x) - 5; x <= static_cast<int>(near_seen.at.x) + 5; ++x) {
    darkest = std::min(darkest, color_at(picture, x, y).x);
    brightest = std::max(brightest, color_at(picture, x, y).x);
  }
  EXPECT_LT(darkest, 0.4);
  EXPECT_FLOAT_EQ(static_cast<float>(brightest), 0.6F);
  EXPECT_FLOAT_EQ(
      static_cast<float>(color_at(picture, static_cast<int>(far_seen.at.x), static_cast<int>(far_seen.at.y)).x), 0.6F);
}

TEST(SurfaceLines, of_many_pieces_are_as_thin_as_one) {
  const render::Camera camera =
      render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 30, .elevation_deg = 20}, 1);
  const Vec3 from(-0.7, -0.3, -0.6), way(1.2, 0.4, 1.1);
  SurfaceLines whole{{{from, from + way}}, {0, 0, 0}}, pieces{{}, {0, 0, 0}};
  constexpr int count = 1500;  // each shorter than a pixel
  for (int i = 0; i < count; ++i)
    pieces.lines.push_back({from + (static_cast<double>(i) / count) * way, from + ((i + 1.0) / count) * way});
  render::Framebuffer one = blank(400, 400), many = blank(400, 400);
  annotate({.camera = camera, .surface_lines = {whole}}, blocks, one);
  annotate({.camera = camera, .surface_lines = {pieces}}, blocks, many);
  double darkness = 0;
  for (std::size_t i = 0; i < one.color.size(); ++i) {
    EXPECT_NEAR(one.color[i], many.color[i], 1e-4) << i;
    darkness += i % 4 == 0 ? 1 - static_cast<double>(one.color[i]) : 0;
  }
  EXPECT_GT(darkness, 150) << "a line of some 200 pixels was drawn";
}

TEST(SurfaceLines, that_begin_behind_the_eye_are_drawn_in_front_of_it) {
  render::Camera camera;
  camera.position = {0, 0, 0}, camera.target = {1, 0, 0}, camera.up = {0, 0, 1};
  render::Framebuffer picture = blank(200, 200);
  annotate({.camera = camera,
            .surface_lines = {{{{Vec3(-5, 0.5, 0), Vec3(20, 0.5, 0)}, {Vec3(-5, -1, 0), Vec3(-1, -1, 0)}}, {0, 0, 0}}}},
           blocks, picture);
  const Projection projection(camera, 200, 200);
  for (const double x : {3.0, 5.0, 10.0}) {
    const Spot at = projection.of({x, 0.5, 0}).at;
    EXPECT_LT(std::min(color_at(picture, static_cast<int>(at.x), static_cast<int>(at.y)).x,
                       color_at(picture, static_cast<int>(at.x), static_cast<int>(at.y) - 1).x),
              0.6)
        << x;
  }
  const Spot mirrored = projection.of({3, -1, 0}).at;
  EXPECT_EQ(color_at(picture, static_cast<int>(mirrored.x), static_cast<int>(mirrored.y)).x, 1);
}

}  // namespace
}  // namespace rhoray::tests

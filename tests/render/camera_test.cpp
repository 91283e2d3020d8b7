#include "render/camera.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "formats/base/box_corners.h"
#include "formats/base/error.h"
#include "render/frame/camera_rays.h"

namespace rhoray::tests {
namespace {

using render::Camera;
using render::CameraRays;
using render::fit_camera;
using render::named_view;
using render::View;

const std::array<std::string_view, 7> names{"iso", "+x", "-x", "+y", "-y", "+z", "-z"};

template <class Act>
void expect_usage_error(Act act) {
  try {
    act();
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage) << error.what();
  }
}

/// Returns the position of a point in the picture: across and up, each from -1 to 1.
std::array<double, 2> place_in_picture(const Camera& camera, double aspect, const Vec3& p) {
  const Vec3 forward = (camera.target - camera.position).normalized();
  const Vec3 right = forward.cross(camera.up).normalized(), above = right.cross(forward);
  const Vec3 q = p - camera.position;
  const double half = camera.orthographic ? camera.orthographic_height / 2
                                          : q.dot(forward) * std::tan(camera.vertical_fov_deg * std::numbers::pi / 360);
  return {q.dot(right) / (half * aspect), q.dot(above) / half};
}

/// The rectangle around points in the picture: across and up, each from -1 to 1.
Box3 rectangle_around(const Camera& camera, double aspect, std::span<const Vec3> points) {
  Box3 rectangle;
  for (const Vec3& p : points) {
    EXPECT_GT((p - camera.position).dot(camera.target - camera.position), 0) << "behind the eye";
    const auto [x, y] = place_in_picture(camera, aspect, p);
    rectangle.extendBy(Vec3(x, y, 0));
  }
  return rectangle;
}

TEST(FitCamera, puts_points_into_the_middle_and_fills_nine_tenths_of_the_width_or_height) {
  std::vector<std::vector<Vec3>> clouds;
  for (const Box3& box : {Box3({-1, -2, -3}, {4, 2, 1}), Box3({100, 100, 100}, {101, 120, 100.5}),
                          Box3({0, 0, 0}, {1e-6, 2e-6, 3e-6}), Box3({-1e6, 5, 7}, {1e6, 6, 9})}) {
    const auto corners = corners_of(box);
    clouds.emplace_back(corners.begin(), corners.end());
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (std::vector<Vec3>& cloud : std::vector<std::vector<Vec3>>(4)) {
    for (int i = 0; i < 30; ++i) cloud.emplace_back(share(random), 2 * share(random), share(random) * share(random));
    clouds.push_back(cloud);
  }
  for (const std::vector<Vec3>& points : clouds)
    for (const std::string_view name : names)
      for (const double aspect : {0.3, 1.0, 16.0 / 9})
        for (const bool orthographic : {false, true})
          for (const double fov : {5.0, 30.0, 120.0}) {
            if (fov > 90 && points.size() > 8) continue;  // the eye would be at the nearest point
            View view = named_view(name);
            view.orthographic = orthographic;
            view.vertical_fov_deg = fov;
            const Box3 seen = rectangle_around(fit_camera_to(points, view, aspect), aspect, points);
            const Vec3 size = seen.size(), middle = seen.center();
            EXPECT_NEAR(std::max(size.x, size.y), 2 * 0.9, 1e-6) << name << ' ' << fov;
            EXPECT_NEAR(middle.x, 0, 1e-6) << name << ' ' << fov;
            EXPECT_NEAR(middle.y, 0, 1e-6) << name << ' ' << fov;
          }
}

TEST(FitCamera, keeps_the_sides_of_the_picture_free) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < 30; ++i) points.emplace_back(share(random), 2 * share(random), share(random) * share(random));
  for (const bool orthographic : {false, true})
    for (const double aspect : {0.5, 2.0})
      for (const double zoom : {0.5, 1.0})
        for (const double right : {0.0, 0.2}) {
          View view{.zoom = zoom, .orthographic = orthographic, .free_left = 0.1, .free_right = right};
          const Box3 seen = rectangle_around(fit_camera_to(points, view, aspect), aspect, points);
          // In a picture of 2 by 2, what is left begins at -0.8 and ends at 1 - 2 * right.
          const Vec3 size = seen.size(), middle = seen.center();
          const double width = 1.8 - 2 * right;
          EXPECT_NEAR(std::max(size.x / width, size.y / 2), 0.9 * zoom, 1e-6);
          EXPECT_NEAR(middle.x, -0.8 + width / 2, 1e-6);
          EXPECT_NEAR(middle.y, 0, 1e-6);
        }
}

TEST(FitCamera, shows_all_around_a_given_target) {
  const std::array<Vec3, 4> points{Vec3(0, 0, 0), {5, 1, 0}, {0, 2, 1}, {1, 1, 4}};
  for (const bool orthographic : {false, true})
    for (const double azimuth : {0.0, 30.0, 200.0}) {
      const View view{.azimuth_deg = azimuth, .orthographic = orthographic, .target = Vec3(1, 1, 1)};
      const Camera camera = fit_camera_to(points, view, 1.5);
      EXPECT_EQ(camera.target, Vec3(1, 1, 1));
      const Box3 seen = rectangle_around(camera, 1.5, points);
      EXPECT_NEAR(std::max({seen.max.x, seen.max.y, -seen.min.x, -seen.min.y}), 0.9, 1e-9);
    }
}

TEST(FitCamera, shows_a_given_target_in_the_middle_of_what_its_free_sides_leave) {
  const std::array<Vec3, 4> points{Vec3(0, 0, 0), {5, 1, 0}, {0, 2, 1}, {1, 1, 4}};
  for (const bool orthographic : {false, true})
    for (const double right : {0.0, 0.2}) {
      const Vec3 target(1, 1, 1);
      const View view{.orthographic = orthographic, .target = target, .free_left = 0.1, .free_right = right};
      const Camera camera = fit_camera_to(points, view, 1.5);
      // In a picture of 2 by 2, what is left begins at -0.8 and ends at 1 - 2 * right.
      const double half = 0.9 - right, middle = -0.8 + half;
      const auto [x, y] = place_in_picture(camera, 1.5, target);
      EXPECT_NEAR(x, middle, 1e-9);
      EXPECT_NEAR(y, 0, 1e-9);
      const Box3 seen = rectangle_around(camera, 1.5, points);
      EXPECT_NEAR(std::max({(seen.max.x - x) / half, (x - seen.min.x) / half, seen.max.y, -seen.min.y}), 0.9, 1e-9);
    }
}

TEST(FitCamera, zooms_by_the_given_factor) {
  const Box3 box({0, 0, 0}, {2, 3, 4});
  for (const bool orthographic : {false, true}) {
    View view;
    view.orthographic = orthographic;
    const auto plain = place_in_picture(fit_camera(box, view, 1), 1, {2, 0, 4});
    view.zoom = 2.5;
    const auto zoomed = place_in_picture(fit_camera(box, view, 1), 1, {2, 0, 4});
    EXPECT_NEAR(zoomed[0], 2.5 * plain[0], 1e-12);
    EXPECT_NEAR(zoomed[1], 2.5 * plain[1], 1e-12);
  }
}

TEST(FitCamera, looks_from_the_named_side_with_exact_axes) {
  const Box3 box({-1, -1, -1}, {1, 1, 1});
  const std::array<std::pair<std::string_view, Vec3>, 6> sides{{{"+x", {1, 0, 0}},
                                                                {"-x", {-1, 0, 0}},
                                                                {"+y", {0, 1, 0}},
                                                                {"-y", {0, -1, 0}},
                                                                {"+z", {0, 0, 1}},
                                                                {"-z", {0, 0, -1}}}};
  for (const auto& [name, side] : sides) {
    const Camera camera = fit_camera(box, named_view(name), 1);
    EXPECT_EQ(camera.position.normalized(), side) << name;
    EXPECT_EQ(camera.up, std::abs(side.z) == 1 ? Vec3(0, 1, 0) : Vec3(0, 0, 1));
  }
  const Camera iso = fit_camera(box, named_view("iso"), 1);
  EXPECT_LT(iso.position.y, 0) << "from the front";
  EXPECT_GT(iso.position.z, 0) << "from above";
}

TEST(FitCamera, looks_at_a_single_point_and_along_a_line_too) {
  const std::array<Vec3, 2> line{Vec3(0, 0, 0), {0, 5, 0}};
  for (const bool orthographic : {false, true}) {
    EXPECT_NO_THROW(CameraRays(fit_camera(Box3(Vec3(1, 2, 3)), {.orthographic = orthographic}, 1), 4, 4));
    View view = named_view("-y");
    view.orthographic = orthographic;
    const Camera camera = fit_camera_to(line, view, 1);
    EXPECT_LT(camera.position.y, -0.4) << "outside";
    EXPECT_NO_THROW(CameraRays(camera, 4, 4));
  }
}

TEST(FitCamera, refuses_what_cannot_be_shown) {
  const Box3 box({0, 0, 0}, {1, 1, 1});
  expect_usage_error([&] { fit_camera(Box3(), {}, 1); });
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL})
    expect_usage_error([&] { fit_camera(box, {.zoom = bad}, 1); });
  for (const double bad : {0.0, -1.0, std::nan(""), 180.0})
    expect_usage_error([&] { fit_camera(box, {.vertical_fov_deg = bad}, 1); });
  for (const double bad : {-0.1, 0.5, std::nan("")})
    expect_usage_error([&] { fit_camera(box, {.free_left = bad, .free_right = 0.5}, 1); });
}

TEST(ViewDirection, of_words_depends_on_the_frame) {
  using render::ViewFrame;
  struct Row {
    std::string_view word;
    Vec3 z_up, y_up, ras, lps;
  };
  const Row rows[] = {{"front", {0, -1, 0}, {0, 0, 1}, {0, 1, 0}, {0, -1, 0}},
                      {"back", {0, 1, 0}, {0, 0, -1}, {0, -1, 0}, {0, 1, 0}},
                      {"right", {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {-1, 0, 0}},
                      {"left", {-1, 0, 0}, {-1, 0, 0}, {-1, 0, 0}, {1, 0, 0}},
                      {"top", {0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1}},
                      {"bottom", {0, 0, -1}, {0, -1, 0}, {0, 0, -1}, {0, 0, -1}},
                      {"+x", {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}},
                      {"-z", {0, 0, -1}, {0, 0, -1}, {0, 0, -1}, {0, 0, -1}}};
  const Box3 box({-1, -1, -1}, {1, 1, 1});
  for (const Row& row : rows)
    for (const auto& [frame, expected] : {std::pair{ViewFrame::engineering_z_up, row.z_up},
                                          {ViewFrame::engineering_y_up, row.y_up},
                                          {ViewFrame::anatomical_ras, row.ras},
                                          {ViewFrame::anatomical_lps, row.lps}}) {
      EXPECT_EQ(render::view_direction(row.word, render::axes_of(frame)), expected) << row.word;
      const Camera camera = fit_camera(box, named_view(row.word, render::axes_of(frame)), 1);
      EXPECT_EQ(camera.position.normalized(), expected) << row.word;
      EXPECT_EQ(std::abs(camera.up.dot(expected)), 0) << row.word;
      const Vec3 up = render::axes_of(frame).up;
      if (expected.dot(up) == 0) {
        EXPECT_EQ(camera.up, up) << row.word;
      }
    }
}

TEST(ViewAxes, are_right_handed_with_the_given_axis_up) {
  for (const auto& [word, up] : {std::pair{"x", Vec3(1, 0, 0)},
                                 {"y", Vec3(0, 1, 0)},
                                 {"z", Vec3(0, 0, 1)},
                                 {"-x", Vec3(-1, 0, 0)},
                                 {"-y", Vec3(0, -1, 0)},
                                 {"-z", Vec3(0, 0, -1)}}) {
    const render::ViewAxes axes = render::axes_with_up(word);
    EXPECT_EQ(axes.up, up);
    EXPECT_EQ(axes.right.cross(axes.ahead), up) << word;
    EXPECT_EQ(fit_camera(Box3({0, 0, 0}, {1, 2, 3}), named_view("front", axes), 1).up, up);
  }
  EXPECT_EQ(render::axes_with_up("z"), render::ViewAxes());
  EXPECT_EQ(render::axes_with_up("y"), render::axes_of(render::ViewFrame::engineering_y_up));
  for (const char* word : {"", "+z", "w", "zz"}) expect_usage_error([&] { render::axes_with_up(word); });
}

TEST(NamedView, refuses_other_words) {
  for (const char* word : {"frontal", "", "x", "+w", "--x"}) expect_usage_error([&] { named_view(word); });
}

TEST(CameraRays, put_pixel_0_0_into_the_upper_left_corner) {
  const Camera camera{.position = {0, -10, 0}, .target = {0, 0, 0}, .up = {0, 0, 1}, .vertical_fov_deg = 90};
  const CameraRays rays(camera, 40, 20);
  const auto first = rays.through_pixel(0, 0), last = rays.through_pixel(39, 19);
  EXPECT_LT(first.direction.x, 0);
  EXPECT_GT(first.direction.z, 0);
  EXPECT_GT(last.direction.x, 0);
  EXPECT_LT(last.direction.z, 0);
  // The middle of the first pixel: 19.5 pixels left of the middle, 9.5 above; 10 pixels are tan 45
  // degrees.
  EXPECT_NEAR(first.direction.x / first.direction.y, -1.95, 1e-14);
  EXPECT_NEAR(first.direction.z / first.direction.y, 0.95, 1e-14);
}

TEST(CameraRays, have_directions_of_unit_length) {
  for (const bool orthographic : {false, true})
    for (const double fov : {0.001, 30.0, 179.0}) {
      const CameraRays rays({.vertical_fov_deg = fov, .orthographic = orthographic}, 33, 65);
      for (const int x : {0, 16, 32})
        for (const int y : {0, 32, 64}) EXPECT_NEAR(rays.through_pixel(x, y).direction.length(), 1, 1e-15);
    }
}

TEST(CameraRays, are_parallel_and_evenly_spaced_when_orthographic) {
  const Camera camera{.position = {0, -5, 0}, .target = {0, 0, 0}, .orthographic = true, .orthographic_height = 6};
  const CameraRays rays(camera, 30, 30);
  EXPECT_EQ(rays.through_pixel(3, 7).direction, rays.through_pixel(29, 0).direction);
  EXPECT_NEAR(rays.through_pixel(4, 7).origin.x - rays.through_pixel(3, 7).origin.x, 0.2, 1e-15);
  EXPECT_NEAR(rays.through_pixel(3, 7).origin.z - rays.through_pixel(3, 8).origin.z, 0.2, 1e-15);
}

TEST(CameraRays, refuse_a_camera_that_takes_no_picture) {
  const double nan = std::nan("");
  const std::array<Camera, 11> bad{{{.position = {nan, 0, 0}},
                                    {.target = {0, HUGE_VAL, 0}},
                                    {.up = {0, 0, nan}},
                                    {.position = {1, 2, 3}, .target = {1, 2, 3}},
                                    {.up = {0, 0, 0}},
                                    {.up = {0, 5, 0}},
                                    {.vertical_fov_deg = 0},
                                    {.vertical_fov_deg = 180},
                                    {.vertical_fov_deg = nan},
                                    {.orthographic = true, .orthographic_height = 0},
                                    {.orthographic = true, .orthographic_height = nan}}};
  for (const Camera& camera : bad) expect_usage_error([&] { CameraRays(camera, 10, 10); });
}

}  // namespace
}  // namespace rhoray::tests

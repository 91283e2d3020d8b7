// X08. Fields of view of a thousandth of a degree and of 179 degrees. In the first, directions of
// neighbouring pixels differ by less than single precision resolves. In the second, they differ far
// more at the edges of the picture than at its centre.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"

namespace rhoray::tests {
namespace {

struct View {
  double fov_deg, distance;
  int width, height;
};

/// The exact direction through a pixel, in long double. The camera is at y = -distance and looks
/// along +y; z is up.
struct Direction {
  long double x, y, z;
};
Direction exact_direction(const View& view, int x, int y) {
  const long double half = std::tan(static_cast<long double>(view.fov_deg) * std::numbers::pi_v<long double> / 360);
  const long double right = ((2 * x + 1) / static_cast<long double>(view.width) - 1) * half * view.width / view.height;
  const long double down = ((2 * y + 1) / static_cast<long double>(view.height) - 1) * half;
  const long double length = std::sqrt(right * right + 1 + down * down);
  return {right / length, 1 / length, -down / length};
}

TEST(ExtremeFieldsOfView, show_every_pixel_in_its_own_direction) {
  // A tilted plane with larger field values behind it. The camera stands before it, at 179 degrees
  // within the data.
  const TemporaryFolder folder;
  const Vec3 slope(0.01, 1, 0.02);
  const render::Dataset dataset = packed(
      folder, "plane.rho",
      sampled_volume<double>({17, 17, 17}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-8, -8, -8}}, linear_field(slope)));
  constexpr double isovalue = 0.25;
  for (const View& view : {View{0.001, 1e4, 3, 2049}, {0.001, 20, 3, 2049}, {179, 1, 257, 257}}) {
    const auto [fov_deg, distance, width, height] = view;
    const render::Camera camera{.position = {0, -distance, 0}, .target = {0, 0, 0}, .vertical_fov_deg = fov_deg};
    const std::vector<render::Ray> rays = render::camera_rays(dataset, camera, width, height);
    render::RayCaster queries(dataset, isovalue, {});
    // Relative to half the diagonal of the picture. The rounding of the angle itself grows by the
    // condition of its tangent.
    const double angle = fov_deg * std::numbers::pi / 180, condition = angle / std::sin(angle);
    const Direction corner = exact_direction(view, 0, 0);
    const double rounding = 8e-16 * condition * static_cast<double>(std::hypot(corner.x, corner.z));
    int same = 0, same_in_single = 0, hits = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const render::Ray& ray = rays[static_cast<std::size_t>(y * width + x)];
        const Direction exact = exact_direction(view, x, y);
        ASSERT_NEAR(ray.direction.x, static_cast<double>(exact.x), rounding);
        ASSERT_NEAR(ray.direction.y, static_cast<double>(exact.y), 4e-16 + rounding);
        ASSERT_NEAR(ray.direction.z, static_cast<double>(exact.z), rounding);
        if (y > 0) {
          const Vec3 before = rays[static_cast<std::size_t>((y - 1) * width + x)].direction;
          // A component of the direction after the view axis is added in single precision.
          const auto single = [](const Vec3& v) { return static_cast<float>(1 + v.z); };
          same += before == ray.direction;
          same_in_single += single(before) == single(ray.direction);
        }
        const render::Hit hit = queries.first_crossing(ray);
        const Vec3 origin(0, -distance, 0),
            direction(static_cast<double>(exact.x), static_cast<double>(exact.y), static_cast<double>(exact.z));
        const double t = (isovalue - slope.dot(origin)) / slope.dot(direction);
        const Vec3 p = origin + t * direction;
        double inset = HUGE_VAL;
        for (int axis = 0; axis < 3; ++axis) inset = std::min(inset, 8 - std::abs(p[axis]));
        if (std::abs(inset) < 1e-6) continue;
        ASSERT_EQ(hit.is_miss(), inset < 0 || t < 0) << fov_deg << " degrees, pixel " << x << ", " << y;
        if (!hit.is_miss()) {
          ASSERT_NEAR(hit.t, t, 1e-12 * distance + 1e-11);
          ++hits;
        }
      }
    EXPECT_EQ(same, 0);
    EXPECT_GT(hits, 40) << fov_deg << " degrees";
    if (fov_deg < 1) {
      EXPECT_GT(same_in_single, height) << "single precision tells the pixels apart: is this case still the hard one?";
    }
  }
}

}  // namespace
}  // namespace rhoray::tests

#include "render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"

namespace rhoray::render {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180;

/// The box is shown slightly smaller than the picture.
constexpr double margin = 1.04;

/// Returns the direction from the target towards the eye. Multiples of 90 degrees give exact axes.
Vec3 towards_eye(const View& view) {
  const auto cosine = [](double deg) {
    return std::fmod(std::abs(deg), 180) == 90 ? 0.0 : std::cos(deg * radians_per_degree);
  };
  const auto sine = [&](double deg) { return cosine(deg - 90); };
  const double level = cosine(view.elevation_deg);
  return Vec3(level * sine(view.azimuth_deg), -level * cosine(view.azimuth_deg), sine(view.elevation_deg)).normalized();
}

}  // namespace

View named_view(std::string_view name) {
  struct Named {
    std::string_view name;
    double azimuth_deg, elevation_deg;
  };
  constexpr std::array<Named, 7> views{
      {{"iso", 30, 20}, {"+x", 90, 0}, {"-x", -90, 0}, {"+y", 180, 0}, {"-y", 0, 0}, {"+z", 0, 90}, {"-z", 0, -90}}};
  for (const Named& view : views)
    if (view.name == name) return {.azimuth_deg = view.azimuth_deg, .elevation_deg = view.elevation_deg};
  throw Error(ErrorCode::usage, concat("view '", name, "'; expected iso, +x, -x, +y, -y, +z or -z"));
}

Camera fit_camera(const Box3& box_world, const View& view, double aspect) {
  const DefaultFloatingPoint default_floating_point;
  if (!(view.zoom > 0) || !std::isfinite(view.zoom))
    throw Error(ErrorCode::usage, concat("zoom ", view.zoom, "; expected a number above 0"));
  if (!(view.vertical_fov_deg > 0 && view.vertical_fov_deg < 180))
    throw Error(ErrorCode::usage,
                concat("field of view ", view.vertical_fov_deg, " degrees; expected more than 0 and less than 180"));
  if (box_world.isEmpty()) throw Error(ErrorCode::usage, "there is nothing to point the camera at: the box is empty");

  const Vec3 back = towards_eye(view);
  const Vec3 up = std::abs(back.z) == 1 ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
  const Vec3 right = up.cross(back).normalized(), above = back.cross(right);
  const Vec3 center = box_world.center();

  // Find the nearest eye position from which every corner is in the picture, and the smallest
  // orthographic window around all of them.
  const double tan_half_height = std::tan(view.vertical_fov_deg / 2 * radians_per_degree) / margin;
  const double tan_half_width = tan_half_height * aspect;
  double distance = 0, half_height = 0, reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p = Vec3(corner & 1 ? box_world.max.x : box_world.min.x, corner & 2 ? box_world.max.y : box_world.min.y,
                        corner & 4 ? box_world.max.z : box_world.min.z) -
                   center;
    const double across = std::abs(p.dot(right)), along = std::abs(p.dot(above)), nearer = p.dot(back);
    distance = std::max({distance, nearer + across / tan_half_width, nearer + along / tan_half_height});
    half_height = std::max({half_height, along, across / aspect});
    reach = std::max(reach, nearer);
  }
  if (!(distance > 0)) distance = 1;  // a single point
  if (!(half_height > 0)) half_height = 1;

  Camera camera{.target = center, .up = up, .orthographic = view.orthographic};
  camera.vertical_fov_deg = view.vertical_fov_deg;
  if (view.zoom != 1)  // without zoom the angle stays exactly as given
    camera.vertical_fov_deg =
        2 * std::atan(std::tan(view.vertical_fov_deg / 2 * radians_per_degree) / view.zoom) / radians_per_degree;
  camera.orthographic_height = 2 * margin * half_height / view.zoom;
  camera.position = center + (view.orthographic ? 2 * reach + half_height : distance) * back;
  return camera;
}

}  // namespace rhoray::render

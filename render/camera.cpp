#include "render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "formats/base/box_corners.h"
#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/interval.h"
#include "formats/base/text.h"

namespace rhoray::render {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180;

/// Returns the direction from the target towards the eye. Multiples of 90 degrees give exact axes.
Vec3 towards_eye(const View& view) {
  const auto cosine = [](double deg) {
    return std::fmod(std::abs(deg), 180) == 90 ? 0.0 : std::cos(deg * radians_per_degree);
  };
  const auto sine = [&](double deg) { return cosine(deg - 90); };
  const double level = cosine(view.elevation_deg);
  const ViewAxes& axes = view.axes;
  return (level * sine(view.azimuth_deg) * axes.right - level * cosine(view.azimuth_deg) * axes.ahead +
          sine(view.elevation_deg) * axes.up)
      .normalized();
}

/// Returns the named axis of the world with length 1, or a zero vector for another name.
/// @param name  x or +x, -x, ...
Vec3 axis_named(std::string_view name) {
  const bool has_sign = name.starts_with('+') || name.starts_with('-');
  const std::string_view letter = name.substr(has_sign ? 1 : 0);
  Vec3 axis(0, 0, 0);
  if (letter == "x" || letter == "y" || letter == "z") axis[letter[0] - 'x'] = name.starts_with('-') ? -1 : 1;
  return axis;
}

[[noreturn]] void refuse_view(std::string_view name) {
  throw Error(ErrorCode::usage, concat("view '", name,
                                       "'; expected iso, front, back, left, right, top, bottom, +x, -x, +y, -y, +z "
                                       "or -z"));
}

/// Returns the view for an eye on one of these axes.
View view_towards(const Vec3& eye, const ViewAxes& axes) {
  const double right = eye.dot(axes.right), front = -eye.dot(axes.ahead), up = eye.dot(axes.up);
  if (up != 0) return {.azimuth_deg = 0, .elevation_deg = up > 0 ? 90.0 : -90.0, .axes = axes};
  const double azimuth_deg = right != 0 ? (right > 0 ? 90 : -90) : (front > 0 ? 0 : 180);
  return {.azimuth_deg = azimuth_deg, .elevation_deg = 0, .axes = axes};
}

/// A point as the camera sees it, relative to a point near all of them.
struct Seen {
  double place[2];  ///< to the right and up
  double nearness;  ///< towards the eye
};

/// The points that reach farthest to either side along an axis of the picture, for rays at this
/// angle.
struct Farthest {
  const Seen* high;
  const Seen* low;
};
Farthest farthest(const std::vector<Seen>& points, int axis, double tangent) {
  Farthest found{points.data(), points.data()};
  double high = -std::numeric_limits<double>::infinity(), low = high;
  for (const Seen& p : points) {
    const double along = tangent * p.nearness, to_high = p.place[axis] + along, to_low = along - p.place[axis];
    if (to_high > high) high = to_high, found.high = &p;
    if (to_low > low) low = to_low, found.low = &p;
  }
  return found;
}

/// Distance of the eye from which all points are within a tangent of the picture's middle.
/// @param is_free  the middle may be anywhere; else it is at place 0
double distance_for(const std::vector<Seen>& points, int axis, double tangent, bool is_free) {
  const auto [high, low] = farthest(points, axis, tangent);
  const double to_high = high->place[axis] / tangent + high->nearness,
               to_low = low->nearness - low->place[axis] / tangent;
  return is_free ? (to_high + to_low) / 2 : std::max(to_high, to_low);
}

/// The place that is in the middle of the points, seen in perspective from a distance. Newton's
/// method for the tangent of half the angle that they span: the outermost points' sum is convex and
/// piecewise linear in it.
double middle_of(const std::vector<Seen>& points, int axis, double distance, double tangent) {
  constexpr int most_steps = 64;  // it ends when no other point is outermost, after a few
  for (int step = 0; step < most_steps; ++step) {
    const auto [high, low] = farthest(points, axis, tangent);
    const double next =
        (high->place[axis] - low->place[axis]) / ((distance - high->nearness) + (distance - low->nearness));
    if (next == tangent || step + 1 == most_steps)
      return ((high->place[axis] + low->place[axis]) + next * (high->nearness - low->nearness)) / 2;
    tangent = next;
  }
  return 0;
}

/// The extent of the points along an axis of the picture, without perspective.
Interval<double> extent(const std::vector<Seen>& points, int axis) {
  Interval<double> range;
  for (const Seen& p : points) range.include(p.place[axis]);
  return range;
}

void check(const View& view, bool has_points) {
  if (!(view.zoom > 0) || !std::isfinite(view.zoom))
    throw Error(ErrorCode::usage, concat("zoom ", view.zoom, "; expected a number above 0"));
  if (!(view.vertical_fov_deg > 0 && view.vertical_fov_deg < 180))
    throw Error(ErrorCode::usage,
                concat("field of view ", view.vertical_fov_deg, " degrees; expected more than 0 and less than 180"));
  if (!(view.free_left >= 0 && view.free_right >= 0 && view.free_left + view.free_right < 1))
    throw Error(ErrorCode::usage, concat("margins of ", view.free_left, " and ", view.free_right,
                                         " of the picture's width; expected at least 0, and less than 1 together"));
  if (!has_points) throw Error(ErrorCode::usage, "there is nothing to point the camera at: the box is empty");
}

/// The middle of the picture, relative to the base of the points, and the distance of the eye.
struct Fit {
  double middle[2] = {0, 0};
  double distance = 0;
  double height = 0;  ///< of an orthographic picture
};

Fit fit_perspective(const std::vector<Seen>& points, const double (&tangent)[2], bool is_free) {
  Fit fit;
  for (int axis = 0; axis < 2; ++axis)
    fit.distance = std::max(fit.distance, distance_for(points, axis, tangent[axis], is_free));
  Interval<double> depth;
  for (const Seen& p : points) depth.include(p.nearness);
  // A point, points on a line through the eye, or a tip so sharp that the eye would be at it.
  constexpr double share_of_depth = 0.1;
  if (!(fit.distance > depth.hi))
    fit.distance = depth.hi + (depth.lo < depth.hi ? share_of_depth * (depth.hi - depth.lo) : 1);
  for (int axis = 0; is_free && axis < 2; ++axis)
    fit.middle[axis] = middle_of(points, axis, fit.distance, tangent[axis]);
  return fit;
}

Fit fit_orthographic(const std::vector<Seen>& points, double aspect, bool is_free) {
  Fit fit;
  for (int axis = 0; axis < 2; ++axis) {
    const Interval<double> range = extent(points, axis);
    if (is_free) fit.middle[axis] = (range.lo + range.hi) / 2;
    const double half = std::max(range.hi - fit.middle[axis], fit.middle[axis] - range.lo);
    fit.height = std::max(fit.height, 2 * half / (axis == 0 ? aspect : 1) / fitted_share);
  }
  if (!(fit.height > 0)) fit.height = 2;
  for (const Seen& p : points) fit.distance = std::max(fit.distance, 2 * p.nearness);
  fit.distance += fit.height / 2;
  return fit;
}

}  // namespace

ViewAxes axes_of(ViewFrame frame) {
  switch (frame) {
    case ViewFrame::engineering_z_up:
      return {};
    case ViewFrame::engineering_y_up:
      return {.right = {1, 0, 0}, .ahead = {0, 0, -1}, .up = {0, 1, 0}};
    case ViewFrame::anatomical_ras:
      return {.right = {-1, 0, 0}, .ahead = {0, -1, 0}, .names_sides_of_patient = true};
    case ViewFrame::anatomical_lps:
      return {.names_sides_of_patient = true};
  }
  return {};
}

ViewAxes axes_with_up(std::string_view axis) {
  const Vec3 up = axis.starts_with('+') ? Vec3(0, 0, 0) : axis_named(axis);
  if (up == Vec3(0, 0, 0))
    throw Error(ErrorCode::usage, concat("up axis '", axis, "'; expected x, y, z, -x, -y or -z"));
  ViewAxes axes{.right = {0, 1, 0}, .ahead = {0, 0, 1}};  // x
  if (up.y != 0) axes = axes_of(ViewFrame::engineering_y_up);
  if (up.z != 0) axes = axes_of(ViewFrame::engineering_z_up);
  if (axis.starts_with('-')) axes.right = -axes.right;
  axes.up = up;
  return axes;
}

Vec3 view_direction(std::string_view word, const ViewAxes& axes) {
  const Vec3 right = axes.names_sides_of_patient ? -axes.right : axes.right;
  const std::pair<std::string_view, Vec3> sides[] = {{"front", -axes.ahead}, {"back", axes.ahead},
                                                     {"left", -right},       {"right", right},
                                                     {"top", axes.up},       {"bottom", -axes.up}};
  for (const auto& [side, direction] : sides)
    if (word == side) return direction;
  const Vec3 axis = word.size() == 2 ? axis_named(word) : Vec3(0, 0, 0);
  if (axis == Vec3(0, 0, 0)) refuse_view(word);
  return axis;
}

View named_view(std::string_view name, const ViewAxes& axes) {
  return name == "iso" ? View{.axes = axes} : view_towards(view_direction(name, axes), axes);
}

Camera fit_camera_to(std::span<const Vec3> points_world, const View& view, double aspect) {
  const DefaultFloatingPoint default_floating_point;
  check(view, !points_world.empty());
  const Vec3 back = towards_eye(view);
  const Vec3 up = std::abs(back.dot(view.axes.up)) == 1 ? view.axes.ahead : view.axes.up;
  const Vec3 right = up.cross(back).normalized(), above = back.cross(right);
  Box3 around;
  for (const Vec3& p : points_world) around.extendBy(p);
  const Vec3 base = view.target.value_or(around.center());
  std::vector<Seen> points;
  points.reserve(points_world.size());
  for (const Vec3& p : points_world) {
    const Vec3 from_base = p - base;
    points.push_back({{from_base.dot(right), from_base.dot(above)}, from_base.dot(back)});
  }
  const bool is_free = !view.target;
  const double whole = std::tan(view.vertical_fov_deg / 2 * radians_per_degree);  // half the height at distance 1
  const double share = 1 - view.free_left - view.free_right;
  const double shift = (view.free_right - view.free_left) * aspect / view.zoom;
  const Fit flat = fit_orthographic(points, aspect * share, is_free);
  Fit fit = flat;
  if (view.orthographic) {
    fit.middle[0] += shift * flat.height / 2;
  } else {
    // At distance d the rest of the picture is off the axis by shift * whole * d. Sheared by this,
    // the points are fitted as if it were not.
    for (Seen& p : points) p.place[0] -= shift * whole * p.nearness;
    fit = fit_perspective(points, {fitted_share * whole * aspect * share, fitted_share * whole}, is_free);
    fit.middle[0] += shift * whole * fit.distance;
  }

  Camera camera{
      .target = base + fit.middle[0] * right + fit.middle[1] * above, .up = up, .orthographic = view.orthographic};
  camera.vertical_fov_deg = view.vertical_fov_deg;
  if (view.zoom != 1)  // without zoom the angle stays exactly as given
    camera.vertical_fov_deg =
        2 * std::atan(std::tan(view.vertical_fov_deg / 2 * radians_per_degree) / view.zoom) / radians_per_degree;
  camera.orthographic_height = flat.height / view.zoom;
  camera.position = camera.target + fit.distance * back;
  return camera;
}

double seen_aspect(std::span<const Vec3> points_world, const Camera& camera) {
  const DefaultFloatingPoint default_floating_point;
  const Vec3 forward = (camera.target - camera.position).normalized();
  const Vec3 right = forward.cross(camera.up).normalized(), down = forward.cross(right);
  Interval<double> across, along;
  for (const Vec3& p : points_world) {
    const Vec3 way = p - camera.position;
    const double distance = camera.orthographic ? 1 : way.dot(forward);
    across.include(way.dot(right) / distance);
    along.include(way.dot(down) / distance);
  }
  constexpr double least = 1e-3;
  const double width = across.hi - across.lo, height = along.hi - along.lo;
  if (!(width > least * height)) return height > 0 ? least : 1;  // a point is a square
  return height > least * width ? width / height : 1 / least;
}

Camera fit_camera(const Box3& box_world, const View& view, double aspect) {
  if (box_world.isEmpty()) return fit_camera_to({}, view, aspect);
  return fit_camera_to(corners_of(box_world), view, aspect);
}

}  // namespace rhoray::render

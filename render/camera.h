#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "formats/base/vector.h"

namespace rhoray::render {

/// The camera of a picture, in world units. Pixel (0, 0) is the upper left corner of the picture.
struct Camera {
  Vec3 position{0, -1, 0};
  Vec3 target{0, 0, 0};
  Vec3 up{0, 0, 1};
  double vertical_fov_deg = 30;  ///< full angle; in (0, 180)
  bool orthographic = false;
  double orthographic_height = 1;  ///< height of the picture in world units, when orthographic
};

/// Frames of the world in which data have a front, a right side and a top.
enum class ViewFrame {
  engineering_z_up,  ///< seen from the front, x points to the right and z up
  engineering_y_up,  ///< seen from the front, x points to the right and y up
  anatomical_ras,    ///< x points to the patient's right, y to the front, z to the head
  anatomical_lps     ///< x points to the patient's left, y to the back, z to the head
};

/// The axes from which the angles of a view count: orthogonal, of length 1, right x ahead = up.
struct ViewAxes {
  Vec3 right{1, 0, 0};  ///< in a picture from the front
  Vec3 ahead{0, 1, 0};  ///< direction of view of a picture from the front
  Vec3 up{0, 0, 1};
  /// The words left and right mean the sides of a patient who is seen from the front, not of the
  /// picture.
  bool names_sides_of_patient = false;

  friend bool operator==(const ViewAxes&, const ViewAxes&) = default;
};

ViewAxes axes_of(ViewFrame frame);

/// The axes for data that have this axis of the world up: x, y, z, -x, -y or -z. Refuses other
/// words (ErrorCode::usage). y and z are the engineering frames; the axes of -y and -z are theirs,
/// turned upside down around `ahead`.
ViewAxes axes_with_up(std::string_view axis);

/// The direction towards the eye, of length 1, world axes, for the side from which a view with this
/// word looks: front, back, left, right, top or bottom, or an axis of the world: +x, -x, +y, -y, +z
/// or -z. Refuses other words with ErrorCode::usage.
Vec3 view_direction(std::string_view word, const ViewAxes& axes);

/// A view direction given by two angles, and how much of the picture the data fills.
struct View {
  /// 0 looks ahead; 90 looks from the right.
  double azimuth_deg = 30;
  double elevation_deg = 20;  ///< 90 looks straight down
  double zoom = 1;            ///< 1: fits the picture; 2: twice as large
  double vertical_fov_deg = 30;
  bool orthographic = false;
  ViewAxes axes{};
  /// The point in the middle of the picture less its free sides. Nothing: such that what is seen
  /// lies in the middle.
  std::optional<Vec3> target{};
  /// Shares of the picture's width that stay free at its sides.
  double free_left = 0, free_right = 0;
};

/// Returns the view with this name: iso (three-quarter), or a word of view_direction. Refuses other
/// names with ErrorCode::usage.
View named_view(std::string_view name, const ViewAxes& axes = {});

/// Share of the picture's width or height that fitted points fill.
inline constexpr double fitted_share = 0.9;

/// Returns a camera that looks at points from `view`. At zoom 1 the points' bounding rectangle has
/// 90 % of the width or height of the picture less its free sides, and at most that of the other.
/// Without a given target it lies in the middle of these, up to rounding; with one, no point lies
/// farther from the middle than 45 % of either. The up direction of the axes is up in the picture;
/// for a view straight along it, their direction ahead is.
///
/// Where the nearest point alone sets the distance (a line of points, a tip), the eye keeps a tenth
/// of the depth from it. Refuses no points, or numbers out of range (ErrorCode::usage).
/// @param aspect  width of the picture over its height
Camera fit_camera_to(std::span<const Vec3> points_world, const View& view, double aspect);

/// Width over height of the rectangle around points in a camera's picture; at least 1/1000 and at
/// most 1000. No point lies behind the eye.
double seen_aspect(std::span<const Vec3> points_world, const Camera& camera);

/// The same for the corners of a box.
Camera fit_camera(const Box3& box_world, const View& view, double aspect);

}  // namespace rhoray::render

#pragma once

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

/// A view direction given by two angles, and how much of the picture the data fills.
struct View {
  /// 0 looks along +y (from the front of an LPS/RAS body); 90 looks along -x.
  double azimuth_deg = 30;
  double elevation_deg = 20;  ///< 90 looks straight down along -z
  double zoom = 1;            ///< 1: the box just fits; 2: twice as large
  double vertical_fov_deg = 30;
  bool orthographic = false;
};

/// Returns the view with this name: iso (three-quarter), +x, -x, +y, -y, +z or -z (the side looked
/// from). Refuses other names with ErrorCode::usage.
View named_view(std::string_view name);

/// Returns a camera that looks at the middle of the box from `view` and shows all of it at zoom 1.
/// World z is up; for a view straight along z, world y is up.
/// @param aspect  width of the picture over its height
Camera fit_camera(const Box3& box_world, const View& view, double aspect);

}  // namespace rhoray::render

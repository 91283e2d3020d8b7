#pragma once

#include "render/camera.h"
#include "tools/pictures/canvas.h"

namespace rhoray::tools {

/// A point's position in the picture.
struct Seen {
  Spot at;
  double distance;  ///< in front of the eye's plane; not above 0 behind it
};

/// Projects points of the world into a picture.
class Projection {
 public:
  Projection(const render::Camera& camera, int width, int height);

  Seen of(const Vec3& point) const;
  /// Projects a direction: right, down, and away from the eye.
  Vec3 of_direction(const Vec3& direction) const;
  /// True if the eye is on this side of a plane.
  bool sees_side(const Vec3& point, const Vec3& normal) const;
  /// Length of the ray through a picture position for each unit of distance.
  double ray_length(const Spot& at) const;
  bool is_orthographic() const { return camera_.orthographic; }

 private:
  render::Camera camera_;
  Vec3 forward_, right_, down_;
  double pixels_per_unit_;  ///< at distance 1
  Spot middle_;
};

}  // namespace rhoray::tools

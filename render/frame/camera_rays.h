#pragma once

#include "render/camera.h"
#include "render/march/ray.h"

namespace rhoray::render {

/// Makes the ray through the middle of a pixel, in world units with a direction of unit length, so that t is a
/// distance.
class CameraRays {
 public:
  /// Refuses a camera from which no picture can be taken (not finite, target at the position, up along the view).
  CameraRays(const Camera& camera, int width, int height);

  Ray through_pixel(int x, int y) const;

 private:
  Vec3 position_;
  Vec3 forward_;
  Vec3 across_;  ///< from the middle of the picture to its right edge, on the plane at distance 1 (perspective) or 0
  Vec3 down_;    ///< from the middle to the lower edge
  double width_, height_;
  bool orthographic_;
};

}  // namespace rhoray::render

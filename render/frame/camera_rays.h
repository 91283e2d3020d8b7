#pragma once

#include <cmath>

#include "formats/base/affine.h"
#include "formats/base/checks.h"
#include "render/camera.h"
#include "render/traverse/ray.h"

namespace rhoray::render {

/// Makes the ray through the centre of a pixel, in world units with a direction of unit length, so
/// that t is a distance. All camera rays are made here, one by one or in loops that gcc vectorizes.
/// Both give the same numbers, because only operations that IEEE 754 rounds exactly are used, in
/// one order.
class CameraRays {
 public:
  /// Refuses a degenerate camera (not finite, target equal to the position, up parallel to the
  /// view).
  CameraRays(const Camera& camera, int width, int height);

  /// Picture coordinate of a column or row of pixels: -1 at the picture's left or upper edge, 1 at
  /// its right or lower edge.
  double across_of(int x) const { return (2 * x + 1) / width_ - 1; }
  double down_of(int y) const { return (2 * y + 1) / height_ - 1; }

  /// The same for any position in the picture, in pixels from its left or upper edge.
  double across_at(double x) const { return 2 * x / width_ - 1; }
  double down_at(double y) const { return 2 * y / height_ - 1; }

  bool is_orthographic() const { return orthographic_; }

  /// The same for all rays of a perspective camera.
  RHORAY_INLINE Vec3 origin(double across, double down) const {
    return orthographic_ ? position_ + (across * across_ + down * down_) : position_;
  }

  /// The same for all rays of an orthographic camera.
  RHORAY_INLINE Vec3 direction(double across, double down) const {
    if (orthographic_) return forward_;
    const Vec3 through = forward_ + (across * across_ + down * down_);
    return through / std::sqrt(through.dot(through));
  }

  // Vectors that define the rays, world units: the eye (orthographic: the picture's centre), the
  // vector from there to the picture's centre, and those from the centre to its right and lower
  // edges.
  const Vec3& position() const { return position_; }
  const Vec3& forward() const { return forward_; }
  const Vec3& across() const { return across_; }
  const Vec3& down() const { return down_; }

  Ray through_pixel(int x, int y) const {
    const double across = across_of(x), down = down_of(y);
    return {.origin = origin(across, down), .direction = direction(across, down)};
  }

 private:
  Vec3 position_;
  Vec3 forward_;
  /// From the picture's centre to its right edge, on the plane at distance 1 (perspective) or 0.
  Vec3 across_;
  Vec3 down_;  ///< from the centre to the lower edge
  double width_, height_;
  bool orthographic_;
};

}  // namespace rhoray::render

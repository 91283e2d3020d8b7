#pragma once

#include <cmath>
#include <numbers>

#include "render/camera.h"

namespace rhoray::study {

/// The rays through the pixel centres of a perspective camera, as `render` makes them, for systems
/// that take rays as input. The axes of their frame are those of the world, stretched.
template <class Real>
class PixelRays {
 public:
  struct Direction {
    Real x, y, z;
  };

  /// @param stretch  frame units per world unit, along each axis
  PixelRays(const render::Camera& camera, int width, int height, const Vec3& stretch = Vec3(1))
      : width_(width), height_(height), stretch_(stretch) {
    const Vec3 forward = (camera.target - camera.position).normalized();
    const Vec3 right = forward.cross(camera.up).normalized();
    const double half_height = std::tan(camera.vertical_fov_deg * std::numbers::pi / 360);
    const Vec3 across = right * (half_height * width / height), down = forward.cross(right) * half_height;
    set(origin_, camera.position * stretch);
    set(forward_, forward);
    set(across_, across);
    set(down_, down);
  }

  Direction origin() const { return origin_; }

  /// Of unit length in the world, then stretched: the ray's parameter is a distance in world units.
  Direction through(int x, int y) const {
    const Real sx = (2 * static_cast<Real>(x) + 1) / static_cast<Real>(width_) - 1;
    const Real sy = (2 * static_cast<Real>(y) + 1) / static_cast<Real>(height_) - 1;
    const Direction d{forward_.x + sx * across_.x + sy * down_.x, forward_.y + sx * across_.y + sy * down_.y,
                      forward_.z + sx * across_.z + sy * down_.z};
    const Real scale = 1 / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    return {d.x * scale * static_cast<Real>(stretch_.x), d.y * scale * static_cast<Real>(stretch_.y),
            d.z * scale * static_cast<Real>(stretch_.z)};
  }

 private:
  static void set(Direction& to, const Vec3& from) {
    to = {static_cast<Real>(from.x), static_cast<Real>(from.y), static_cast<Real>(from.z)};
  }

  int width_, height_;
  Vec3 stretch_;
  Direction origin_, forward_, across_, down_;
};

/// Shades a pixel lit from the eye, with the numbers of render::Material, without gloss, as
/// own_isosurface does. Systems that only return hits must compute this as well.
/// @param cosine  between normal and ray
inline void light_pixel(float* rgba, float cosine) {
  const float brightness = 0.12F + 0.88F * std::abs(cosine);
  rgba[0] = 0.78F * brightness;
  rgba[1] = 0.74F * brightness;
  rgba[2] = 0.68F * brightness;
  rgba[3] = 1;
}
inline void light_background(float* rgba) {
  rgba[0] = rgba[1] = rgba[2] = 1;
  rgba[3] = 0;
}

}  // namespace rhoray::study

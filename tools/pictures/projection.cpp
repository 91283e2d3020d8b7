#include "tools/pictures/projection.h"

#include <cmath>
#include <numbers>

namespace rhoray::tools {

Projection::Projection(const render::Camera& camera, int width, int height)
    : camera_(camera), middle_{width / 2.0, height / 2.0} {
  forward_ = (camera.target - camera.position).normalized();
  right_ = forward_.cross(camera.up).normalized();
  down_ = forward_.cross(right_);
  const double half_height =
      camera.orthographic ? camera.orthographic_height / 2 : std::tan(camera.vertical_fov_deg * std::numbers::pi / 360);
  pixels_per_unit_ = height / 2.0 / half_height;
}

Seen Projection::of(const Vec3& point) const {
  const Vec3 way = point - camera_.position;
  const double distance = way.dot(forward_);
  const double scale = camera_.orthographic ? pixels_per_unit_ : pixels_per_unit_ / distance;
  return {middle_ + scale * Spot{way.dot(right_), way.dot(down_)}, distance};
}

Vec3 Projection::of_direction(const Vec3& direction) const {
  return {direction.dot(right_), direction.dot(down_), direction.dot(forward_)};
}

bool Projection::sees_side(const Vec3& point, const Vec3& normal) const {
  return (camera_.orthographic ? -forward_.dot(normal) : (camera_.position - point).dot(normal)) > 0;
}

double Projection::ray_length(const Spot& at) const {
  if (camera_.orthographic) return 1;
  const Spot from_middle = (1 / pixels_per_unit_) * (at - middle_);
  return std::sqrt(1 + from_middle.dot(from_middle));
}

}  // namespace rhoray::tools

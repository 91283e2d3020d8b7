#include "render/frame/camera_rays.h"

#include <cmath>
#include <numbers>

#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray::render {

namespace {

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

CameraRays::CameraRays(const Camera& camera, int width, int height)
    : position_(camera.position), width_(width), height_(height), orthographic_(camera.orthographic) {
  if (!is_finite(camera.position) || !is_finite(camera.target) || !is_finite(camera.up))
    throw Error(ErrorCode::usage, "the camera's position, target and up direction must be finite numbers");
  if (camera.position == camera.target)
    throw Error(ErrorCode::usage, "the camera's position and target are the same point");
  forward_ = (camera.target - camera.position).normalized();
  const Vec3 right = forward_.cross(camera.up);
  // Otherwise rounding errors would turn the picture.
  if (!(right.length() > 1e-9 * camera.up.length()))
    throw Error(ErrorCode::usage, "the camera's up direction is zero or lies along its view");
  if (!orthographic_ && !(camera.vertical_fov_deg > 0 && camera.vertical_fov_deg < 180))
    throw Error(ErrorCode::usage,
                concat("field of view ", camera.vertical_fov_deg, " degrees; expected more than 0 and less than 180"));
  if (orthographic_ && !(camera.orthographic_height > 0 && std::isfinite(camera.orthographic_height)))
    throw Error(ErrorCode::usage,
                concat("orthographic height ", camera.orthographic_height, "; expected a number above 0"));

  const double half_height =
      orthographic_ ? camera.orthographic_height / 2 : std::tan(camera.vertical_fov_deg * std::numbers::pi / 360);
  across_ = right.normalized() * (half_height * width_ / height_);
  down_ = forward_.cross(right.normalized()) * half_height;
}

}  // namespace rhoray::render

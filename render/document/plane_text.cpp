#include "render/document/plane_text.h"

#include <optional>

#include "formats/base/number_text.h"
#include "formats/base/text.h"

namespace rhoray::render {

namespace {

/// The axis of the world along which a vector points; nothing for other directions.
std::optional<int> axis_of(const Vec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 rest = normal;
    rest[axis] = 0;
    if (rest == Vec3(0, 0, 0)) return axis;
  }
  return std::nullopt;
}

std::string vector_text(const Vec3& v) {
  return concat("(", rounded(v.x), ", ", rounded(v.y), ", ", rounded(v.z), ")");
}

}  // namespace

std::string text_of_slice(const HalfSpace& plane) {
  if (const std::optional<int> axis = axis_of(plane.normal))
    return concat(std::string(1, "xyz"[*axis]), " = ", rounded(plane.point[*axis]));
  return concat("through ", vector_text(plane.point), " with normal ", vector_text(plane.normal));
}

std::string text_of_slice_outside(const HalfSpace& plane, const Box3& bounds) {
  const std::string fact = concat("the slice ", text_of_slice(plane), " lies outside the data");
  const std::optional<int> axis = axis_of(plane.normal);
  return axis ? concat(fact, " (", rounded(bounds.min[*axis]), " to ", rounded(bounds.max[*axis]), ")") : fact;
}

}  // namespace rhoray::render

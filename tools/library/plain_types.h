#pragma once

#include "formats/base/affine.h"
#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "rhoray/types.h"

/// Between plain types of the public headers (outside) and those of the rooms (inside).
namespace rhoray::v0_1::inside {

inline rhoray::Vec3 inside_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}
inline Vec3 outside_of(const rhoray::Vec3& v) {
  return {v.x, v.y, v.z};
}
inline rhoray::Box3 inside_of(const Box3& box) {
  return {inside_of(box.min), inside_of(box.max)};
}
inline Box3 outside_of(const rhoray::Box3& box) {
  return {outside_of(box.min), outside_of(box.max)};
}
inline rhoray::Interval<double> inside_of(const Interval& range) {
  return {range.lo, range.hi};
}
inline Interval outside_of(const rhoray::Interval<double>& range) {
  return {range.lo, range.hi};
}
inline rhoray::Affine inside_of(const Affine& map) {
  return {inside_of(map.x_axis), inside_of(map.y_axis), inside_of(map.z_axis), inside_of(map.origin)};
}

}  // namespace rhoray::v0_1::inside

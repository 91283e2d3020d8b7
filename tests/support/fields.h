#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>
#include <vector>

#include "formats/base/affine.h"
#include "preprocess/neutral.h"

namespace rhoray::tests {

/// A field whose value is known everywhere, in world coordinates.
using Field = std::function<double(const Vec3&)>;

/// offset + slope . p: trilinear and tetrahedral interpolation both reproduce it up to rounding.
inline Field linear_field(const Vec3& slope, double offset = 0) {
  return [=](const Vec3& p) { return offset + slope.dot(p); };
}

/// x y z: the trilinear interpolant of its samples on any axis-parallel lattice is the field
/// itself.
inline Field product_field() {
  return [](const Vec3& p) { return p.x * p.y * p.z; };
}

/// Distance from a point.
inline Field distance_field(const Vec3& center) {
  return [=](const Vec3& p) { return (p - center).length(); };
}

/// The test signal of Marschner and Lobb (IEEE Visualization 1994) on [-1, 1]^3; values in [0, 1].
inline Field marschner_lobb_field(double frequency = 6, double alpha = 0.25) {
  return [=](const Vec3& p) {
    const double r = std::hypot(p.x, p.y);
    const double ripple = std::cos(2 * std::numbers::pi * frequency * std::cos(std::numbers::pi * r / 2));
    return (1 - std::sin(std::numbers::pi * p.z / 2) + alpha * (1 + ripple)) / (2 * (1 + alpha));
  };
}

/// A lattice of `count` samples whose first and last sample are at opposite corners of the box.
inline Affine lattice_over(const Box3& box, const Index3& count) {
  Affine map;
  map.x_axis = {(box.max.x - box.min.x) / static_cast<double>(count.x - 1), 0, 0};
  map.y_axis = {0, (box.max.y - box.min.y) / static_cast<double>(count.y - 1), 0};
  map.z_axis = {0, 0, (box.max.z - box.min.z) / static_cast<double>(count.z - 1)};
  map.origin = box.min;
  return map;
}

/// A volume of samples of type T given by a function of their lattice index. Do not copy the
/// result: its span would refer to the original.
template <class T>
preprocess::NeutralVolume volume_of(const Index3& count, const std::function<T(const Index3&)>& sample,
                                    const Affine& world_from_grid = {}) {
  preprocess::NeutralVolume made;
  made.sample_count = count;
  made.type = formats::element_type_of<T>();
  made.world_from_grid = world_from_grid;
  made.field_name = "value";
  made.owned_samples.resize(static_cast<std::size_t>(volume(count)) * sizeof(T));
  std::byte* out = made.owned_samples.data();
  for (Index3 at{0, 0, 0}; at.z < count.z; ++at.z)
    for (at.y = 0; at.y < count.y; ++at.y)
      for (at.x = 0; at.x < count.x; ++at.x, out += sizeof(T)) {
        const T value = sample(at);
        std::memcpy(out, &value, sizeof value);
      }
  made.samples = made.owned_samples;
  return made;
}

/// A volume that samples a field in world coordinates; integer types round to nearest.
template <class T>
preprocess::NeutralVolume sampled_volume(const Index3& count, const Affine& world_from_grid, const Field& field) {
  return volume_of<T>(
      count,
      [&](const Index3& at) {
        const Vec3 p_grid(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z));
        const double value = field(world_from_grid.point(p_grid));
        if constexpr (std::is_integral_v<T>)
          return static_cast<T>(std::llround(value));
        else
          return static_cast<T>(value);
      },
      world_from_grid);
}

}  // namespace rhoray::tests

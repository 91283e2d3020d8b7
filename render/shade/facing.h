#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "formats/base/affine.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Orientation of a surface towards the eye; both of its sides are shaded alike.
///
/// Gradients are transformed to world axes, where angles are measured. The product of gradient and
/// ray is the same number there and in the data's frame, so the ray need not be transformed.
/// Gradients are scaled by powers of 2, so that squares of very large or very small gradients
/// neither overflow nor vanish.
class Facing {
 public:
  explicit Facing(const Affine& world_from_data) {
    const Vec3 x = world_from_data.gradient({1, 0, 0}), y = world_from_data.gradient({0, 1, 0}),
               z = world_from_data.gradient({0, 0, 1});
    double largest = 0;
    for (const Vec3& v : {x, y, z})
      for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(v[axis]));
    length_ = to_unit(largest);
    world_from_gradient_ = {.x_axis = x * length_, .y_axis = y * length_, .z_axis = z * length_, .origin = {0, 0, 0}};
  }

  /// Cosines of the angles between the normals and the directions to the eye, in [0, 1], for the
  /// hits from `first` on. A hit without a gradient (zero or not finite) faces the eye.
  RHORAY_INLINE void cosines(const RayBatch& rays, const HitBatch& hits, std::size_t first, Lanes& out) const {
    const Facing facing = *this;
    const double *gx = hits.gradient[0].data() + first, *gy = hits.gradient[1].data() + first,
                 *gz = hits.gradient[2].data() + first, *dx = rays.direction[0].data() + first,
                 *dy = rays.direction[1].data() + first, *dz = rays.direction[2].data() + first;
    Lanes along, square;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Vec3 gradient = scaled({gx[i], gy[i], gz[i]});
      const Vec3 normal = facing.world_from_gradient_.vector(gradient);
      along[i] = static_cast<float>(gradient.dot(facing.length_ * Vec3(dx[i], dy[i], dz[i])));
      square[i] = static_cast<float>(normal.dot(normal));
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
      const float cosine = std::abs(along[i]) / std::sqrt(square[i]);
      out[i] = cosine < 1 ? cosine : 1;  // written so that a NaN becomes 1
    }
  }

  /// Finds unit normals towards the eye for the hits from `first` on. A hit without a gradient
  /// faces the eye.
  RHORAY_INLINE void normals(const RayBatch& rays, const HitBatch& hits, std::size_t first, const Directions& to_eye,
                             Directions& out) const {
    const Facing facing = *this;
    const double *gx = hits.gradient[0].data() + first, *gy = hits.gradient[1].data() + first,
                 *gz = hits.gradient[2].data() + first, *dx = rays.direction[0].data() + first,
                 *dy = rays.direction[1].data() + first, *dz = rays.direction[2].data() + first;
    for (std::size_t i = 0; i < out.x.size(); ++i) {
      const Vec3 gradient = scaled({gx[i], gy[i], gz[i]});
      const Vec3 normal = facing.world_from_gradient_.vector(gradient);
      const double along = gradient.dot(facing.length_ * Vec3(dx[i], dy[i], dz[i])), square = normal.dot(normal);
      const double scale = (along > 0 ? -1 : 1) / std::sqrt(square);
      const bool has_gradient = square > 0;
      out.x[i] = has_gradient ? static_cast<float>(normal.x * scale) : to_eye.x[i];
      out.y[i] = has_gradient ? static_cast<float>(normal.y * scale) : to_eye.y[i];
      out.z[i] = has_gradient ? static_cast<float>(normal.z * scale) : to_eye.z[i];
    }
  }

  /// Unit normal towards the eye, world axes; zero where the gradient is zero or not finite.
  Vec3 normal(const Vec3& gradient_data, const Vec3& direction_data) const {
    const Vec3 gradient = scaled(gradient_data);
    const Vec3 normal = world_from_gradient_.vector(gradient);
    const double length = std::sqrt(normal.dot(normal));
    if (!(length > 0)) return {0, 0, 0};
    return normal * ((gradient.dot(direction_data) > 0 ? -1 : 1) / length);
  }

  /// Scales a gradient so that its products with vectors neither overflow nor vanish.
  RHORAY_INLINE static Vec3 scaled(const Vec3& gradient) {
    const double x = std::abs(gradient.x), y = std::abs(gradient.y), z = std::abs(gradient.z);
    const double xy = x > y ? x : y;
    return gradient * to_unit(xy > z ? xy : z);
  }

 private:
  /// Returns the power of 2 that scales a number above 0 and below 2^1023 to [1, 2); numbers below
  /// 2^-1022 stay below 2.
  RHORAY_INLINE static double to_unit(double number) {
    constexpr std::uint64_t exponent_bits = 0x7ff0'0000'0000'0000, twice_one = 0x7fe0'0000'0000'0000;
    return std::bit_cast<double>(twice_one - (std::bit_cast<std::uint64_t>(number) & exponent_bits));
  }

  Affine world_from_gradient_;  ///< scaled by length_; only vectors are transformed
  double length_;               ///< a power of 2 of the order of a cell's size
};

}  // namespace rhoray::render

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/vector.h"
#include "render/kernels/batch.h"
#include "render/kernels/machine.h"

namespace rhoray::render::wide {

/// How points are seen from a light that stands in one direction: their places in a plane along two axes, each where
/// the point's way to the light passes it, and their heights, along the third axis, towards the light. All points of a
/// way to the light have one place.
class SeenFromLight {
 public:
  /// @param towards  the light; not zero
  explicit SeenFromLight(const Vec3& towards);

  int height_axis() const { return axis_; }
  int place_axis(int i) const { return (axis_ + 1 + i) % 3; }
  double slope(int i) const { return slope_[i]; }  ///< of a place, while the point moves up the height's axis
  double sign() const { return sign_; }            ///< a height is sign * the coordinate

 private:
  int axis_;
  double slope_[2], sign_;
};

/// What something covers of the plane of places, at most, and its greatest height.
struct Footprint {
  float low[2], high[2], height;

  static Footprint of_nothing();
  RHORAY_INLINE void add(const SeenFromLight& seen, const float* point) {
    const float w = point[seen.height_axis()], up = static_cast<float>(seen.sign()) * w;
    height = up > height ? up : height;
    for (int i = 0; i < 2; ++i) {
      const float at = point[seen.place_axis(i)] - static_cast<float>(seen.slope(i)) * w;
      low[i] = at < low[i] ? at : low[i], high[i] = at > high[i] ? at : high[i];
    }
  }
};

/// How high what may hold light back stands, place by place: a point that is higher is lit, and no ray has to tell so.
///
/// Footprints are of a frame (p - anchor) * scale, and have their corners in single precision. A margin is added to
/// them on all sides: more than what rounding moves points by, and than what a kernel may see of a thing outside it.
class BlockerHeights {
 public:
  struct Frame {
    Vec3 anchor{0, 0, 0};
    double scale = 1;
    double margin = 0;  ///< in this frame
  };

  BlockerHeights(const SeenFromLight& seen, const Frame& frame, std::span<const Footprint> footprints);

  /// @param chosen  rays of a group of the batch that go straight to the light
  /// @return        those of them that may be held back
  std::uint64_t below(Machine machine, const RayBatch& rays, std::size_t first, std::uint64_t chosen) const;

 private:
  static void find_below(const BlockerHeights& heights, const RayBatch& rays, std::size_t first,
                         std::uint8_t* is_below);

  SeenFromLight seen_;
  Frame frame_;
  int count_[2] = {0, 0};
  double first_[2] = {0, 0}, per_length_ = 0;
  std::vector<float> heights_;
};

}  // namespace rhoray::render::wide

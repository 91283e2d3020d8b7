#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "formats/base/vector.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render::wide {

/// Projects points along the direction of a light. A point's place is where the line from it to the
/// light passes a plane along two axes. Its height is along the third axis, towards the light. All
/// points on a line to the light have the same place.
class SeenFromLight {
 public:
  /// @param towards  direction to the light; not zero
  explicit SeenFromLight(const Vec3& towards);

  int height_axis() const { return axis_; }
  int place_axis(int i) const { return (axis_ + 1 + i) % 3; }
  /// Change of a place while the point moves up the height's axis.
  double slope(int i) const { return slope_[i]; }
  double sign() const { return sign_; }  ///< height = sign * coordinate

 private:
  int axis_;
  double slope_[2], sign_;
};

/// A bound of the area that something covers in the plane of places, and its greatest height.
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

/// Squares in the plane of places, each with its own number, and one more for everything outside.
struct Squares {
  int count[2] = {0, 0};
  double first[2] = {0, 0}, per_length = 0;

  std::size_t size() const { return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]); }

  /// Divides the area from `first` to `last` into squares of about this edge length. Their number
  /// is limited so that they fit into a core's own cache.
  void divide(const double (&last)[2], double edge);
};

/// A height map of occluders: a point above it is lit, and needs no shadow ray. A second map gives
/// the height below which a point is certainly in shadow.
///
/// Footprints are in a frame (p - anchor) * scale, with corners in single precision. A margin is
/// added on all sides. It is larger than the rounding of points, and than the distance outside an
/// object at which a kernel may still hit it.
class OccluderHeights {
 public:
  struct Frame {
    Vec3 anchor{0, 0, 0};
    double scale = 1;
    double margin = 0;       ///< in this frame
    bool ends_rays = false;  ///< rays end where they are above all their possible occluders
  };

  /// @param stop  ends it (ErrorCode::interrupted)
  OccluderHeights(const SeenFromLight& seen, const Frame& frame, std::span<const Footprint> footprints,
                  const std::stop_token& stop);

  /// The same for given heights of each square and of what is outside.
  /// @param heights  upper bounds of the occluders' heights; empty: there are no occluders
  /// @param shadows  below these every point is in shadow, -infinity: not known for any; empty: not
  ///   known anywhere
  OccluderHeights(const SeenFromLight& seen, const Frame& frame, const Squares& squares, std::vector<float> heights,
                  std::vector<float> shadows)
      : seen_(seen), frame_(frame), squares_(squares), heights_(std::move(heights)), shadows_(std::move(shadows)) {}

  struct Known {
    std::uint64_t asked;      ///< rays that may be occluded
    std::uint64_t in_shadow;  ///< rays that are occluded
  };

  /// @param rays    of a group, which begins at `first`, that go straight to the light
  /// @param chosen  the rays to classify; others get no result
  Known know(Machine machine, RayBatch& rays, std::size_t first, std::uint64_t chosen) const;

 private:
  static void find_known(const OccluderHeights& heights, RayBatch& rays, std::size_t first, std::uint8_t* is_asked,
                         std::uint8_t* is_in_shadow);

  SeenFromLight seen_;
  Frame frame_;
  Squares squares_;
  std::vector<float> heights_, shadows_;
};

}  // namespace rhoray::render::wide

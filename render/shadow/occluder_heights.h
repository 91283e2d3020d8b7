#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/vector.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

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

/// Squares of the plane of places, each of which has a number of its own; and one beyond them all.
struct Squares {
  int count[2] = {0, 0};
  double first[2] = {0, 0}, per_length = 0;

  std::size_t size() const { return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]); }

  /// Squares of about this edge, from `first` to `last`: as many as fit a core's own cache, at most.
  void divide(const double (&last)[2], double edge);
};

/// How high what may hold light back stands, place by place: a point that is higher is lit, and no ray has to tell so.
/// And how low what surely does: a point that is lower lies in shadow.
///
/// Footprints are of a frame (p - anchor) * scale, and have their corners in single precision. A margin is added to
/// them on all sides: more than what rounding moves points by, and than what a kernel may see of a thing outside it.
class OccluderHeights {
 public:
  struct Frame {
    Vec3 anchor{0, 0, 0};
    double scale = 1;
    double margin = 0;       ///< in this frame
    bool ends_rays = false;  ///< rays that are asked about end where they are higher than all that may hold them back
  };

  OccluderHeights(const SeenFromLight& seen, const Frame& frame, std::span<const Footprint> footprints);

  /// The same where it is known, of each square and of what is beyond them.
  /// @param heights  of what stands there, at most; empty: there is nothing
  /// @param shadows  below which every point lies in shadow, -infinity: not known of any; empty: not known anywhere
  OccluderHeights(const SeenFromLight& seen, const Frame& frame, const Squares& squares, std::vector<float> heights,
                  std::vector<float> shadows)
      : seen_(seen), frame_(frame), squares_(squares), heights_(std::move(heights)), shadows_(std::move(shadows)) {}

  struct Known {
    std::uint64_t asked;      ///< rays that may be held back
    std::uint64_t in_shadow;  ///< rays that are
  };

  /// @param rays    of a group, which begins at `first`, that go straight to the light
  /// @param chosen  the rays in question; nothing is said of others
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

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/load.h"
#include "render/truth.h"

namespace rhoray::study {

/// How a shadow ray avoids hitting the surface in which it starts.
enum class Start {
  along_ray,     ///< starts a distance further along the ray
  along_normal,  ///< starts a distance off the surface, on the eye's side
  knows_side     ///< starts at the hit and knows its side of the surface, as in `render`
};
const char* name_of(Start start);

struct StartSettings {
  Start start = Start::knows_side;
  double epsilon_cells = 0;  ///< the distance
  /// For the hits and, where the side is known, for the shadow rays. Rays that start at a distance
  /// are traced in double precision, so that only their start can cause errors.
  render::Method method{};
  /// Whether positions of hits are rounded to single precision, as in systems that compute in it.
  bool is_rounded = false;
};

/// Shadow rays from hits, counted against the exact answer.
struct StartCounts {
  /// Numbers of all traced rays, and of those whose light is blocked.
  std::uint64_t rays = 0, dark = 0;
  std::uint64_t acne = 0;   ///< dark, but should be lit
  std::uint64_t leaks = 0;  ///< lit, but should be dark
};

/// The exactly decided pixels of a view whose light stands on the side that the eye sees, if it is
/// known whether the surface blocks the light. This is known if two exact answers agree: for rays
/// that start 1e-7 and 1e-5 cells off the exact hit, on the eye's side.
class ShadowStarts {
 public:
  /// @param towards_light  world axes, any length
  ShadowStarts(const render::Dataset& dataset, double isovalue, const render::Truth& truth, const Vec3& towards_light);

  std::uint64_t known() const { return cases_.size(); }
  std::uint64_t dark() const;
  /// Number of pixels where the two answers differ: they are not tested.
  std::uint64_t undecided() const { return undecided_; }

  /// Counts the pixels that the method hits within a hundredth of a cell of the exact hit.
  StartCounts count(const StartSettings& setting) const;

 private:
  struct Case {
    render::Ray seen;               ///< from the eye
    double t = 0, cells_per_t = 0;  ///< of its exact hit
    Vec3 normal{};                  ///< unit length in the world, towards the eye; in the volume's
                                    ///< frame
    /// per unit of length in the world
    double cells_along_normal = 0, cells_along_light = 0;
    render::StartSide side{};
    bool is_dark = false;
  };

  std::vector<render::Ray> off_surface(double cells) const;
  void decide();

  render::Dataset dataset_;
  double isovalue_;
  Vec3 light_{};  ///< one world unit towards the light, in the data's frame
  std::vector<Case> cases_;
  std::uint64_t undecided_ = 0;
};

}  // namespace rhoray::study

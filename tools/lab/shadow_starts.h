#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/load.h"
#include "tools/analysis/truth.h"

namespace rhoray::study {

/// How a ray towards a light is kept from meeting the surface that it starts in.
enum class Start {
  along_ray,     ///< it starts a distance further on its own way
  along_normal,  ///< it starts a distance off the surface, on the eye's side
  knows_side     ///< it starts in the hit and knows on which side of the surface, as `render` sends it
};
const char* name_of(Start start);

struct StartSettings {
  Start start = Start::knows_side;
  double epsilon_cells = 0;  ///< that distance
  /// Of the hits and, where the side is known, of the rays to the light. Rays that start at a distance are asked about
  /// in double precision, so that nothing but their start is to blame.
  render::Method method{};
  bool is_rounded =
      false;  ///< the hits' places are rounded to single precision, as systems hold them that compute in it
};

/// Rays from hits to a light, counted against the exact answer.
struct StartCounts {
  std::uint64_t rays = 0, dark = 0;  ///< of those asked: all, and those whose light is held back
  std::uint64_t acne = 0;            ///< dark, but should be lit
  std::uint64_t leaks = 0;           ///< lit, but should be dark
};

/// The judged pixels of a view whose light stands on the side that the eye sees, and of which is known whether the
/// surface holds it back: exact answers for rays that start 1e-7 and 1e-5 cells off the exact hit, on the eye's side,
/// agree.
class ShadowStarts {
 public:
  /// @param towards_light  world axes, any length
  ShadowStarts(const render::Volume& volume, double isovalue, const tools::Truth& truth, const Vec3& towards_light);

  std::uint64_t known() const { return cases_.size(); }
  std::uint64_t dark() const;
  std::uint64_t undecided() const { return undecided_; }  ///< where the two differ: they are asked nothing

  /// Of the pixels that the method hits within a hundredth of a cell of the exact hit.
  StartCounts count(const StartSettings& setting) const;

 private:
  struct Case {
    render::Ray seen;               ///< from the eye
    double t = 0, cells_per_t = 0;  ///< of its exact hit
    Vec3 normal{};                  ///< of unit length in the world, towards the eye; in the volume's frame
    double cells_along_normal = 0, cells_along_light = 0;  ///< in one unit of the world's length
    render::StartSide side{};
    bool is_dark = false;
  };

  std::vector<render::Ray> off_surface(double cells) const;
  void decide();

  render::Volume volume_;
  double isovalue_;
  Vec3 light_{};  ///< a world's unit towards it, in the volume's frame
  std::vector<Case> cases_;
  std::uint64_t undecided_ = 0;
};

}  // namespace rhoray::study

#pragma once

#include <array>
#include <cstdint>

#include "formats/base/affine.h"
#include "render/frame/worker.h"
#include "render/query/machine.h"

/// The arithmetic of rays towards light: plain loops over groups, compiled for each machine, with the same numbers on
/// all of them.
namespace rhoray::render {

/// Which groups have hits that are shown: LightRays::shown, by LightRays::is_shown of all rays.
void find_shown_groups(std::size_t count, LightRays& light);

/// Of each ray of these groups the side of its surface from which it has met it, by the gradient there; unknown where
/// there is none.
void find_sides_by_gradient(Machine machine, const LayerWork& work, LightRays& light);

/// Aims these groups' rays into one direction.
void aim_all(const Vec3& direction, LightRays& light);

/// Asks only about rays from hits that are shown, to light that stands before the surface on the side that the eye
/// sees: LightRays::t_max of the others is made `not_asked`.
/// @return  true where a hit is shown of which the side is unknown; of these all are asked about
bool ask_before_surfaces(Machine machine, const Affine& volume_from_world, const LayerWork& work, LightRays& light);

/// Of a group the rays that are asked about, a bit for each, by the side on which they start.
using RaysBySide = std::array<std::uint64_t, 3>;
constexpr std::size_t place_of(StartSide side) {
  return static_cast<std::size_t>(1 + static_cast<int>(side));
}
/// @param asked  of each of LightRays::shown
void find_asked(Machine machine, const LightRays& light, RaysBySide* asked);

/// How many rays of these groups are asked about.
std::uint64_t asked_count(Machine machine, const LightRays& light);

/// Of each ray of these groups 1 where it is still asked about, else 0.
void share_of_asked(Machine machine, const LightRays& light, float* shares);

/// Writes those rays of a group that are asked about, as the volume of a layer sees them.
struct GroupToWrite {
  std::size_t first;                 ///< of the hits in their batch
  std::uint64_t chosen;              ///< that are asked about
  std::size_t place;                 ///< of the group among the rays that are written
  std::array<StartSide, 3> side_of;  ///< for the layer, of rays that start outside, unknown, inside
};
/// @param hits      their t
/// @param eye_rays  that met them, in the frame of the layer's volume
void write_light_rays(Machine machine, const LightRays& light, const GroupToWrite& group,
                      const Affine& volume_from_world, const HitBatch& hits, const RayBatch& eye_rays, RayBatch& rays);

/// As LightRays::t_max, where nothing is asked.
inline constexpr double not_asked = -1;

}  // namespace rhoray::render

#pragma once

#include <array>
#include <cstdint>

#include "formats/base/affine.h"
#include "render/frame/worker.h"
#include "render/query/machine.h"

/// Arithmetic of rays towards lights: plain loops over groups, compiled for each machine, with the
/// same numbers on all machines.
namespace rhoray::render {

/// Finds the groups that have shown hits: sets LightRays::shown from LightRays::is_shown of all
/// rays.
void find_shown_groups(std::size_t count, LightRays& light);

/// Finds, for each ray of these groups, on which side of the surface the ray arrived, from the
/// gradient there. The side is unknown where there is no gradient.
void find_sides_by_gradient(Machine machine, const LayerWork& work, LightRays& light);

/// Aims the rays of these groups in one direction.
void aim_all(const Vec3& direction, LightRays& light);

/// Selects the rays to be traced: from shown hits to lights in front of the surface, on the side
/// that the eye sees. LightRays::t_max of the other rays becomes `not_asked`.
/// @return  true if a shown hit has an unknown side; the rays of such hits are all selected
bool ask_before_surfaces(Machine machine, const Affine& data_from_world, const LayerWork& work, LightRays& light);

/// Traced rays of a group, one bit each, by the side on which they start.
using RaysBySide = std::array<std::uint64_t, 3>;
constexpr std::size_t place_of(StartSide side) {
  return static_cast<std::size_t>(1 + static_cast<int>(side));
}
/// @param asked  one entry for each group in LightRays::shown
void find_asked(Machine machine, const LightRays& light, RaysBySide* asked);

/// Number of rays of these groups that are traced.
std::uint64_t asked_count(Machine machine, const LightRays& light);

/// Writes 1 for each ray of these groups that is still traced, else 0.
void share_of_asked(Machine machine, const LightRays& light, float* shares);

/// A group whose traced rays are written in the frame of a layer's dataset.
struct GroupToWrite {
  std::size_t first;     ///< first ray of the group in the batch of hits
  std::uint64_t chosen;  ///< bits of the rays that are traced
  std::size_t place;     ///< first ray of the group among the rays written
  /// For the layer: sides of rays that start outside, unknown, inside.
  std::array<StartSide, 3> side_of;
};
/// @param hits      their t is read
/// @param eye_rays  the rays that made the hits, in the frame of the layer's dataset
void write_light_rays(Machine machine, const LightRays& light, const GroupToWrite& group, const Affine& data_from_world,
                      const HitBatch& hits, const RayBatch& eye_rays, RayBatch& rays);

/// Value of LightRays::t_max for rays that are not traced.
inline constexpr double not_asked = -1;

}  // namespace rhoray::render

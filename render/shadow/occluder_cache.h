#pragma once

#include <memory>
#include <vector>

#include "render/shadow/grid_occluders.h"
#include "render/shadow/occluders.h"

namespace rhoray::render::wide {

/// Keeps occluders from frame to frame: they depend on the isovalue and on the light's position in
/// the volume's frame, not on the camera. For a mesh's surface the certain shadows are computed
/// from the second request on, whatever the light. Their cost arises once per surface, and an
/// isovalue that is shown for one frame does not pay for it. Not thread-safe.
class OccluderCache {
 public:
  /// @param query  a query that wide kernels answer
  /// @return       null where the occluders are not known to be less than the whole surface: in
  ///   meshes as for facets_with_occluders, in grids as for SurfaceCells::of, and in grids also
  ///   unless the light is directional
  std::shared_ptr<const LightOccluders> of(const VolumeImplementation& volume, const RayQuery& query,
                                           const LightPlace& light, unsigned threads);

 private:
  struct OfLight {
    LightPlace light;
    std::shared_ptr<const LightOccluders> occluders;
    Shadows shadows;
  };
  struct OfSurface {
    std::shared_ptr<const void> surface;  ///< facets, or the occupancy of the cells
    std::shared_ptr<const SurfaceCells> cells;
    std::vector<OfLight> lights;  ///< newest first
  };

  static constexpr std::size_t most_kept = 4;
  std::vector<OfSurface> kept_;  ///< newest first
};

}  // namespace rhoray::render::wide

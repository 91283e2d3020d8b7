#pragma once

#include <memory>
#include <vector>

#include "render/shadow/grid_occluders.h"
#include "render/shadow/occluders.h"

namespace rhoray::render::wide {

/// What may hold light back, kept from frame to frame: it depends on the isovalue and on where the light stands in the
/// volume's frame, not on the camera. Of a mesh's surface shadows are known from the second time on that it is asked
/// about, whatever the light: what they take is found once for each surface, and an isovalue that is seen for one frame
/// does not pay for it. Not for two threads at once.
class OccluderCache {
 public:
  /// @param question  of which wide kernels find crossings
  /// @return          null where it is not known to be less than all of the surface: in meshes as facets_with_occluders
  ///                  says, in grids as SurfaceCells::of does, and there unless the light stands in one direction
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

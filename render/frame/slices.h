#pragma once

#include <cstdint>
#include <optional>

#include "render/dataset/volume.h"
#include "render/query/batch.h"
#include "render/scene.h"
#include "render/shade/place_lookup.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// A plane through a volume, on which rays see the volume's own field.
///
/// A ray meets the plane at the t that a face of a clip region in the same plane ends it at, bit for bit: a plane that
/// is a face of the region, to rounding, whichever way their normals point, is that face.
class SlicePlane {
 public:
  /// @param clip  whose faces the plane may be
  SlicePlane(const VolumeImplementation& volume, const Layer& layer, const std::optional<Clip>& clip);

  /// Where the plane may be seen, volume frame.
  SurfaceBoxes boxes() const;

  /// Rays of a batch that are asked, beside the part between t_min and t_max, from another t on.
  struct SecondParts {
    const double* begin = nullptr;  ///< of each ray; null: there are none
    const double* end = nullptr;    ///< null: they do not end
  };

  /// Hits where rays meet the plane, and the field has a value there that is shown: its value, and the plane's normal
  /// as gradient.
  /// @param in_world  the same rays in world axes
  /// @return          how many places were looked up
  std::uint64_t ask(const RayBatch& rays, const RayBatch& in_world, const SecondParts& parts, HitBatch& hits) const;

 private:
  /// Where the rays of a group meet the plane; infinity for those that are not asked.
  bool find_times(const RayBatch& rays, const RayBatch& in_world, const SecondParts& parts, std::size_t first,
                  double* t) const;

  const VolumeImplementation& volume_;
  Vec3 point_, normal_;                ///< world axes
  Vec3 point_volume_, normal_volume_;  ///< the normal as a gradient
  Vec3 slack_;                         ///< on each axis of the volume's frame, of the plane's place
  Interval<double> threshold_;
  PlaceLookup lookup_;
};

}  // namespace rhoray::render

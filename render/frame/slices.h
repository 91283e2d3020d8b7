#pragma once

#include <cstdint>
#include <optional>

#include "render/dataset/loaded_dataset.h"
#include "render/query/batch.h"
#include "render/scene.h"
#include "render/shade/place_lookup.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// A plane through a dataset, on which rays see the dataset's own field.
///
/// A plane that coincides, up to rounding, with a face of the clip region is treated as that face,
/// whichever way their normals point. Then a ray meets the plane at exactly the t at which the face
/// ends it, bit for bit.
class SlicePlane {
 public:
  /// The numbers are the same on every machine.
  /// @param clip  the region whose faces the plane may be
  SlicePlane(const LoadedDataset& dataset, const Layer& layer, const std::optional<Clip>& clip, Machine machine);

  /// Boxes in which the plane may be visible, data frame.
  SurfaceBoxes boxes() const;

  /// Second parts of a batch's rays, traced besides the part between t_min and t_max.
  struct SecondParts {
    const double* begin = nullptr;  ///< start for each ray; null: there are none
    const double* end = nullptr;    ///< null: they do not end
  };

  /// Writes a hit where a ray meets the plane and the field has a value within the threshold. The
  /// hit has that value, and the plane's normal as its gradient.
  /// @param in_world  the same rays in world axes
  /// @return          number of positions looked up
  std::uint64_t ask(const RayBatch& rays, const RayBatch& in_world, const SecondParts& parts, HitBatch& hits) const;

 private:
  /// Finds t at which the rays of a group meet the plane; infinity for rays that are not traced.
  bool find_times(const RayBatch& rays, const RayBatch& in_world, const SecondParts& parts, std::size_t first,
                  double* t) const;

  const LoadedDataset& dataset_;
  Vec3 point_, normal_;            ///< world axes
  Vec3 point_data_, normal_data_;  ///< the normal transformed as a gradient
  /// Largest possible rounding error of a point of the plane, on each axis of the data frame.
  Vec3 slack_;
  Interval<double> threshold_;
  PlaceLookup lookup_;
};

}  // namespace rhoray::render

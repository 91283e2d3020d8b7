#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "render/dataset/volume.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// What is to be known at hits beyond what kernels say of them.
struct HitAttributes {
  bool smooth_gradients =
      false;  ///< in meshes: linear in the hit cell between gradients at its points; in surfaces: between normals
  std::optional<std::string> field;  ///< of the same file, the volume's own included

  bool none() const { return !smooth_gradients && !field; }
};

/// CandidateList up, in the cell of a hit, what a frame wishes to know there; chosen once per frame. The volume must
/// outlive it.
///
/// In a mesh a hit's weights in its cell are those of its place, moved along the surface's gradient to where the
/// volume's own field has the hit's value; where rounding, or a cell without volume, leaves the place unsaid, they are
/// those of some place in the cell where the field has that value. So the own field's value at a hit is that of the
/// hit, to rounding, and every other value lies between those of the cell's points. In a grid fields are trilinear at
/// the hit, moved into its cell where rounding has led it out.
class HitLookup {
 public:
  /// Makes what is kept with the volume (point_gradients.h), by so many threads (0: all cores). Refuses smooth
  /// gradients in grids and an unknown field (ErrorCode::usage), and another grid of an OpenVDB file
  /// (ErrorCode::unsupported). The same numbers on every machine.
  HitLookup(const VolumeImplementation& volume, const HitAttributes& attributes, unsigned threads,
            Machine machine = chosen_machine());

  /// For the group of first crossings that begins at `first`: writes the field's values, NaN where the cell has a point
  /// without data, and gradients in the place of the hits' own, which stay where the smooth one is zero or not finite.
  /// @param values  room for a group; left as it is without a field. Any numbers where nothing was hit
  void operator()(const RayBatch& rays, HitBatch& hits, std::size_t first, double* values) const {
    look_up_(rays, hits, first, values);
  }

 private:
  std::function<void(const RayBatch& rays, HitBatch& hits, std::size_t first, double* values)> look_up_;
};

}  // namespace rhoray::render

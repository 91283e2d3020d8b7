#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "render/dataset/loaded_dataset.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// Attributes needed at hits besides those that kernels return.
struct HitAttributes {
  /// In meshes: linear in the hit cell between gradients at its points; in surfaces: between
  /// normals; in grids: trilinear between central differences (grid/smooth_gradient.h).
  bool smooth_gradients = false;
  std::optional<std::string> field;  ///< a field of the same file (Dataset::field), or its own

  bool none() const { return !smooth_gradients && !field; }
};

/// Looks up attributes of a frame's hits in their cells; chosen once per frame. The dataset must
/// outlive it.
///
/// In a mesh, the hit's barycentric weights belong to its position, moved along the surface's
/// gradient to where the dataset's own field has the hit's value. Where rounding or a cell without
/// volume leaves the position undefined, they belong to some position in the cell where the field
/// has that value. So the own field's value at a hit equals the hit's, up to rounding. Every other
/// field of points has a value between its values at the cell's points. A field of cells has the
/// value of the hit's cell.
///
/// On the boundary of a mesh, the weights belong to the hit's position in the triangle's cell. The
/// field's value there becomes the hit's value.
///
/// In a grid, fields are trilinear at the hit, which is moved into its cell where rounding has put
/// it outside.
class HitLookup {
 public:
  /// Computes the data kept with the dataset (point_gradients.h, corner_normals.h) with `threads`
  /// threads (0: all cores). Refuses an unknown field (ErrorCode::usage), and another grid of an
  /// OpenVDB file (ErrorCode::unsupported). The numbers are the same on every machine.
  /// @param stop  ends the computation (ErrorCode::interrupted); then nothing of it is kept
  HitLookup(const LoadedDataset& dataset, const HitAttributes& attributes, unsigned threads,
            Machine machine = chosen_machine(), const std::stop_token& stop = {});

  /// Handles the group of first crossings that begins at `first`. Writes the field's values, NaN
  /// where the cell has a point without data. Overwrites the hits' gradients, except where the
  /// smooth gradient is zero or not finite.
  /// @param values  room for a group; unchanged without a field. Undefined where nothing was hit
  void operator()(const RayBatch& rays, HitBatch& hits, std::size_t first, double* values) const {
    look_up_(rays, hits, first, values);
  }

 private:
  std::function<void(const RayBatch& rays, HitBatch& hits, std::size_t first, double* values)> look_up_;
};

}  // namespace rhoray::render

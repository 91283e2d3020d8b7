#pragma once

#include <cstdint>
#include <span>

#include "formats/base/progress.h"
#include "formats/base/vector.h"
#include "render/load.h"

namespace rhoray::render {

/// The field at a point.
struct PointValue {
  static constexpr std::uint64_t no_cell = ~std::uint64_t{0};

  double value;        ///< NaN: no data there
  std::uint64_t cell;  ///< id of a cell that contains the point, the smallest of a mesh; or no_cell
};

/// Evaluates a dataset's field at points in double precision: trilinear in the cells of a grid,
/// linear in those of a mesh. A point in a face between cells has a value if one of them has data.
/// A point of the border, or beside it by the rounding of world coordinates, belongs to the cell
/// there. The answers do not depend on the order of the points.
///
/// Refuses a surface (ErrorCode::usage). Runs on the calling thread; several threads may call at a
/// time.
/// @param points  finite, world axes
/// @param values  as many
/// @param watch   a stop request ends the evaluation, but not the sorting of the points
void point_values(const Dataset& dataset, std::span<const Vec3> points, std::span<PointValue> values,
                  const Watch& watch = {});

}  // namespace rhoray::render

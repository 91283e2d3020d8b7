#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "formats/base/vector.h"
#include "render/dataset/loaded_dataset.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// Positions in a plane of a data's frame, side by side.
struct PlacesInPlane {
  static constexpr std::size_t size = RayBatch::group_size;

  alignas(64) double at[3][size];
  bool is_asked[size];
  Vec3 normal;  ///< of the plane: normal . position equals `offset` up to slack
  double offset;
  double slack[3];  ///< on each axis, above the error of the positions
};

/// Results for these positions.
struct PlaceAnswers {
  static constexpr std::size_t size = PlacesInPlane::size;

  alignas(64) double value[size];  ///< NaN where nothing was looked up or there is no data
  std::uint64_t cell[size];
  std::uint32_t tet[size];   ///< in a mesh: index of that cell
  std::uint32_t cost[size];  ///< cells examined
};

/// Evaluates a dataset's own field at positions; chosen once per frame. The dataset must outlive
/// it.
///
/// The field is trilinear in the cells of a grid, and linear in those of a mesh. A position on a
/// face between cells has data if any of these cells has data, up to slack. So neither the border
/// of the data nor a face of a cell without data flickers, and there are no gaps between cells. In
/// a mesh, both cells of a face compute the same number, and its sign decides on which side of the
/// face a position is. By rounding, a position may belong to none of the cells around an edge, or
/// be just outside the mesh; the nearest cell up to slack away gets it. If several cells contain a
/// position, the one with the smallest id is used, so that the result does not depend on the other
/// positions of a query.
class PlaceLookup {
 public:
  /// Refuses a dataset without a field (ErrorCode::usage). The numbers are the same on every
  /// machine.
  explicit PlaceLookup(const LoadedDataset& dataset, Machine machine = chosen_machine());

  void operator()(const PlacesInPlane& places, PlaceAnswers& answers) const { look_up_(places, answers); }

 private:
  std::function<void(const PlacesInPlane& places, PlaceAnswers& answers)> look_up_;
};

}  // namespace rhoray::render

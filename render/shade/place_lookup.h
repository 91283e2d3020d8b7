#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "formats/base/vector.h"
#include "render/dataset/volume.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// Places of a volume's frame in a plane of it, side by side.
struct PlacesInPlane {
  static constexpr std::size_t size = RayBatch::group_size;

  alignas(64) double at[3][size];
  bool is_asked[size];
  Vec3 normal;  ///< of the plane: normal . place is `offset`, to slack
  double offset;
  double slack[3];  ///< on each axis, more than places are off
};

/// What lies there.
struct PlaceAnswers {
  static constexpr std::size_t size = PlacesInPlane::size;

  alignas(64) double value[size];  ///< NaN where nothing was asked, or there is no data
  std::uint64_t cell[size];
  std::uint32_t tet[size];   ///< in a mesh the position of that cell
  std::uint32_t cost[size];  ///< cells looked into
};

/// The value of a volume's own field at places, chosen once per frame; the volume must outlive it.
///
/// In a grid the field is trilinear in its cells, in a mesh linear. A place in a face between cells has data where any
/// of them has, to slack: neither the border of the data nor a face of a cell without data flickers, and there are no
/// gaps between cells. In a mesh a place is on one side of a face or on the other by a number that both its cells
/// compute alike; a place that rounding leaves to none of the cells around an edge, or just outside the mesh, is the
/// nearest cell's, up to slack away. Of several cells that hold a place the one of the smallest id answers, so that
/// the answer does not depend on who asks beside it.
class PlaceLookup {
 public:
  /// Refuses a volume without a field (ErrorCode::usage). The same numbers on every machine.
  explicit PlaceLookup(const VolumeImplementation& volume, Machine machine = chosen_machine());

  void operator()(const PlacesInPlane& places, PlaceAnswers& answers) const { look_up_(places, answers); }

 private:
  std::function<void(const PlacesInPlane& places, PlaceAnswers& answers)> look_up_;
};

}  // namespace rhoray::render

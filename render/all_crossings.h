#pragma once

#include <cstddef>
#include <vector>

#include "render/load.h"
#include "render/query/crossings.h"

namespace rhoray::render {

struct AllCrossings {
  std::vector<Crossing> crossings;  ///< in their order along the ray; t never decreases
  bool truncated = false;           ///< there are more
};

/// Finds all points at which a ray passes from one side of the isosurface to the other, in exact
/// arithmetic. The ray is in the data's own frame (RayCaster), and t counts lengths of its
/// direction.
///
/// Inside is value >= isovalue. There is no surface at the border of the data or of cells without
/// data: the ray has the side that it finds there. A ray that only touches the isosurface from
/// outside enters and leaves there: two crossings with one t. At the end of the data or of the ray
/// it only enters. The first crossing is that of Method::Algorithm::exact, bit for bit.
///
/// Refuses an isovalue that is not finite (ErrorCode::usage), triangles, which have no isosurface
/// (ErrorCode::unsupported), and data whose stored ranges do not hold (Dataset::prove_ranges,
/// ErrorCode::invalid). Any thread may call.
///
/// @param most  the number of crossings returned at most, nearest to the ray's start
AllCrossings all_crossings(const Dataset& dataset, double isovalue, const Ray& ray, std::size_t most);

}  // namespace rhoray::render

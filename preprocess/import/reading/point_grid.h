#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// One array of a file that stores several, with values at grid points or in grid cells.
struct GridArray {
  std::string name;
  formats::ElementType type = formats::ElementType::U8;
  int component_count = 1;
  bool in_cells = false;
  std::string unit{};
  Array<std::byte> values{};                 ///< in native byte order; either these
  std::function<Array<std::byte>()> load{};  ///< or what reads them when the array is chosen
};

/// A grid of points. Sample (i, j, k) lies at world_from_grid.point({i, j, k}). On an axis with a
/// table, the table's entry replaces the index.
struct PointGrid {
  Index3 point_count;
  Affine world_from_grid;
  std::array<std::vector<double>, 3> axes{};
};

}  // namespace rhoray::preprocess

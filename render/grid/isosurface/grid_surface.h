#pragma once

#include <algorithm>
#include <cmath>

#include "render/dataset/fit_grid.h"
#include "render/dataset/loaded_dataset.h"
#include "render/grid/isosurface/parts.h"

/// Which isovalues of grids the SIMD kernels for isosurfaces accept, and the surfaces that these
/// kernels receive.
namespace rhoray::render::wide {

/// True where no difference between values and isovalue, and no product of such differences, leaves
/// the range of single precision.
inline bool is_in_range_of_float(const Interval<double>& range, double isovalue) {
  const double largest = std::max(std::abs(range.lo - isovalue), std::abs(range.hi - isovalue));
  return largest <= 0x1p60 && largest >= 0x1p-60;
}

inline IsosurfaceQuery surface_of(const UniformGrid& view, const Occupancy& occupancy, const RayQuery& query) {
  const Index3 cells = view.lattice().leaf_count;
  return {.source = *view.source(),
          .leaf_count = {static_cast<int>(cells.x), static_cast<int>(cells.y), static_cast<int>(cells.z)},
          .node_count = occupancy.node_count(),
          .nodes = occupancy.nodes(),
          .super_nodes = occupancy.super_nodes(),
          .isovalue = query.isovalue,
          .time_phases = query.time_phases};
}

/// For a grid that is fit (fit_grid).
inline bool is_answerable_wide(const UniformGrid& grid, const RayQuery& query) {
  return query.use_hierarchy && is_in_range_of_float(grid.values(), query.isovalue);
}

}  // namespace rhoray::render::wide

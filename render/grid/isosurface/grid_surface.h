#pragma once

#include <algorithm>
#include <cmath>

#include "render/dataset/grid_source.h"
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

template <class View>
IsosurfaceQuery surface_of(const LoadedDataset& dataset, const View& view, const Occupancy& occupancy,
                           const RayQuery& query) {
  const Index3 cells = view.lattice().leaf_count;
  IsosurfaceQuery surface{
      .source = source_of(view),
      .type = formats::element_type_of<typename View::Sample>(),
      .leaf_count = {static_cast<int>(cells.x), static_cast<int>(cells.y), static_cast<int>(cells.z)},
      .node_count = occupancy.node_count(),
      .nodes = occupancy.nodes(),
      .super_nodes = occupancy.super_nodes(),
      .isovalue = query.isovalue,
      .time_phases = query.time_phases};
  surface.source.has_gaps = has_gaps(dataset, view);
  return surface;
}

/// For a grid that is fit (is_fit_grid).
inline bool is_answerable_wide(const LoadedDataset& dataset, const RayQuery& query) {
  return query.use_hierarchy && is_in_range_of_float(values_of(dataset), query.isovalue);
}

}  // namespace rhoray::render::wide

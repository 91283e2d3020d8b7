#pragma once

#include <algorithm>
#include <cmath>

#include "render/kernels/wide/isosurface_parts.h"
#include "render/volumes/volume.h"

/// Which grids and isovalues the wide kernels for isosurfaces take, and what they see of them.
namespace rhoray::render::wide {

/// The grids that wide kernels take: their index in the list of views is below the first of any other kind.
template <class View>
inline constexpr bool is_uniform_grid = false;
template <class T>
inline constexpr bool is_uniform_grid<GridVolume<T>> = true;

/// True where no difference between values and isovalue, nor a product of it, leaves the range of single precision.
inline bool is_in_range_of_float(const Interval<double>& range, double isovalue) {
  const double largest = std::max(std::abs(range.lo - isovalue), std::abs(range.hi - isovalue));
  return largest <= 0x1p60 && largest >= 0x1p-60;
}

template <class T>
Surface surface_of(const GridVolume<T>& view, const Occupancy& occupancy, const Question& question) {
  const formats::GridDescription& grid = view.description();
  const Index3 cells = grid.macro.leaf_count;
  return {.source = SampleSource(view.samples().data(), view.tables(), grid.layout.sample_count),
          .type = formats::element_type_of<T>(),
          .leaf_count = {static_cast<int>(cells.x), static_cast<int>(cells.y), static_cast<int>(cells.z)},
          .node_count = occupancy.node_count(),
          .nodes = occupancy.nodes(),
          .summits = occupancy.summits(),
          .isovalue = question.isovalue,
          .time_phases = question.time_phases};
}

/// Of a grid that is fit.
inline bool is_answerable_wide(const VolumeImplementation& volume, const Question& question) {
  return question.use_hierarchy && is_in_range_of_float(volume.field.range, question.isovalue);
}

/// A grid with macro levels that are trees of 64 children.
inline bool is_fit_grid(const VolumeImplementation& volume) {
  return std::visit(
      [&]<class View>(const View& view) {
        if constexpr (is_uniform_grid<View>)
          return view.lattice().factor == 4;
        else
          return false;
      },
      volume.view);
}

}  // namespace rhoray::render::wide

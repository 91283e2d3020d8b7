#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

#include "render/kernels/wide/isosurface_parts.h"
#include "render/volumes/volume.h"

/// Which grids and isovalues the wide kernels for isosurfaces take, and what they see of them.
namespace rhoray::render::wide {

/// Uniform grids that store all of their samples: all wide kernels take them.
template <class View>
inline constexpr bool is_uniform_grid = false;
template <class T>
inline constexpr bool is_uniform_grid<GridVolume<T>> = true;

/// Uniform grids of which only some bricks are stored.
template <class View>
inline constexpr bool is_in_bricks = false;
template <class T>
inline constexpr bool is_in_bricks<SparseVolume<T>> = true;
template <>
inline constexpr bool is_in_bricks<NanoVdbVolume> = true;

/// What is asked for isosurfaces wide.
template <class View>
inline constexpr bool has_wide_surfaces = is_uniform_grid<View> || is_in_bricks<View>;

/// True where some samples may have no data.
template <class View>
bool has_gaps(const VolumeImplementation& volume, const View& view) {
  if constexpr (std::is_same_v<View, NanoVdbVolume>)
    return view.has_gaps();
  else
    return volume.field.no_data_count > 0;
}

/// True where no difference between values and isovalue, nor a product of it, leaves the range of single precision.
inline bool is_in_range_of_float(const Interval<double>& range, double isovalue) {
  const double largest = std::max(std::abs(range.lo - isovalue), std::abs(range.hi - isovalue));
  return largest <= 0x1p60 && largest >= 0x1p-60;
}

template <class T>
SampleSource source_of(const GridVolume<T>& view) {
  return SampleSource(view.samples().data(), view.tables(), view.description().layout.sample_count);
}
template <class View>
requires is_in_bricks<View> SampleSource source_of(const View& view) {
  return SampleSource(view.bricks(), view.lattice().leaf_count + Index3(1, 1, 1));
}

template <class View>
Surface surface_of(const VolumeImplementation& volume, const View& view, const Occupancy& occupancy,
                   const Question& question) {
  const Index3 cells = view.lattice().leaf_count;
  Surface surface{.source = source_of(view),
                  .type = View::sample_type,
                  .leaf_count = {static_cast<int>(cells.x), static_cast<int>(cells.y), static_cast<int>(cells.z)},
                  .node_count = occupancy.node_count(),
                  .nodes = occupancy.nodes(),
                  .summits = occupancy.summits(),
                  .isovalue = question.isovalue,
                  .time_phases = question.time_phases};
  surface.source.has_gaps = has_gaps(volume, view);
  return surface;
}

/// Of a grid that is fit.
inline bool is_answerable_wide(const VolumeImplementation& volume, const Question& question) {
  const auto* in_memory = std::get_if<NanoVdbVolume>(&volume.view);
  const Interval<double> values = in_memory ? in_memory->values() : volume.field.range;
  return question.use_hierarchy && is_in_range_of_float(values, question.isovalue);
}

/// A grid with macro levels that are trees of 64 children, of which bricks are no smaller than the blocks of the
/// lowest.
inline bool is_fit_grid(const VolumeImplementation& volume) {
  return std::visit(
      [&]<class View>(const View& view) {
        if constexpr (is_in_bricks<View>)
          return view.lattice().factor == 4 && view.bricks().shift >= 6 && !view.bricks().slots.empty();
        else if constexpr (is_uniform_grid<View>)
          return view.lattice().factor == 4;
        else
          return false;
      },
      volume.view);
}

}  // namespace rhoray::render::wide

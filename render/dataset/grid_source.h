#pragma once

#include <type_traits>
#include <variant>

#include "render/dataset/loaded_dataset.h"
#include "render/grid/block_samples.h"

/// Which views are grids, which of them SIMD kernels accept, and where these find their samples.
namespace rhoray::render::wide {

template <class View>
inline constexpr bool is_grid = false;
template <class... Kind>
inline constexpr bool is_grid<GridData<Kind...>> = true;
template <>
inline constexpr bool is_grid<NanoVdbData> = true;

/// Uniform grids that store all of their samples.
template <class View>
inline constexpr bool is_uniform_grid = false;
template <class T>
inline constexpr bool is_uniform_grid<GridData<T>> = true;

/// Uniform grids that store only some bricks.
template <class View>
inline constexpr bool is_in_bricks = false;
template <class T>
inline constexpr bool is_in_bricks<SparseGridData<T>> = true;
template <>
inline constexpr bool is_in_bricks<NanoVdbData> = true;

template <class View>
inline constexpr bool is_taken_wide = is_uniform_grid<View> || is_in_bricks<View>;

/// True where some samples may have no data.
template <class View>
bool has_gaps(const LoadedDataset& dataset, const View& view) {
  if constexpr (std::is_same_v<View, NanoVdbData>)
    return view.has_gaps();
  else
    return dataset.field.no_data_count > 0;
}

/// The range of all samples that have data.
inline Interval<double> values_of(const LoadedDataset& dataset) {
  const auto* in_memory = std::get_if<NanoVdbData>(&dataset.view);
  return in_memory ? in_memory->values() : dataset.field.range;
}

template <class T>
SampleSource source_of(const GridData<T>& view) {
  return SampleSource(view.samples().data(), view.tables(), view.description().layout.sample_count);
}
template <class View>
requires is_in_bricks<View> SampleSource source_of(const View& view) {
  return SampleSource(view.bricks(), view.lattice().leaf_count + Index3(1, 1, 1));
}

/// True for a grid whose macro levels are trees of 64 children and whose bricks are no smaller than
/// the blocks of the lowest level.
inline bool is_fit_grid(const LoadedDataset& dataset) {
  return std::visit(
      [&]<class View>(const View& view) {
        if constexpr (is_in_bricks<View>)
          return view.lattice().factor == 4 && view.bricks().shift >= 6 && !view.bricks().slots.empty();
        else if constexpr (is_uniform_grid<View>)
          return view.lattice().factor == 4;
        else
          return false;
      },
      dataset.view);
}

}  // namespace rhoray::render::wide

#include "preprocess/values/leaf_ranges.h"

#include <cstddef>

#include "formats/base/interval.h"
#include "formats/base/parallel.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

template <class T>
Interval<T> range_of_cell(const std::array<std::uint32_t, 4>& cell, std::span<const T> values) {
  Interval<T> range;
  for (const std::uint32_t vertex : cell) {
    if (!has_data(values[vertex])) return {};
    range.include(values[vertex]);
  }
  return range;
}

}  // namespace

template <class T>
Array<T> build_leaf_ranges(std::span<const std::array<std::uint32_t, 4>> cells, std::span<const T> values,
                           const formats::LeafListsView& lists) {
  // A cell is in many lists, so its own range is computed once.
  Array<Interval<T>> of_cells(cells.size());
  parallel_for(cells.size(), 4096, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) of_cells[c] = range_of_cell(cells[c], values);
  });
  const std::size_t leaf_count = lists.offsets.size() - 1;
  Array<T> ranges(2 * leaf_count);
  parallel_for(leaf_count, 4096, [&](const IndexRange& part) {
    for (std::size_t leaf = part.begin(); leaf < part.end(); ++leaf) {
      Interval<T> range;
      for (const std::uint32_t cell : lists.list(leaf)) range.include(of_cells[cell]);
      ranges[2 * leaf] = range.lo;
      ranges[2 * leaf + 1] = range.hi;
    }
  });
  return ranges;
}

template Array<float> build_leaf_ranges(std::span<const std::array<std::uint32_t, 4>>, std::span<const float>,
                                        const formats::LeafListsView&);
template Array<double> build_leaf_ranges(std::span<const std::array<std::uint32_t, 4>>, std::span<const double>,
                                         const formats::LeafListsView&);

}  // namespace rhoray::preprocess

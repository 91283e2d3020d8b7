#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "formats/base/vector.h"

namespace rhoray::preprocess {

/// A part of a grid: its first and last point along each axis.
struct GridExtent {
  Index3 first{0, 0, 0}, last{0, 0, 0};
};

/// Number of points, or of cells: one fewer on each axis with more than one point.
Index3 owner_count(const GridExtent& extent, bool in_cells);

/// True when the parts lie inside the whole, and each cell of it is in exactly one of them.
bool cover_once(const GridExtent& whole, std::span<const GridExtent> parts);

/// Copies an array of a part to its place in the array of the whole, x fastest, `width` items for
/// each point or cell.
template <class T>
void copy_to_whole(std::span<const T> part, const GridExtent& extent, const GridExtent& whole, bool in_cells,
                   std::int64_t width, std::span<T> to) {
  const Index3 size = owner_count(extent, in_cells), whole_size = owner_count(whole, in_cells);
  const Index3 first = extent.first - whole.first;
  for (std::int64_t row = 0; row < size.y * size.z; ++row) {
    const std::int64_t j = first.y + row % size.y, k = first.z + row / size.y;
    std::copy_n(part.begin() + row * size.x * width, size.x * width,
                to.begin() + ((k * whole_size.y + j) * whole_size.x + first.x) * width);
  }
}

}  // namespace rhoray::preprocess

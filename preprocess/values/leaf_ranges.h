#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "formats/leaf_lists.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Builds level 0 of a mesh's hierarchy: for each leaf cell the range of the values at the vertices
/// of the cells in its list, lo before hi. A cell with a vertex that has no data is absent and adds
/// nothing. A leaf cell without other cells is empty. T is float or double.
template <class T>
Array<T> build_leaf_ranges(std::span<const std::array<std::uint32_t, 4>> cells, std::span<const T> values,
                           const formats::LeafListsView& lists);

}  // namespace rhoray::preprocess

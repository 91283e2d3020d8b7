#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/brick_grid.h"

namespace rhoray::preprocess {

/// An integer that marks the samples of one object, such as an organ in a segmentation.
struct Label {
  int value = 0;
  Index3 first, end;  ///< box around its samples: first <= (i, j, k) < end
};

inline constexpr std::size_t most_labels = 32;  ///< besides 0, the background

/// The labels of a field, ascending, without 0. Nothing for a field that is no segmentation: one of
/// floating-point numbers, of fewer than two or more than most_labels labels, or one in which more
/// than three in ten neighbours along x differ, where one of them is not 0.
std::optional<std::vector<Label>> find_labels(const formats::BrickGrid& grid, std::size_t field);

/// Packs the indicator of a label into memory: 1 at its samples, 0 at others. Its isosurface at 1/2
/// is the surface of the label. The grid covers the label's box and one sample around it, where
/// there is one; it lies where the samples lie.
formats::PackedFile pack_indicator(const formats::BrickGrid& grid, std::size_t field, const Label& label);

}  // namespace rhoray::preprocess

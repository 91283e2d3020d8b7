#pragma once

#include <span>
#include <vector>

#include "formats/base/progress.h"
#include "formats/base/vector.h"
#include "formats/macro_levels.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The intervals of every level, ready to be written: levels[l - first_level] is laid out as
/// described in MacroLevelsView.
template <class T>
using Levels = std::vector<Array<T>>;

/// Builds levels 1 and up of a grid. A macrocell's interval is the range of the samples at the
/// corners of its leaf cells. Absent leaf cells (those with a corner that is NaN or infinite) do
/// not count. The interval is empty exactly when all of them are absent.
/// @param samples  x fastest, shape.leaf_count + 1 per axis
template <class T>
Levels<T> build_grid_levels(std::span<const T> samples, const formats::MacroShape& shape,
                            const Progress& progress = {});

/// Adds the levels above the leaf cells to `levels`, which holds level 0 only.
template <class T>
void add_levels_above_leaves(Levels<T>& levels, const formats::MacroShape& shape);

}  // namespace rhoray::preprocess

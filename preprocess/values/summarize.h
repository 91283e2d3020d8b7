#pragma once

#include <span>
#include <string>

#include "formats/base/progress.h"
#include "formats/field_summary.h"

namespace rhoray::preprocess {

/// Computes the range, the count of values without data, and the histogram of a field. T is any
/// element type but the 64-bit integers.
///
/// The histogram has 256 equal bins over the range. Integers that span fewer than 256 steps get one
/// bin for each integer, so that rounding leaves no bin between two others empty. Where all values
/// are equal there is one bin; where no value is finite, none. formats::histogram_bin defines which
/// bin counts a value.
template <class T>
formats::FieldSummary summarize(std::span<const T> values, std::string name, std::string unit,
                                const Progress& progress = {});

}  // namespace rhoray::preprocess

#pragma once

#include <span>
#include <string>

#include "formats/field_summary.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// Range, count of values without data, and histogram of a field. T is any element type but the 64-bit integers.
///
/// The histogram has 256 equal bins over the range; for integers that span fewer than 256 steps, one bin for each
/// integer, so that none stays empty between two others by rounding; one bin where all values are equal; none where
/// no value is finite. formats::histogram_bin says which value is counted where.
template <class T>
formats::FieldSummary summarize(std::span<const T> values, std::string name, std::string unit,
                                const Progress& progress = {});

}  // namespace rhoray::preprocess

#pragma once

#include <span>
#include <string>

#include "formats/base/progress.h"
#include "formats/brick_layout.h"
#include "formats/packed_file.h"

namespace rhoray::preprocess {

/// Writes `array` in the order of the layout, which must not be sparse, a few superbricks at a time
/// on every thread. Reports progress in bytes. Samples are numbers, or texels: arrays of 3 or 4
/// bytes.
/// @param samples  x fastest, volume(layout.sample_count) of them
template <class T>
void write_samples(std::span<const T> samples, const formats::BrickLayout& layout, const std::string& array,
                   formats::PackedFileWriter& writer, ProgressMeter& meter);

}  // namespace rhoray::preprocess

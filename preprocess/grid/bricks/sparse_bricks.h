#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "formats/base/progress.h"
#include "formats/brick_layout.h"
#include "formats/packed_file.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Sets holds_data[b] for each brick b, x fastest, that holds a value that is neither NaN nor
/// infinite. Leaves the others unchanged. T is float or double.
/// @param samples  x fastest, volume(layout.sample_count) of them
template <class T>
void mark_bricks_with_data(std::span<const T> samples, const formats::BrickLayout& layout,
                           std::span<std::uint8_t> holds_data);

/// The marked bricks in their order: the brick of slot 0, 1, ...
Array<std::uint64_t> bricks_of_slots(std::span<const std::uint8_t> holds_data);

/// Array "bricks": the slot of every brick, or formats::BrickGrid::no_brick.
Array<std::uint32_t> slots_of_bricks(std::span<const std::uint64_t> bricks, std::size_t brick_count);

/// Writes `array` of a sparse layout: the bricks slot by slot, NaN beyond the samples. Reports
/// progress in bytes.
/// @param bricks  as returned by bricks_of_slots; layout.stored_brick_count of them
template <class T>
void write_sparse_samples(std::span<const T> samples, const formats::BrickLayout& layout,
                          std::span<const std::uint64_t> bricks, const std::string& array,
                          formats::PackedFileWriter& writer, ProgressMeter& meter);

}  // namespace rhoray::preprocess

#pragma once

#include <filesystem>
#include <string>

#include "formats/field_summary.h"
#include "preprocess/neutral.h"
#include "preprocess/workers/vdb/scalar_grid.h"

namespace rhoray::preprocess {

/// Range over the values of the box, histogram of 256 bins over its active voxels, count of values
/// without data.
formats::FieldSummary summarize(const ScalarGrid& grid);

/// What is known of each grid of a file; values are read of those that are scalars.
void hand_over_facts(const std::filesystem::path& path, int descriptor);

/// A grid as NanoVDB, in single precision.
void hand_over_nanovdb(ScalarGrid grid, int descriptor);

/// All samples of the box; refuses more than `limit_bytes` of them.
NeutralVolume dense_volume(const ScalarGrid& grid, std::uint64_t limit_bytes, const std::filesystem::path& path);

/// Writes a packed grid as .vdb or .nvdb and compares what then lies on disk with it, sample by
/// sample; `output` must not matter when it fails. Returns its size.
std::uint64_t write_vdb(const std::filesystem::path& packed, const std::string& field,
                        const std::filesystem::path& output, bool as_nanovdb);

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <filesystem>

#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// What a foreign volume, mesh or surface holds: read whole, in a process of its own. Refuses a file of a kind that
/// cannot be read (Trouble::unsupported).
/// @param memory_limit_bytes  of the reading process; 0 = none
Json foreign_info(const std::filesystem::path& path, std::uint64_t memory_limit_bytes);

/// Range, count of values without data, and a histogram of 256 bins of values that a file gave.
formats::FieldSummary summarize(std::span<const double> values);

}  // namespace rhoray::tools

#pragma once

#include <cstdint>
#include <filesystem>

#include "preprocess/inspect_mesh.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// What a foreign volume, mesh or surface holds: read whole, in a process of its own. Refuses a file of a kind that
/// cannot be read (ErrorCode::unsupported).
/// @param memory_limit_bytes  of the reading process; 0 = none
/// @param with_findings       also look for what may be wrong with it (preprocess/inspect_mesh.h)
Json foreign_info(const std::filesystem::path& path, std::uint64_t memory_limit_bytes, bool with_findings = false);

/// What may be wrong with a mesh of tetrahedra or a volume, one object for each thing that was looked for.
Json findings_json(const std::vector<preprocess::Finding>& findings);

/// Range, count of values without data, and a histogram of 256 bins of values that a file gave.
formats::FieldSummary summarize(std::span<const double> values);

}  // namespace rhoray::tools

#pragma once

#include <filesystem>

#include "preprocess/inspect_mesh.h"
#include "preprocess/pack.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// The content of a foreign volume, mesh or surface, read completely in a separate process. Refuses
/// a file of unknown type (ErrorCode::unsupported).
/// @param pack           raw, spacing, origin and time, and the memory limit of the reading process
/// @param with_findings  also look for what may be wrong with it (preprocess/inspect_mesh.h)
Json foreign_info(const std::filesystem::path& path, const preprocess::PackOptions& pack, bool with_findings = false);

/// Faults found in a mesh of tetrahedra or a volume, one object for each fault that was looked for.
Json findings_json(const std::vector<preprocess::Finding>& findings);

/// Range, count of values without data, and a histogram of 256 bins of values that a file gave.
formats::FieldSummary summarize(std::span<const double> values);

}  // namespace rhoray::tools

#pragma once

#include <vector>

#include "tools/rhoray/bench/tables.h"

namespace rhoray::tools {

/// The cost of every effect, for a file or a scene document. Each effect that applies is switched
/// on alone over the plain picture of the same layers and camera, and timed just after it, round
/// after round. Then the paper's Tables 4 and 1, with its numbers beside ours. For a file, the
/// options about layers are those of the other tables. A document's layers define what is shown, so
/// these options are refused (ErrorCode::usage).
std::vector<Table> effects_tables(const BenchOptions& options, const Step& step);

}  // namespace rhoray::tools

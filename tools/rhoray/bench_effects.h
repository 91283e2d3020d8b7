#pragma once

#include <vector>

#include "tools/rhoray/bench_tables.h"

namespace rhoray::tools {

/// What every effect costs, for a file or a scene document: each that applies is switched on alone over the plain
/// picture of the same layers and camera, and measured just after it, round after round. Then the paper's Table 4, and
/// its Table 1, its numbers beside ours. Of a file the options about layers are those of the other tables; of a
/// document its layers say what is shown, and they are refused (ErrorCode::usage).
std::vector<Table> effects_tables(const BenchOptions& options, const Step& step);

}  // namespace rhoray::tools

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/analysis/measure.h"
#include "tools/rhoray/bench/options.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

// Shared by the tables.

/// The conditions of a measurement: machine, options and input.
Json bench_context(const BenchOptions& options);

/// seconds[row] of act(row), every row once untimed and then `repeat` times, round after round.
std::vector<std::vector<double>> interleaved(std::size_t row_count, int repeat,
                                             const std::function<double(std::size_t row)>& act);

/// The middle under a name, smallest and largest beside it.
void add_spread(Json& row, const std::string& name, const Spread& spread);

}  // namespace rhoray::tools

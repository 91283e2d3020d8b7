#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// `rhoray-study preprocess-speed`: the cost of reading, packing and resampling.
tools::Subcommand preprocess_speed();

}  // namespace rhoray::study

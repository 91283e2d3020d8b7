#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// `rhoray-study preprocess-speed`: what reading, packing and resampling cost.
tools::Subcommand preprocess_speed();

}  // namespace rhoray::study

#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// What distances chosen by hand miss: those by which rays to a light are moved off the surface, and steps of samples.
tools::Subcommand epsilon();

}  // namespace rhoray::study

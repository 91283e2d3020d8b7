#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Studies the errors of distances chosen by hand: offsets of shadow rays from the surface, and
/// sampling steps.
tools::Subcommand epsilon();

}  // namespace rhoray::study

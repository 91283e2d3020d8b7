#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Studies how an isosurface degrades when the field's samples are stored in fewer bits.
tools::Subcommand bits();

}  // namespace rhoray::study

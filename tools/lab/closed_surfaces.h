#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Many rays at closed isosurfaces: compares float, double and certified answers with the truth.
tools::Subcommand closed_surfaces();

}  // namespace rhoray::study

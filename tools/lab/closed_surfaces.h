#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// Many rays at closed isosurfaces: float, double and certified against the truth.
tools::Subcommand closed_surfaces();

}  // namespace rhoray::study

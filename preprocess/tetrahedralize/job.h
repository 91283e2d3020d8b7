#pragma once

#include <span>
#include <string>
#include <vector>

#include "preprocess/neutral.h"
#include "preprocess/tetrahedralize.h"

namespace rhoray::preprocess {

/// The options that the worker needs, as its command line, and back. Numbers keep every bit.
std::vector<std::string> arguments_of(const TetrahedralizeOptions& options);
TetrahedralizeOptions options_from(std::span<const char* const> arguments);

/// TetGen's switches for this surface. Numbers are written without exponent, which TetGen would not read everywhere.
std::string tetgen_switches(const TetrahedralizeOptions& options, const NeutralSurface& surface);

}  // namespace rhoray::preprocess

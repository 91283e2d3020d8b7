#pragma once

#include <span>

#include "tools/lab/hard_cells.h"

namespace rhoray::tests {

/// Cells of which a root is hard to find in one respect, beside those of tools/lab: cubics that are hardly cubic,
/// roots of more than one, values that hardly differ.
std::span<const study::CellClass> root_cells();

}  // namespace rhoray::tests

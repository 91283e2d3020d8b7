#pragma once

#include <span>

#include "tools/lab/hard_cells.h"

namespace rhoray::tests {

/// Cells in which one property makes a root hard to find, in addition to those of tools/lab: cubics
/// with a tiny cubic term, multiple roots, and values that hardly differ.
std::span<const study::CellClass> root_cells();

}  // namespace rhoray::tests

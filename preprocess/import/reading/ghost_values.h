#pragma once

#include <cstdint>

namespace rhoray::preprocess {

/// Values of VTK's vtkGhostType arrays (vtkDataSetAttributes.h) that are used here.
constexpr std::uint8_t ghost_duplicate = 1, ghost_refined = 8, ghost_hidden_cell = 32, ghost_hidden_point = 2;

}  // namespace rhoray::preprocess

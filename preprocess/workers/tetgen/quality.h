#pragma once

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// How much of a mesh its badly shaped cells are, from 0 to 1.
struct BadShare {
  double of_cells = 0;
  double of_volume = 0;
};

/// The share of the cells whose circumradius is more than `ratio` times their shortest edge, flat
/// cells among them.
BadShare share_above(const NeutralMesh& mesh, double ratio);

}  // namespace rhoray::preprocess

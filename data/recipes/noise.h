#pragma once

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// Gradient noise: smooth, about -1 to 1, 0 at integer coordinates, features about one unit wide.
double noise(const Vec3& p);

/// Sum of octaves of noise, each half as wide and half as strong as the one before.
double layered_noise(const Vec3& p, int layers);

/// Cells of different shapes, about one unit wide.
struct NoiseCell {
  double from_wall = 0;  ///< how much closer the cell's own centre is than the next one
  double number = 0;     ///< pseudo-random number of the cell, 0 to 1
};
NoiseCell noise_cell(const Vec3& p);

}  // namespace rhoray::recipes

#pragma once

#include <cstdint>

#include "preprocess/neutral.h"

/// Meshes of cells of very different sizes and shapes, made from meshes of uniform cells in the
/// unit cube.
namespace rhoray::study {

/// Makes the edges of cubes along each axis a geometric series, so that volumes span the given
/// orders of magnitude.
preprocess::NeutralMesh graded(preprocess::NeutralMesh mesh, double orders);

/// Makes every second layer a thousandth as thick; the layers between keep their thickness.
/// @param edge  cubes along an axis
preprocess::NeutralMesh with_slivers(preprocess::NeutralMesh mesh, std::int64_t edge);

}  // namespace rhoray::study

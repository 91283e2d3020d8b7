#pragma once

#include <cstdint>

#include "preprocess/neutral.h"

/// Meshes of cells of very different sizes and shapes, from meshes of even ones in the unit cube.
namespace rhoray::study {

/// Along each axis cubes' edges become a geometric series, so that volumes go over so many orders of magnitude.
preprocess::NeutralMesh graded(preprocess::NeutralMesh mesh, double orders);

/// Layers that are a thousandth as thick as they were, between layers as they were.
/// @param edge  cubes along an axis
preprocess::NeutralMesh with_slivers(preprocess::NeutralMesh mesh, std::int64_t edge);

}  // namespace rhoray::study

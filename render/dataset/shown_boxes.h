#pragma once

#include <vector>

#include "formats/base/vector.h"
#include "render/dataset/loaded_dataset.h"

namespace rhoray::render {

/// Boxes around parts of an isosurface, or of the triangles of a surface; data frame. They contain
/// all of it (in a mesh: their convex hull does). There are none where nothing crosses the
/// isovalue.
///
/// In a grid there is a box for each row along x, around its crossed cells; a row is one cell wide
/// if that makes no more than 128 x 128 rows, else up to one lowest-level macrocell. In a mesh and
/// a surface there is one for each of 128 x 128 columns along x, around the crossings of edges, or
/// the corners of triangles, in the column.
std::vector<Box3> shown_boxes(const LoadedDataset& dataset, double isovalue, const Watch& watch);

}  // namespace rhoray::render

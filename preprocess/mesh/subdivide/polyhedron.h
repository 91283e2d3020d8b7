#pragma once

#include <cstdint>
#include <span>

#include "preprocess/mesh/subdivide/cut_cell.h"

namespace rhoray::preprocess {

/// Takes a polyhedron apart, given as the stream of its faces (CellMesh): its corners and its boundary, cut into
/// triangles that all wind alike; where a file's faces do not, they are turned. The cell's volume may still be
/// negative.
///
/// Refuses (ErrorCode::invalid, without naming the cell) a stream that does not end with its last face, faces of fewer
/// than three corners, points that are not there, and a boundary that is not closed.
void take_polyhedron(CutCell& cell, std::span<const std::uint64_t> face_stream,
                     std::span<const std::array<double, 3>> points);

}  // namespace rhoray::preprocess

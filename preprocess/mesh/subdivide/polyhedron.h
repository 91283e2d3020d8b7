#pragma once

#include <cstdint>
#include <span>

#include "preprocess/mesh/subdivide/cut_cell.h"

namespace rhoray::preprocess {

/// Reads a polyhedron from the stream of its faces (CellMesh): its corners, and its boundary cut
/// into triangles of consistent winding. Faces of the file with the wrong winding are reversed. The
/// cell's volume may still be negative.
///
/// Refuses with ErrorCode::invalid, without naming the cell: a stream that does not end with its
/// last face, faces of fewer than three corners, points that do not exist, and a boundary that is
/// not closed.
void take_polyhedron(CutCell& cell, std::span<const std::uint64_t> face_stream,
                     std::span<const std::array<double, 3>> points);

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <span>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Merges points of different pieces that have exactly the same position (no tolerance; -0 equals
/// 0), so that cells of neighbouring pieces share points again. Points of the same piece are never
/// merged: a mesh may be cut on purpose. If a piece has several points at one position, only those
/// with equal field values are merged across pieces. The first piece's values are kept. Notes give
/// the number of merged points and the fields that differed there.
///
/// Renumbers the nodes of all cells, which must have been checked. Shortens points and point fields
/// and keeps their order.
/// @param piece_offsets  piece p has the points piece_offsets[p] .. piece_offsets[p+1]-1; the last
///                 entry is the number of points
void merge_coincident_points(CellMesh& mesh, std::span<const std::uint64_t> piece_offsets);

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <span>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Makes one point of those of different pieces that stand at exactly the same place (no tolerance;
/// -0 and 0 are the same), so that cells of neighbouring pieces meet in common points again. Points
/// of one and the same piece are never merged: a mesh may be cut on purpose. Where a piece has
/// several points at one place, only those with equal field values are merged across pieces. The
/// first piece's values are kept; notes count what was merged and say which fields differed there.
///
/// Renumbers the nodes of all cells, which must have been checked, and shortens points and point
/// fields, whose order is kept.
/// @param piece_offsets  piece p has the points piece_offsets[p] .. piece_offsets[p+1]-1; the last
///                 one is the number of points
void merge_coincident_points(CellMesh& mesh, std::span<const std::uint64_t> piece_offsets);

}  // namespace rhoray::preprocess

#pragma once

#include <vector>

#include "preprocess/inspect_surface.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The surface as TetGen may have it: points that coincide exactly are one, and nothing is left on
/// which TetGen would crash or fill the wrong space. Refuses (ErrorCode::invalid, counts and first
/// places of every kind in one line):
///  - a coordinate, size or seed that is not finite, all points in one plane;
///  - facets with fewer than three different corners, triangles without area, facets that are there
///    twice;
///  - when all facets are triangles: pairs that cross (exact);
///  - when, besides, there are neither holes nor regions: edges that do not have exactly two
///    triangles, or an even number of them when solids may touch. With holes or regions, walls
///    inside are legal and TetGen judges.
/// Faces made of several rings are left to TetGen too. Offsets, indices and face numbers are those
/// of a surface that was handed over, and so are in range.
NeutralSurface checked_surface(NeutralSurface surface, bool solids_may_touch);

/// The facets for which it would refuse.
std::vector<FaultyFacet> faulty_facets(NeutralSurface surface, bool solids_may_touch);

}  // namespace rhoray::preprocess

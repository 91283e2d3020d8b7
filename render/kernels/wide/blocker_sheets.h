#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/kernels/wide/blocker_heights.h"

namespace rhoray::render::wide {

/// A flat facet with its corners in order round it; a triangle repeats its last one.
using FacetCorners = std::array<std::array<float, 3>, 4>;

/// Below which heights, square by square, every ray to the light is held back, by facets that have one side turned to
/// it. They make sheets: where an edge has such a facet on either side, seen from the light, light passes neither
/// through nor beside it. So a sheet that has a point in a square, and no rim there, covers all of it, and what lies
/// below its facets lies in shadow. Of several sheets the highest counts.
///
/// @param facets  with the same bits for a corner that several share
/// @param margin  in their frame: squares are taken to be larger by that much on all sides, and facets so thin that it
///                may turn them over to be none
/// @return        of each square, and of what is beyond, the height; -infinity where not known
std::vector<float> heights_below_sheets(const SeenFromLight& seen, const Squares& squares, double margin,
                                        std::span<const FacetCorners> facets);

}  // namespace rhoray::render::wide

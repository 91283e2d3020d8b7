#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct CutFaces {
  std::vector<std::array<std::uint64_t, 3>> triangles;  ///< indices of points
  std::uint64_t not_finite = 0;                         ///< facets left out because a coordinate is not a finite number
};

/// Cuts the facets of a surface into triangles between their own corners, with their winding.
/// Facets of one outline are cut as pack_surface.h says. In a face of several outlines, the part
/// that TetGen would keep is cut: the inside of the outermost outlines without the openings. Lines
/// and points inside become edges and corners. Triangles may be flat. A facet with fewer than three
/// corners makes none. Refuses faces whose outlines cross (ErrorCode::invalid).
CutFaces cut_faces(const NeutralSurface& surface);

}  // namespace rhoray::preprocess

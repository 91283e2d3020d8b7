#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace rhoray::preprocess {

/// A mesh as TetGen gives it: four corners of each cell, the number of the region it lies in, and
/// its neighbours across the four faces (-1 = outside).
struct MeshWithRegions {
  std::span<const double> coordinates;  ///< three for each point
  std::span<const int> corners;         ///< corners_per_cell for each cell, of which four count
  std::size_t corners_per_cell = 4;
  std::span<const double> region;
  std::span<const int> neighbours;
};

/// A part of space that walls close off.
struct EnclosedRegion {
  double number = 0;           ///< TetGen's
  std::size_t depth = 0;       ///< walls between it and the outside, at least 1
  int first_point = 0;         ///< the smallest index of its cells' corners
  std::array<double, 3> seed;  ///< the centre of its largest cell
};

/// The regions from outside in, among equally deep ones by their first point.
std::vector<EnclosedRegion> regions_of(const MeshWithRegions& mesh);

}  // namespace rhoray::preprocess

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace rhoray::preprocess {

/// The neighbour across each face of a tetrahedron; face f is opposite vertex f.
struct FaceNeighbors {
  static constexpr std::uint32_t none = 0xffffffff;

  /// The only cell with volume that has the same face from the other side. None on the mesh's
  /// boundary, where the cells do not agree, and beside a cell of zero volume.
  std::vector<std::array<std::uint32_t, 4>> cells;
  std::vector<bool> is_flat;  ///< cells of zero volume
};

/// The three vertices of face f of a cell, counter-clockwise seen from outside.
constexpr std::array<std::array<std::size_t, 3>, 4> face_vertices{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// @param cells  none of negative orientation
FaceNeighbors match_faces(std::span<const std::array<double, 3>> points,
                          std::span<const std::array<std::uint32_t, 4>> cells);

}  // namespace rhoray::preprocess

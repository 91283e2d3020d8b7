#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/mesh/subdivide/cell_kinds.h"

namespace rhoray::preprocess {

/// Corners of one cell, by their position among them.
using CornerTriangle = std::array<std::uint32_t, 3>;
using CornerTetrahedron = std::array<std::uint32_t, 4>;

/// A cell of flat faces on the way to tetrahedra. Kept between cells for its memory.
struct CutCell {
  // What is cut. A point may be named by several corners (collapsed cells).
  std::vector<std::uint64_t> ids;             ///< of the corners: positions in the mesh
  std::vector<std::array<double, 3>> places;  ///< of the corners
  std::vector<CornerTriangle> boundary;       ///< the faces cut into triangles, counter-clockwise seen from outside

  // What comes out.
  std::vector<CornerTetrahedron> tets;  ///< of VTK's orientation; corner ids.size() is the centre
  std::vector<double> center_weights;   ///< the centre as a mean of the corners; empty when there is none
  std::uint32_t inverted_count = 0;     ///< tetrahedra of the other orientation than the cell
};

/// Cuts a face into triangles, a fan about its corner of the lowest id, and adds them to the boundary: so neighbours of
/// any kind cut a shared face alike. Triangles that name a point twice are left out.
void add_face(CutCell& cell, std::span<const std::uint32_t> corners);

/// Sets the boundary of a cell with this frame, whose `ids` are there.
void add_faces(CutCell& cell, const CellFrame& frame);

struct CutRules {
  bool either_winding = false;  ///< turn the cell when its volume is negative
  bool may_add_center = false;  ///< where tetrahedra without a new point would overlap, cut from a point inside
  std::uint32_t hexahedron_across = none;  ///< the corner across the lowest of a hexahedron: 5 tetrahedra if they do
  static constexpr std::uint32_t none = 0xffffffffU;
};

/// The corner of a hexahedron or voxel that shares no face with the corner of the lowest id; none for other kinds.
std::uint32_t corner_across(const CutCell& cell, CellKind linear_kind);

/// Fills the boundary with tetrahedra. They fan out from the corner of the lowest id (pulling; for hexahedra the cuts
/// of Dompierre et al. 1999, "How to subdivide pyramids, prisms and hexahedra into tetrahedra": 5 or 6), without new
/// points. If some would then be inverted and all are well from a point inside, from there. Tetrahedra that name a
/// point twice are left out. The surface of the tetrahedra is the boundary, in every case.
void fill_cell(CutCell& cell, const CutRules& rules);

}  // namespace rhoray::preprocess

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/mesh/subdivide/cell_kinds.h"

namespace rhoray::preprocess {

/// Corners of one cell, by their index in it.
using CornerTriangle = std::array<std::uint32_t, 3>;
using CornerTetrahedron = std::array<std::uint32_t, 4>;

/// A cell with flat faces that is being cut into tetrahedra. Reused between cells for its memory.
struct CutCell {
  // Input. Several corners may name the same point (collapsed cells).
  std::vector<std::uint64_t> ids;             ///< of the corners: indices in the mesh
  std::vector<std::array<double, 3>> places;  ///< of the corners
  /// the faces cut into triangles, counter-clockwise seen from outside
  std::vector<CornerTriangle> boundary;

  // Output.
  std::vector<CornerTetrahedron> tets;  ///< in VTK's orientation; corner ids.size() is the centre
  /// the centre as a mean of the corners; empty when there is none
  std::vector<double> center_weights;
  std::uint32_t inverted_count = 0;  ///< tetrahedra oriented opposite to the cell
};

/// Cuts a face into a fan of triangles around its corner of the lowest id, and adds them to the
/// boundary. Neighbours of any kind therefore cut a shared face in the same way. Triangles that
/// name a point twice are left out.
void add_face(CutCell& cell, std::span<const std::uint32_t> corners);

/// Sets the boundary of a cell with this frame, whose `ids` are already set.
void add_faces(CutCell& cell, const CellFrame& frame);

struct CutRules {
  bool either_winding = false;  ///< invert the cell when its volume is negative
  /// where tetrahedra without a new point would overlap, cut from a point inside
  bool may_add_center = false;
  /// corner opposite a hexahedron's lowest one: cut into 5 tetrahedra where they suffice
  std::uint32_t hexahedron_across = none;
  static constexpr std::uint32_t none = 0xffffffffU;
};

/// Returns the corner of a hexahedron or voxel that shares no face with the corner of the lowest
/// id; none for other kinds.
std::uint32_t corner_across(const CutCell& cell, CellKind linear_kind);

/// Fills the boundary with tetrahedra. They fan out from the corner of the lowest id without new
/// points (pulling). For hexahedra these are the 5 or 6 tetrahedra of Dompierre et al. 1999, "How
/// to subdivide pyramids, prisms and hexahedra into tetrahedra". If some would be inverted, and
/// none is when cut from a point inside, they fan out from that point. Tetrahedra that name a point
/// twice are left out. The surface of the tetrahedra is the boundary in every case.
void fill_cell(CutCell& cell, const CutRules& rules);

}  // namespace rhoray::preprocess

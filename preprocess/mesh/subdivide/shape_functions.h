#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A position in a cell's local coordinates. Tetrahedra, hexahedra and wedges use VTK's (r, s, t).
/// A pyramid has its corners at (0,0,0), (1,0,0), (1,1,0), (0,1,0) and (0,0,1): VTK's (r, s, t) is
/// (r (1-t), s (1-t), t) here. Straight lines in its triangular faces are therefore straight lines
/// in those of a neighbour.
using CellPlace = std::array<double, 3>;

/// Shape functions of a higher-order cell: the weights of its nodes at a position inside. Each
/// function is 1 at its own node and 0 at all others; they sum to 1.
///
/// They are those of VTK 9.1 (with Lagrange cells of one order along all axes), except for
/// pyramids: VTK's pyramids do not agree with the faces of neighbouring tetrahedra. Here a pyramid
/// has the rational functions of Bergot, Cohen, Durufle 2010 ("Higher-order finite elements for
/// hybrid meshes using new nodal pyramidal elements"), which do. For 13 nodes they are Bedrosian's
/// (1992), for 19 with a bubble on each triangular face and one inside.
class ShapeFunctions {
 public:
  /// True when the kind with this number of nodes is linear after all: its nodes are its corners.
  static bool is_linear(CellKind kind, std::size_t node_count);

  /// Refuses a node count that the kind cannot have (ErrorCode::invalid or unsupported, without
  /// naming the cell).
  ShapeFunctions(CellKind kind, std::size_t node_count);

  std::size_t node_count() const { return node_places_.size(); }
  std::span<const CellPlace> node_places() const { return node_places_; }

  /// True for polynomials of second degree in a tetrahedron: their distance from a straight edge is
  /// at most 1.5 times the largest distance at the middle of an edge.
  bool is_quadratic_in_tetrahedra() const { return is_quadratic_in_tetrahedra_; }

  /// Along a straight line, the functions are polynomials of at most this degree (for a pyramid:
  /// approximately).
  int degree_along_lines() const { return degree_along_lines_; }

  /// @param weights  one for each node; weights below 1e-13 are exactly 0
  void at(const CellPlace& place, std::span<double> weights) const;

 private:
  /// Products of Silvester's polynomials, one factor for each coordinate: node (i, j, ...) has
  /// S_i(c_0) S_j(c_1) ...
  struct Lattice {
    int order = 0;
    std::size_t coordinate_count = 0;
    std::vector<std::array<std::uint8_t, 6>> nodes;  ///< i, j, ... of each node
  };

  void build_lattice(CellKind corners, int order);
  void build_from_basis();
  void basis_at(const CellPlace& place, std::span<double> values) const;

  CellKind corners_;
  std::size_t count_;
  std::vector<CellPlace> node_places_;
  std::vector<double> weights_from_basis_;  ///< row-major; empty when there is a lattice
  Lattice lattice_;
  bool is_quadratic_in_tetrahedra_ = false;
  int degree_along_lines_ = 2;
};

}  // namespace rhoray::preprocess

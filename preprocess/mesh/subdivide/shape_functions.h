#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A place in a cell's own coordinates. Tetrahedra, hexahedra and wedges have VTK's (r, s, t). A pyramid has its
/// corners at (0,0,0), (1,0,0), (1,1,0), (0,1,0) and (0,0,1): VTK's (r, s, t) is (r (1-t), s (1-t), t) here, so that
/// straight lines in its triangular faces are straight lines in those of a neighbour.
using CellPlace = std::array<double, 3>;

/// What the nodes of a higher-order cell count for at a place inside: functions that are 1 at their own node, 0 at all
/// others, and sum to 1.
///
/// Those of VTK 9.1 (with Lagrange cells of one order along all axes), but for pyramids: VTK's do not agree with the
/// faces of neighbouring tetrahedra. Here a pyramid has the rational functions of Bergot, Cohen, Durufle 2010
/// ("Higher-order finite elements for hybrid meshes using new nodal pyramidal elements"), which do; for 13 nodes they
/// are Bedrosian's (1992), for 19 with a bubble on each triangular face and one inside.
class ShapeFunctions {
 public:
  /// Whether the kind with so many nodes is not linear after all: its nodes are its corners.
  static bool is_linear(CellKind kind, std::size_t node_count);

  /// Refuses (ErrorCode::invalid or unsupported, without naming the cell) a node count that the kind cannot have.
  ShapeFunctions(CellKind kind, std::size_t node_count);

  std::size_t node_count() const { return node_places_.size(); }
  std::span<const CellPlace> node_places() const { return node_places_; }

  /// Polynomials of second degree in a tetrahedron: between straight lines and them lie at most 1.5 times the largest
  /// distance at the middle of an edge.
  bool is_quadratic_in_tetrahedra() const { return is_quadratic_in_tetrahedra_; }

  /// Along a straight line the functions are polynomials of at most this degree (of a pyramid: about).
  int degree_along_lines() const { return degree_along_lines_; }

  /// @param weights  one for each node; those below 1e-13 are exactly 0
  void at(const CellPlace& place, std::span<double> weights) const;

 private:
  /// A product of Silvester's polynomials, one for each coordinate: node (i, j, ...) has S_i(c_0) S_j(c_1) ...
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

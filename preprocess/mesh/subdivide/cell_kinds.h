#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A face by the corners of its cell, counter-clockwise seen from outside.
struct CellFace {
  std::uint8_t corner_count;
  std::array<std::uint8_t, 6> corners;
};

/// Corners and faces of a cell with flat faces and straight edges, in VTK's corner order.
struct CellFrame {
  std::size_t corner_count;
  std::span<const CellFace> faces;
  /// Files use both windings for this kind (VTK's text and VTK's code differ about the wedge). A
  /// cell is then turned so that its volume is positive. For other kinds, a cell of negative volume
  /// stays as it is.
  bool either_winding;
};

struct KindOfCell {
  CellKind kind;
  std::string_view singular, plural;
  /// the linear kind with the same corners, which come first among the nodes
  CellKind corners;
  std::size_t node_count;  ///< 0: the kind exists in several orders
};

/// For every kind but the polyhedron.
const CellFrame& frame_of(CellKind linear_kind);

const KindOfCell& description_of(CellKind kind);

/// 4800 -> "4,800".
std::string with_commas(std::uint64_t number);

/// "1 hexahedron", "4,800 hexahedra".
std::string counted(std::uint64_t count, CellKind kind);

}  // namespace rhoray::preprocess

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

/// What a cell of flat faces and straight edges looks like, with its corners in VTK's order.
struct CellFrame {
  std::size_t corner_count;
  std::span<const CellFace> faces;
  /// Both windings are met in files (VTK's text and VTK's code differ about the wedge): a cell is then turned so that
  /// its volume is positive. Otherwise a cell of negative volume stays one.
  bool either_winding;
};

struct KindOfCell {
  CellKind kind;
  std::string_view singular, plural;
  CellKind corners;        ///< the linear kind that has the same corners, which come first among the nodes
  std::size_t node_count;  ///< 0: of several orders
};

/// Of every kind but the polyhedron.
const CellFrame& frame_of(CellKind linear_kind);

const KindOfCell& description_of(CellKind kind);

/// 4800 -> "4,800".
std::string with_commas(std::uint64_t number);

/// "1 hexahedron", "4,800 hexahedra".
std::string counted(std::uint64_t count, CellKind kind);

}  // namespace rhoray::preprocess

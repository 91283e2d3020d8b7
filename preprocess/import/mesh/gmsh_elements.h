#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// One of Gmsh's numbered element types.
struct GmshElement {
  std::uint64_t node_count = 0;
  std::uint8_t kind = 0;    ///< VTK's number: a CellKind, or that of a vertex, line or face
  bool is_readable = true;  ///< false for volume elements without a CellKind
  /// Gmsh's index of VTK's node i; empty: both orders are the same
  std::vector<std::uint16_t> order;
};

/// The element type with this number in MSH files; nothing if there is none with a fixed node
/// count.
/// Source: Gmsh Reference Manual, "MSH file format" and "Node ordering". Nodes inside edges, faces
/// and volumes follow the recursion described there.
std::optional<GmshElement> gmsh_element(std::uint64_t number);

}  // namespace rhoray::preprocess

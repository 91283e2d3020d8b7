#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "preprocess/mesh/subdivide/fine_place.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

inline constexpr std::uint32_t no_point = std::numeric_limits<std::uint32_t>::max();

/// An edge of a tetrahedron in a curved cell.
struct Edge {
  std::array<std::uint32_t, 2> ends;  ///< points, the lower one first
  /// in the cell that added the edge first, which represents it
  std::array<FinePlace, 2> end_places;
  std::uint32_t curved_cell;
  std::uint32_t middle = no_point;  ///< the point at which it is cut; no_point: not cut
  double length2;
};

/// A hash table of edges by their ends.
class EdgeTable {
 public:
  EdgeTable() : slots_(1024, empty) {}

  /// Adds the edge when it is new. Refuses more than 2^30 edges (ErrorCode::resource).
  std::uint32_t find_or_add(const Edge& edge);

  Array<Edge> edges;

 private:
  static constexpr std::uint32_t empty = std::numeric_limits<std::uint32_t>::max();

  std::size_t slot_of(const std::array<std::uint32_t, 2>& ends) const;
  void grow();

  Array<std::uint32_t> slots_;
};

}  // namespace rhoray::preprocess

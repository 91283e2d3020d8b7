#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "preprocess/mesh/subdivide/curved_cell.h"
#include "preprocess/mesh/subdivide/fine_place.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The points that each curved cell names at several corners, as collapsed cells do: such a point lies on the line
/// between two corners, or in the box about more. Most cells have none.
class SpreadPoints {
 public:
  SpreadPoints(const CellMesh& mesh, std::span<const CurvedCell> cells);

  /// Moves both ends of an edge to where they are nearest to each other.
  void settle(std::uint32_t curved_cell, std::uint32_t a, FinePlace& at_a, std::uint32_t b, FinePlace& at_b) const;

  /// Between two such points of a cell all points are such points.
  void add_middle(std::uint32_t curved_cell, std::uint32_t a, std::uint32_t b, std::uint32_t point);

  /// Moves a place of `point` to where it is nearest to another.
  void move(std::uint32_t curved_cell, std::uint32_t point, FinePlace& place, const FinePlace& other) const;

 private:
  struct SpreadPoint {
    std::uint32_t point;
    std::vector<CellPlace> corners;

    /// The one nearest to another place, from which a straight line to there runs through the cell as it should.
    CellPlace nearest_to(const CellPlace& other) const;
  };

  const SpreadPoint* find(std::uint32_t curved_cell, std::uint32_t point) const;

  std::unordered_map<std::uint32_t, std::vector<SpreadPoint>> of_cells_;
};

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "preprocess/mesh/subdivide/curved_cell.h"
#include "preprocess/mesh/subdivide/fine_place.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Points that a curved cell names at several corners, as collapsed cells do. Such a point has many
/// local positions: it covers the line between two corners, or the box around more. Most cells have
/// no such points.
class SpreadPoints {
 public:
  SpreadPoints(const CellMesh& mesh, std::span<const CurvedCell> cells);

  /// Moves both ends of an edge to the local positions where they are nearest to each other.
  void settle(std::uint32_t curved_cell, std::uint32_t a, FinePlace& at_a, std::uint32_t b, FinePlace& at_b) const;

  /// Records a new point between two such points of a cell; all points between them are such points
  /// too.
  void add_middle(std::uint32_t curved_cell, std::uint32_t a, std::uint32_t b, std::uint32_t point);

  /// Moves the local position of `point` to where it is nearest to another.
  void move(std::uint32_t curved_cell, std::uint32_t point, FinePlace& place, const FinePlace& other) const;

 private:
  struct SpreadPoint {
    std::uint32_t point;
    std::vector<CellPlace> corners;

    /// The position nearest to another one; a straight line between the two runs through the cell
    /// correctly.
    CellPlace nearest_to(const CellPlace& other) const;
  };

  const SpreadPoint* find(std::uint32_t curved_cell, std::uint32_t point) const;

  std::unordered_map<std::uint32_t, std::vector<SpreadPoint>> of_cells_;
};

}  // namespace rhoray::preprocess

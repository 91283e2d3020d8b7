#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/grid/resample/faces.h"
#include "preprocess/grid/resample/field_view.h"

namespace rhoray::preprocess {

/// A face of the mesh, in steps from a brick's first sample.
struct BrickFace {
  std::array<Point, 3> corners;
  std::array<std::uint32_t, 3> vertices;
  std::uint32_t cell;
  Point normal;         ///< its length is twice the face's area
  double normal_error;  ///< of each component, from rounding
  /// distance of a leaf cell's corners from its centre along the normal
  double normal_reach;
  /// one divided by the normal's square; infinite where the face has no area
  double inverse_area;
  std::array<Point, 3> sides;  ///< directions in the face's plane, normal to an edge, inward
  std::array<double, 3> side_reaches;

  BrickFace(const std::array<Point, 3>& corners_in_brick, const std::array<std::uint32_t, 3>& vertices_of_mesh,
            std::uint32_t cell_of_mesh);

  /// False when the leaf cell centred at `center` does not touch the face.
  bool may_touch(const Point& center) const {
    if (std::abs(dot(normal, minus(center, corners[0]))) > normal_reach) return false;
    for (std::size_t e = 0; e < 3; ++e)
      if (dot(sides[e], minus(center, corners[e])) < -side_reaches[e]) return false;
    return true;
  }
};

/// Faces of the cells in a brick, each computed on first use.
class BrickFaces {
 public:
  /// @param steps  the mesh's points, in steps of the lattice
  BrickFaces(const CleanMesh& mesh, const std::vector<Point>& steps) : mesh_(mesh), steps_(steps) {}

  /// @param cells  those of the brick; must stay valid until the next brick
  void enter(const Point& first, std::span<const std::uint32_t> cells);

  /// @param n     index among the brick's cells
  /// @param side  the opposite vertex
  const BrickFace& at(std::size_t n, std::size_t side) {
    std::uint32_t& number = numbers_[4 * n + side];
    if (number == not_made) number = make(cells_[n], side);
    return faces_[number];
  }

 private:
  static constexpr std::uint32_t not_made = 0xffffffff;

  std::uint32_t make(std::uint32_t cell, std::size_t side);

  const CleanMesh& mesh_;
  const std::vector<Point>& steps_;
  Point first_{};
  std::span<const std::uint32_t> cells_;
  std::vector<std::uint32_t> numbers_;
  std::vector<BrickFace> faces_;
};

/// A leaf cell's trilinear function, split at the cell's centre into a linear function and the
/// rest.
class CellPlane {
 public:
  /// @param corners  the function there, x fastest
  explicit CellPlane(const std::array<double, 8>& corners);

  /// Upper bound of the difference on a face. In its plane, the linear function has an error in
  /// value and slope. The rest, being trilinear, is largest at a corner of the cell. Infinite or
  /// NaN where the face's cell has no gradient.
  /// @param low  the leaf cell's first sample
  double bound_on(const BrickFace& face, const FieldView& field, const Point& low) const;

 private:
  double value_ = 0, rest_ = 0;
  Point slope_{};
};

}  // namespace rhoray::preprocess

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/vector.h"
#include "formats/tet_mesh.h"

namespace rhoray::tools::validate {

/// A packed mesh with one of its fields: the stored values as doubles, in the mesh's own frame.
class TetField {
 public:
  /// @param field  name; empty: the first. An unknown name is refused (ErrorCode::usage).
  TetField(const formats::TetMesh& mesh, const std::string& field);

  Box3 box() const;  ///< of all cells
  std::size_t cell_count() const { return mesh_.description().cell_count; }

  struct Cell {
    std::array<std::uint32_t, 4> vertex;
    std::array<std::array<double, 3>, 4> point;
    std::array<double, 4> value;

    Box3 box() const;
    double longest_edge() const;
    /// Barycentric; below 0 outside; NaN for a cell without volume.
    double smallest_coordinate(const Vec3& p) const;
    Vec3 gradient() const;  ///< of the linear field; not finite for a cell without volume
  };
  Cell cell(std::size_t c) const;

  /// True for a cell with data and points on both sides: value < isovalue, and value >= isovalue.
  static bool straddles(const Cell& cell, double isovalue);

  /// The cells with this id (TetMesh::cell_id): several where an imported cell became several
  /// tetrahedra.
  std::span<const std::uint32_t> cells_of_id(std::uint64_t id) const;

 private:
  formats::TetMesh mesh_;
  std::vector<double> values_;
  std::vector<std::uint32_t> by_id_;  ///< cells in the order of their ids
};

}  // namespace rhoray::tools::validate

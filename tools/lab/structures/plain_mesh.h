#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/checks.h"
#include "formats/base/interval.h"
#include "formats/base/rising.h"
#include "formats/tet_mesh.h"

namespace rhoray::study {

/// A mesh as plain arrays, with four point indices for each cell, in the form that the scalar
/// search expects (render/mesh_search.h). Points and values remain those of the packed mesh, which
/// must outlive it.
class PlainMesh {
 public:
  /// Takes the mesh's first field; its values are floats.
  explicit PlainMesh(const formats::TetMesh& packed);

  /// The same cells in another order. Points keep their numbers, so each cell gives the same bits.
  /// @param order  order[n] is the index here of the cell at position n in the result; each index
  ///   once
  PlainMesh reordered(std::span<const std::uint32_t> order) const;

  std::uint32_t cell_count() const { return static_cast<std::uint32_t>(cells_.size()); }
  std::span<const std::array<double, 3>> points() const { return points_; }
  std::span<const float> values() const { return values_; }
  std::uint64_t cell_id(std::uint32_t cell) const { return ids_[cell]; }

  /// Point indices of a cell, as stored.
  RHORAY_INLINE const std::array<std::uint32_t, 4>& vertices(std::uint32_t cell) const { return cells_[cell]; }
  /// Point indices of a cell, ascending.
  RHORAY_INLINE std::array<std::uint32_t, 4> sorted_vertices(std::uint32_t cell) const { return rising(cells_[cell]); }
  RHORAY_INLINE std::array<double, 4> values_at(const std::array<std::uint32_t, 4>& v) const {
    return {values_[v[0]], values_[v[1]], values_[v[2]], values_[v[3]]};
  }
  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const std::array<std::uint32_t, 4>& v) const {
    return {points_[v[0]], points_[v[1]], points_[v[2]], points_[v[3]]};
  }

  /// Range of the values at its vertices; empty (lo > hi) where one of them is not a finite number.
  Interval<float> range(std::uint32_t cell) const;
  Box3 box(std::uint32_t cell) const;
  Vec3 center(std::uint32_t cell) const;  ///< centre of gravity: cells of one box have different
                                          ///< ones
  Box3 bounds() const;                    ///< of all cells

  static constexpr double cell_bytes = sizeof(std::array<std::uint32_t, 4>);

 private:
  std::span<const std::array<double, 3>> points_;
  std::span<const float> values_;
  std::vector<std::array<std::uint32_t, 4>> cells_;
  std::vector<std::uint32_t> ids_;
};

}  // namespace rhoray::study

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "formats/base/rising.h"
#include "formats/tet_mesh.h"
#include "render/cell/tet_crossing.h"
#include "render/traverse/lattice_walk.h"

namespace rhoray::render {

/// A packed mesh with one of its fields as a volume for rays, in its own frame: points relative to
/// the mesh's origin.
///
/// Leaf lists or clusters (formats/cell_clusters.h) tell which cells a ray may hit.
template <class T>
class TetData {
 public:
  TetData(const formats::TetMesh& mesh, std::size_t field) : mesh_(mesh), values_(mesh.values<T>(field)) {
    if (mesh.has_clusters())
      cluster_ranges_ = mesh.cluster_ranges<T>(field);
    else
      levels_ = mesh.macro_levels<T>(field);
  }

  const formats::TetMeshDescription& description() const { return mesh_.description(); }
  const formats::TetMesh& mesh() const { return mesh_; }

  /// Leaf cells around the mesh, about the size of a tetrahedron, even where no lists name their
  /// contents.
  WalkLattice lattice() const {
    const formats::MacroShape& shape = description().lattice.macro;
    return {shape.leaf_count, shape.factor};
  }
  /// Returns the same ray with positions in leaf cells, and the same t.
  RHORAY_INLINE Ray on_lattice(const Ray& ray) const {
    const formats::LeafLattice& lattice = mesh_.description().lattice;
    return {(ray.origin - lattice.low) / lattice.leaf_size, ray.direction / lattice.leaf_size, ray.t_min, ray.t_max};
  }

  std::span<const std::array<double, 3>> points() const { return mesh_.points(); }
  std::span<const T> values() const { return values_; }

  bool has_clusters() const { return mesh_.has_clusters(); }

  // Only with clusters.
  const formats::CellClustersView& clusters() const { return mesh_.clusters(); }
  const formats::ClusterRangesView<T>& cluster_ranges() const { return cluster_ranges_; }

  // Only with leaf lists.
  int level_count() const { return levels_.shape.level_count; }
  /// Returns the range of the values in the tetrahedra of a leaf cell (level 0) or macrocell.
  RHORAY_INLINE Interval<double> range(int level, const Index3& cell) const {
    const Interval<T> stored = levels_.range(level, cell.x, cell.y, cell.z);
    return {static_cast<double>(stored.lo), static_cast<double>(stored.hi)};
  }
  RHORAY_INLINE std::span<const std::uint32_t> tetrahedra_at(const Index3& leaf) const {
    const Index3& count = levels_.shape.leaf_count;
    return mesh_.leaf_lists().list(static_cast<std::uint64_t>((leaf.z * count.y + leaf.y) * count.x + leaf.x));
  }

  /// Returns the point indices of a cell.
  RHORAY_INLINE std::array<std::uint32_t, 4> vertices(std::uint32_t cell) const { return mesh_.cell(cell); }

  /// Returns the point indices of a cell, in increasing order.
  RHORAY_INLINE std::array<std::uint32_t, 4> sorted_vertices(std::uint32_t cell) const {
    return rising(vertices(cell));
  }

  RHORAY_INLINE double value_at(std::uint32_t point) const { return static_cast<double>(values_[point]); }
  RHORAY_INLINE std::array<double, 4> values_at(const std::array<std::uint32_t, 4>& v) const {
    return {static_cast<double>(values_[v[0]]), static_cast<double>(values_[v[1]]), static_cast<double>(values_[v[2]]),
            static_cast<double>(values_[v[3]])};
  }

  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const std::array<std::uint32_t, 4>& v) const {
    const auto points = mesh_.points();
    return {points[v[0]], points[v[1]], points[v[2]], points[v[3]]};
  }

  RHORAY_INLINE std::uint64_t cell_id(std::uint32_t cell) const { return mesh_.cell_id(cell); }

 private:
  formats::TetMesh mesh_;
  std::span<const T> values_;
  formats::MacroLevelsView<T> levels_;
  formats::ClusterRangesView<T> cluster_ranges_;
};

/// False when a value is NaN or infinite: the tetrahedron then counts as absent.
RHORAY_INLINE bool has_data(const std::array<double, 4>& values) {
  return std::isfinite(values[0]) && std::isfinite(values[1]) && std::isfinite(values[2]) && std::isfinite(values[3]);
}

}  // namespace rhoray::render

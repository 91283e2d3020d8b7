#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "formats/base/rising.h"
#include "formats/macro_ranges.h"
#include "formats/tet_mesh.h"
#include "render/cell/tet_crossing.h"
#include "render/traverse/lattice_walk.h"

namespace rhoray::render {

/// A packed mesh with one of its fields as a volume for rays, in its own frame: points relative to
/// the mesh's origin.
///
/// Leaf lists or clusters (formats/cell_clusters.h) tell which cells a ray may hit. Whether values
/// are stored as floats or doubles is seen by none but kernels that read them directly.
class TetData {
 public:
  TetData(const formats::TetMesh& mesh, std::size_t field)
      : mesh_(mesh), is_float_(mesh.description().fields[field].type == formats::ElementType::F32) {
    if (is_float_)
      read<float>(field);
    else
      read<double>(field);
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

  bool has_clusters() const { return mesh_.has_clusters(); }

  // The stored values, and the ranges of a level of clusters, as floats or doubles.
  bool is_float() const { return is_float_; }
  const void* stored_values() const { return values_; }
  const void* stored_cluster_ranges(int level) const { return cluster_ranges_[static_cast<std::size_t>(level)]; }

  // Only with clusters.
  const formats::CellClustersView& clusters() const { return mesh_.clusters(); }
  /// Calls act(the ranges of values of a block of clusters) where they are stored, as floats or
  /// doubles, and returns its result.
  template <class Act>
  RHORAY_INLINE auto with_cluster_ranges(int level, std::uint64_t block, Act&& act) const {
    const void* ranges = stored_cluster_ranges(level);
    return is_float_ ? act(static_cast<const formats::RangeBlock<float>*>(ranges)[block])
                     : act(static_cast<const formats::RangeBlock<double>*>(ranges)[block]);
  }

  // Only with leaf lists.
  int level_count() const { return levels_.shape().level_count; }
  /// Returns the range of the values in the tetrahedra of a leaf cell (level 0) or macrocell.
  Interval<double> range(int level, const Index3& cell) const { return levels_.range(level, cell); }
  RHORAY_INLINE std::span<const std::uint32_t> tetrahedra_at(const Index3& leaf) const {
    const Index3& count = levels_.shape().leaf_count;
    return mesh_.leaf_lists().list(static_cast<std::uint64_t>((leaf.z * count.y + leaf.y) * count.x + leaf.x));
  }

  /// Returns the point indices of a cell.
  RHORAY_INLINE std::array<std::uint32_t, 4> vertices(std::uint32_t cell) const { return mesh_.cell(cell); }

  /// Returns the point indices of a cell, in increasing order.
  RHORAY_INLINE std::array<std::uint32_t, 4> sorted_vertices(std::uint32_t cell) const {
    return rising(vertices(cell));
  }

  RHORAY_INLINE double value_at(std::uint32_t point) const {
    return is_float_ ? static_cast<double>(static_cast<const float*>(values_)[point])
                     : static_cast<const double*>(values_)[point];
  }
  RHORAY_INLINE std::array<double, 4> values_at(const std::array<std::uint32_t, 4>& v) const {
    return is_float_ ? values_in(static_cast<const float*>(values_), v)
                     : values_in(static_cast<const double*>(values_), v);
  }

  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const std::array<std::uint32_t, 4>& v) const {
    const auto points = mesh_.points();
    return {points[v[0]], points[v[1]], points[v[2]], points[v[3]]};
  }

  RHORAY_INLINE std::uint64_t cell_id(std::uint32_t cell) const { return mesh_.cell_id(cell); }

 private:
  template <class T>
  RHORAY_INLINE static std::array<double, 4> values_in(const T* values, const std::array<std::uint32_t, 4>& v) {
    return {static_cast<double>(values[v[0]]), static_cast<double>(values[v[1]]), static_cast<double>(values[v[2]]),
            static_cast<double>(values[v[3]])};
  }

  template <class T>
  void read(std::size_t field) {
    values_ = mesh_.values<T>(field).data();
    if (mesh_.has_clusters())
      for (const auto& level : mesh_.cluster_ranges<T>(field)) cluster_ranges_.push_back(level.data());
    else
      levels_ = mesh_.macro_levels<T>(field);
  }

  formats::TetMesh mesh_;
  bool is_float_;
  const void* values_;
  formats::MacroRanges levels_;
  std::vector<const void*> cluster_ranges_;  ///< [level]: an array of RangeBlock
};

/// False when a value is NaN or infinite: the tetrahedron then counts as absent.
RHORAY_INLINE bool has_data(const std::array<double, 4>& values) {
  return std::isfinite(values[0]) && std::isfinite(values[1]) && std::isfinite(values[2]) && std::isfinite(values[3]);
}

}  // namespace rhoray::render

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/progress.h"
#include "formats/base/text.h"
#include "formats/brick_grid.h"
#include "formats/cell_clusters.h"
#include "formats/field_summary.h"
#include "formats/leaf_lists.h"
#include "formats/packed_file.h"

namespace rhoray::formats {

/// Description of the clusters (cell_clusters.h).
struct ClusterDescription {
  std::uint64_t cluster_size = 64;  ///< as in ClusterShape
  std::uint64_t vertex_count = 0;   ///< of all tables together
  double box_unit = 1;              ///< a power of two
};

/// A tetrahedral mesh with fields at its points, linear inside each cell, and fields with one value
/// in each cell.
///
///        3          vertex order of every packed cell: (p1-p0) x (p2-p0) . (p3-p0) >= 0,
///       /|\         seen from vertex 3 the face 0, 1, 2 runs counter-clockwise (as in VTK);
///      / | \        a cell of zero volume may have any order
///     0-----2
///      \ | /
///        1
///
/// A structure over the cells gives the cells that a ray may meet: leaf lists, or clusters.
struct TetMeshDescription {
  Vec3 origin;  ///< origin of the mesh frame in the world: world = origin + point
  std::string length_unit;
  std::uint64_t point_count = 0;
  std::uint64_t cell_count = 0;
  std::vector<FieldSummary> fields;       ///< at least one, with distinct names
  std::vector<FieldSummary> cell_fields;  ///< one value per cell; with distinct names
  /// Lattice around the mesh. Without leaf lists it is still the unit for steps along a ray (leaf
  /// cells).
  LeafLattice lattice;
  std::uint64_t leaf_item_count = 0;           ///< only with leaf lists
  std::uint64_t boundary_face_count = 0;       ///< 0: the boundary is not stored
  std::optional<ClusterDescription> clusters;  ///< null: leaf lists

  /// True: cells and points keep the source's order. False: neighbouring cells are stored close
  /// together, and points in the order in which cells first use them. Arrays "cell_ids" and
  /// "point_ranks" give the source order.
  bool in_source_order = true;

  // Counts of what packing found. Array "cell_ids" is also present when cells of the source were
  // left out.
  std::uint64_t flipped_cell_count = 0;  ///< had negative orientation; two vertices exchanged
  /// zero volume; kept, because they carry the surface from face to face
  std::uint64_t flat_cell_count = 0;
  std::uint64_t dropped_cell_count = 0;  ///< with a repeated vertex or a non-finite coordinate
  std::uint64_t unused_point_count = 0;  ///< in no cell; dropped
  Provenance provenance;
};

/// A packed mesh, checked and ready for reading. Arrays:
///   - "points" F64 [points, 3] relative to origin
///   - optional "cell_ids" U32 [cells] and "point_ranks" U32 [points]
///   - with leaf lists "cells" U32 [cells, 4], "leaf.offsets" U64 [leaves + 1],
///     "leaf.items" U32 [items]
///   - with clusters "cluster.corners" U8 [cells, 4], "cluster.offsets" U64 [clusters + 1],
///     "cluster.vertices" U32 [vertices], "cluster.boxes.0", ... (clusters, entries above)
///   - optional "boundary" U64 [faces]: the faces of one cell only (mesh_boundary.h)
///   - for each field f (by index) "field.<f>" F32 or F64 [points] and "range.<f>.0",
///     "range.<f>.1", ... (leaf cells, macrocells; or clusters, entries above)
///   - for each cell field f "cell_field.<f>" F32 or F64 [cells]
class TetMesh {
 public:
  /// Refuses a file of another kind, shapes that differ from the description, and points that are
  /// not finite. Refuses vertex indices not below point_count, items not below cell_count, and
  /// decreasing offsets. Refuses a face of a cell beyond the last one. Refuses a corner beyond its
  /// cluster's table, and entries of the cluster tree beyond its last one. Reads all indices and
  /// points once.
  explicit TetMesh(PackedFile file, const Watch& watch = {});

  const TetMeshDescription& description() const { return description_; }
  const PackedFile& file() const { return file_; }

  std::span<const std::array<double, 3>> points() const { return points_; }
  /// Point indices of a cell.
  std::array<std::uint32_t, 4> cell(std::uint64_t position) const {
    return cells_.empty() ? clusters_.cell(position) : cells_[position];
  }

  bool has_clusters() const { return description_.clusters.has_value(); }
  LeafListsView leaf_lists() const { return leaf_lists_; }        ///< only without clusters
  const CellClustersView& clusters() const { return clusters_; }  ///< only with clusters

  /// Index in the source file of the cell that this cell is, or was cut from.
  std::uint64_t cell_id(std::uint64_t cell) const { return cell_ids_.empty() ? cell : cell_ids_[cell]; }

  /// Number of these points that precede it in the source; below the number of points. Correct only
  /// if no two points share a rank, which opening does not check.
  std::uint64_t point_rank(std::uint64_t point) const { return point_ranks_.empty() ? point : point_ranks_[point]; }

  /// Numbers of the faces that belong to one cell only, ascending; empty where they are not stored.
  std::span<const std::uint64_t> boundary() const { return boundary_; }

  /// Index of the field with this name, or nothing.
  std::optional<std::size_t> find_field(std::string_view name) const;

  /// T must be the field's type, float or double.
  template <class T>
  std::span<const T> values(std::size_t field) const {
    return file_.array<T>(concat("field.", field), {description_.point_count});
  }
  std::optional<std::size_t> find_cell_field(std::string_view name) const;
  /// As `values`, of a cell field.
  template <class T>
  std::span<const T> cell_values(std::size_t field) const {
    return file_.array<T>(concat("cell_field.", field), {description_.cell_count});
  }
  /// Only with leaf lists.
  template <class T>
  MacroLevelsView<T> macro_levels(std::size_t field) const {
    return view_macro_levels<T>(file_, description_.lattice.macro, 0, concat("range.", field, "."));
  }
  /// Only with clusters.
  template <class T>
  ClusterRangesView<T> cluster_ranges(std::size_t field) const {
    return view_cluster_ranges<T>(file_, clusters_.shape, field);
  }

 private:
  void view_leaf_lists(const Watch& watch);
  void view_clusters(const Watch& watch);
  void view_boundary(const Watch& watch);

  PackedFile file_;
  TetMeshDescription description_;
  std::span<const std::array<double, 3>> points_;
  std::span<const std::array<std::uint32_t, 4>> cells_;
  std::span<const std::uint32_t> cell_ids_;
  std::span<const std::uint32_t> point_ranks_;
  std::span<const std::uint64_t> boundary_;
  LeafListsView leaf_lists_;
  CellClustersView clusters_;
};

/// The description must have clusters.
ClusterShape cluster_shape(const TetMeshDescription& description);

std::vector<ArraySpec> tet_mesh_arrays(const TetMeshDescription& description);
FileDescription describe(const TetMeshDescription& description);

/// As for grids. Reports intervals that miss a value, wrong ranges, and a tetrahedron missing from
/// the list of a leaf cell that it touches. With clusters, reports a tetrahedron outside its
/// cluster's box, and a box outside its parent box.
std::vector<std::string> deep_findings(const TetMesh& mesh);

}  // namespace rhoray::formats

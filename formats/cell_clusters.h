#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::formats {

/// Shape of a tree over clusters of consecutive cells. Level 0 holds the clusters. Entry n of level
/// l + 1 is the parent of entries 8n to 8n + 7 of level l, as far as they exist. The last level has
/// at most eight entries.
struct ClusterShape {
  static constexpr std::uint64_t width = 8;  ///< children per entry
  /// Largest cluster size, in cells; such a cluster has at most 256 vertices.
  static constexpr std::uint64_t largest_cell_count = 64;

  std::uint64_t cell_count = 0;  ///< of the mesh
  /// Cells in every cluster but the last: a power of two, 1 to largest_cell_count.
  std::uint64_t cluster_size = 64;

  std::uint64_t count(int level) const;  ///< number of entries in a level
  /// Number of blocks of eight entries; empty entries fill the last block.
  std::uint64_t block_count(int level) const;
  int top_level() const;  ///< first level that fits in one block
};

/// Boxes of eight entries of one level, stored coordinate by coordinate. Each contains the cells
/// below it, rounded outwards. An entry beyond the last one has lo = infinity, hi = -infinity; no
/// ray meets it.
struct BoxBlock {
  /// [axis][entry], in the view's box_unit
  std::array<std::array<float, ClusterShape::width>, 3> lo, hi;
};

/// Smallest and largest values of eight entries; lo > hi where no cell has data.
template <class T>
struct RangeBlock {
  std::array<T, ClusterShape::width> lo, hi;
};

/// Clusters of a mesh: cell c belongs to cluster c / cluster_size. Each cluster has a table of its
/// vertices (point indices, increasing). Each cell has four indices into its cluster's table, one
/// byte each.
struct CellClustersView {
  ClusterShape shape;
  double box_unit = 1;  ///< unit of boxes, in the mesh's frame: a power of two
  /// [clusters + 1] first entry of each table in `tables`
  std::span<const std::uint64_t> table_starts;
  std::span<const std::uint32_t> tables;  ///< point indices
  /// [cells], in the vertex order of a packed cell
  std::span<const std::array<std::uint8_t, 4>> corners;
  std::vector<std::span<const BoxBlock>> boxes;  ///< [level][block]

  std::uint64_t cluster_count() const { return shape.count(0); }
  std::uint64_t first_cell(std::uint64_t cluster) const { return cluster * shape.cluster_size; }
  std::uint64_t end_cell(std::uint64_t cluster) const {
    const std::uint64_t end = (cluster + 1) * shape.cluster_size;
    return end < shape.cell_count ? end : shape.cell_count;
  }
  std::uint64_t cluster_of(std::uint64_t cell) const { return cell >> std::countr_zero(shape.cluster_size); }

  /// The vertices of a cluster's cells.
  std::span<const std::uint32_t> table(std::uint64_t cluster) const {
    return tables.subspan(table_starts[cluster], table_starts[cluster + 1] - table_starts[cluster]);
  }
  /// Point indices of a cell.
  std::array<std::uint32_t, 4> cell(std::uint64_t position) const {
    const std::uint32_t* const table = tables.data() + table_starts[cluster_of(position)];
    const std::array<std::uint8_t, 4>& at = corners[position];
    return {table[at[0]], table[at[1]], table[at[2]], table[at[3]]};
  }
};

/// Ranges of one field, [level][block].
template <class T>
using ClusterRangesView = std::vector<std::span<const RangeBlock<T>>>;

/// Names and shapes of the box arrays, `cluster.boxes.0`, ..., and of a field's range arrays,
/// `range.<field>.0`, ...
std::vector<ArraySpec> cluster_box_arrays(const ClusterShape& shape);
std::vector<ArraySpec> cluster_range_arrays(const ClusterShape& shape, std::size_t field, ElementType type);

/// Refuse an array that is missing or has another type or shape, and entries beyond the last one
/// that are not empty.
std::vector<std::span<const BoxBlock>> view_cluster_boxes(const PackedFile& file, const ClusterShape& shape);
template <class T>
ClusterRangesView<T> view_cluster_ranges(const PackedFile& file, const ClusterShape& shape, std::size_t field);

}  // namespace rhoray::formats

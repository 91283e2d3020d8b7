#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/progress.h"
#include "formats/cell_clusters.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Clusters as they are written (formats::CellClustersView).
struct Clusters {
  formats::ClusterShape shape;
  double box_unit = 1;
  Array<std::uint64_t> table_starts;
  Array<std::uint32_t> tables;
  Array<std::array<std::uint8_t, 4>> corners;
  std::vector<Array<formats::BoxBlock>> boxes;
};

/// Cuts cells that are already ordered (order_cells.h) into clusters.
/// @param cluster_size  a power of two, at most formats::ClusterShape::largest_cell_count
Clusters build_clusters(std::span<const std::array<double, 3>> points,
                        std::span<const std::array<std::uint32_t, 4>> cells, std::uint64_t cluster_size,
                        const Progress& progress = {});

/// Computes the range of a field in every cluster and in the levels above. Only vertices of cells
/// that have data at all four vertices count. T is float or double.
template <class T>
std::vector<Array<formats::RangeBlock<T>>> build_cluster_ranges(std::span<const std::array<std::uint32_t, 4>> cells,
                                                                std::span<const T> values,
                                                                const formats::ClusterShape& shape);

}  // namespace rhoray::preprocess

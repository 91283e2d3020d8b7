#include "preprocess/mesh/build_clusters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "formats/base/checks.h"
#include "formats/base/interval.h"
#include "formats/base/parallel.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

using formats::BoxBlock;
using formats::ClusterShape;
using formats::RangeBlock;
using Cells = std::span<const std::array<std::uint32_t, 4>>;
using Points = std::span<const std::array<double, 3>>;

constexpr std::size_t width = ClusterShape::width;
constexpr std::size_t clusters_at_once = 256;

std::size_t cluster_count(const ClusterShape& shape) {
  return static_cast<std::size_t>(shape.count(0));
}

Cells cells_of(Cells cells, const ClusterShape& shape, std::size_t cluster) {
  const std::size_t first = cluster * shape.cluster_size;
  return cells.subspan(first, std::min<std::size_t>(shape.cluster_size, cells.size() - first));
}

/// Finds the distinct vertices of a cluster, one cluster at a time.
class VertexTable {
 public:
  /// Returns the vertices of the cells in ascending order; valid until the next call.
  std::span<const std::uint32_t> find(Cells cells) {
    count_ = 0;
    slots_.fill(free);
    for (const auto& cell : cells)
      for (const std::uint32_t vertex : cell) {
        std::uint32_t& slot = slot_of(vertex);
        if (slot == free) vertices_[count_++] = slot = vertex;
      }
    std::sort(vertices_.begin(), vertices_.begin() + static_cast<std::ptrdiff_t>(count_));
    for (std::size_t i = 0; i < count_; ++i)
      positions_[static_cast<std::size_t>(&slot_of(vertices_[i]) - slots_.data())] = static_cast<std::uint8_t>(i);
    return std::span(vertices_).first(count_);
  }

  /// Returns the index of a vertex among the vertices of these cells.
  std::uint8_t position(std::uint32_t vertex) {
    return positions_[static_cast<std::size_t>(&slot_of(vertex) - slots_.data())];
  }

 private:
  static constexpr std::size_t most = 4 * ClusterShape::largest_cell_count;
  // no mesh has so many points
  static constexpr std::uint32_t free = std::numeric_limits<std::uint32_t>::max();

  /// Returns the slot that holds the vertex, or the free one where it belongs. At least half of the
  /// slots are free.
  std::uint32_t& slot_of(std::uint32_t vertex) {
    std::size_t at = (vertex * 0x9E3779B1U >> 23) % slots_.size();
    while (slots_[at] != free && slots_[at] != vertex) at = (at + 1) % slots_.size();
    return slots_[at];
  }

  std::array<std::uint32_t, most> vertices_;
  std::size_t count_ = 0;
  std::array<std::uint32_t, 2 * most> slots_;
  std::array<std::uint8_t, 2 * most> positions_;
};

/// Returns the power of two next below the largest coordinate. Divided by it, every coordinate lies
/// in the range of float.
double unit_for(Points points) {
  double largest = 0;
  for (const auto& point : points)
    for (const double x : point) largest = std::max(largest, std::abs(x));
  return largest > 0 ? std::exp2(std::ilogb(largest)) : 1;
}

float rounded_down(double x, double unit) {
  const auto down = static_cast<float>(x / unit);
  return static_cast<double>(down) * unit > x ? std::nextafter(down, -std::numeric_limits<float>::infinity()) : down;
}
float rounded_up(double x, double unit) {
  return -rounded_down(-x, unit);
}

BoxBlock empty_boxes() {
  BoxBlock block;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    block.lo[axis].fill(std::numeric_limits<float>::infinity());
    block.hi[axis].fill(-std::numeric_limits<float>::infinity());
  }
  return block;
}
template <class T>
RangeBlock<T> empty_ranges() {
  RangeBlock<T> block;
  block.lo.fill(Interval<T>{}.lo);
  block.hi.fill(Interval<T>{}.hi);
  return block;
}

void set_box(BoxBlock& block, std::size_t entry, std::span<const std::uint32_t> vertices, Points points, double unit) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::uint32_t vertex : vertices) {
      low = std::min(low, points[vertex][axis]);
      high = std::max(high, points[vertex][axis]);
    }
    block.lo[axis][entry] = rounded_down(low, unit);
    block.hi[axis][entry] = rounded_up(high, unit);
  }
}

/// Adds the levels above the first one: entry n of a level is made from block n below.
template <class Block, class Join>
void add_levels(std::vector<Array<Block>>& levels, const ClusterShape& shape, const Block& empty, const Join& join) {
  for (int level = 1; level <= shape.top_level(); ++level) {
    const Array<Block>& below = levels.back();
    Array<Block> blocks(static_cast<std::size_t>(shape.block_count(level)), empty);
    for (std::size_t entry = 0; entry < below.size(); ++entry) join(blocks[entry / width], entry % width, below[entry]);
    levels.push_back(std::move(blocks));
  }
}

void join_boxes(BoxBlock& block, std::size_t entry, const BoxBlock& below) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    block.lo[axis][entry] = *std::min_element(below.lo[axis].begin(), below.lo[axis].end());
    block.hi[axis][entry] = *std::max_element(below.hi[axis].begin(), below.hi[axis].end());
  }
}

template <class T>
Interval<T> range_of(Cells cells, std::span<const T> values) {
  Interval<T> range;
  for (const auto& cell : cells) {
    const std::array<T, 4> at{values[cell[0]], values[cell[1]], values[cell[2]], values[cell[3]]};
    if (!std::all_of(at.begin(), at.end(), [](T value) { return has_data(value); })) continue;
    const auto [least, most] = std::minmax({at[0], at[1], at[2], at[3]});
    range.include({least, most});
  }
  return range;
}

}  // namespace

Clusters build_clusters(Points points, Cells cells, std::uint64_t cluster_size, const Progress& progress) {
  RHORAY_CHECK(std::has_single_bit(cluster_size) && cluster_size <= ClusterShape::largest_cell_count);
  Clusters clusters;
  clusters.shape = {.cell_count = cells.size(), .cluster_size = cluster_size};
  clusters.box_unit = unit_for(points);
  const std::size_t count = cluster_count(clusters.shape);
  clusters.table_starts.assign(count + 1, 0);
  clusters.corners.resize(cells.size());
  clusters.boxes.emplace_back(static_cast<std::size_t>(clusters.shape.block_count(0)), empty_boxes());

  ProgressMeter meter(progress, "cutting the mesh into clusters (cells)", cells.size());
  const std::size_t piece_count = (count + clusters_at_once - 1) / clusters_at_once;
  // lengths within `tables`, known only here
  std::vector<std::vector<std::uint32_t>> pieces(piece_count);
  parallel_for(piece_count, 1, [&](const IndexRange& part) {
    VertexTable table;
    for (std::size_t piece = part.begin(); piece < part.end(); ++piece) {
      const std::size_t first = piece * clusters_at_once, end = std::min(count, first + clusters_at_once);
      for (std::size_t cluster = first; cluster < end; ++cluster) {
        const Cells its_cells = cells_of(cells, clusters.shape, cluster);
        const std::span<const std::uint32_t> vertices = table.find(its_cells);
        clusters.table_starts[cluster + 1] = vertices.size();
        pieces[piece].insert(pieces[piece].end(), vertices.begin(), vertices.end());
        auto corners = clusters.corners.begin() + static_cast<std::ptrdiff_t>(cluster * cluster_size);
        for (const auto& cell : its_cells)
          *corners++ = {table.position(cell[0]), table.position(cell[1]), table.position(cell[2]),
                        table.position(cell[3])};
        set_box(clusters.boxes[0][cluster / width], cluster % width, vertices, points, clusters.box_unit);
      }
      meter.add(std::min(cells.size(), end * cluster_size) - first * cluster_size);
    }
  });
  for (std::size_t cluster = 0; cluster < count; ++cluster)
    clusters.table_starts[cluster + 1] += clusters.table_starts[cluster];
  clusters.tables.reserve(clusters.table_starts.back());
  for (std::vector<std::uint32_t>& piece : pieces) {
    clusters.tables.insert(clusters.tables.end(), piece.begin(), piece.end());
    piece = {};
  }
  add_levels(clusters.boxes, clusters.shape, empty_boxes(), join_boxes);
  return clusters;
}

template <class T>
std::vector<Array<RangeBlock<T>>> build_cluster_ranges(Cells cells, std::span<const T> values,
                                                       const ClusterShape& shape) {
  std::vector<Array<RangeBlock<T>>> levels;
  levels.emplace_back(static_cast<std::size_t>(shape.block_count(0)), empty_ranges<T>());
  parallel_for(cluster_count(shape), clusters_at_once, [&](const IndexRange& part) {
    for (std::size_t cluster = part.begin(); cluster < part.end(); ++cluster) {
      const Interval<T> range = range_of(cells_of(cells, shape, cluster), values);
      RangeBlock<T>& block = levels[0][cluster / width];
      block.lo[cluster % width] = range.lo;
      block.hi[cluster % width] = range.hi;
    }
  });
  add_levels(levels, shape, empty_ranges<T>(), [](RangeBlock<T>& block, std::size_t entry, const RangeBlock<T>& below) {
    block.lo[entry] = *std::min_element(below.lo.begin(), below.lo.end());
    block.hi[entry] = *std::max_element(below.hi.begin(), below.hi.end());
  });
  return levels;
}

template std::vector<Array<RangeBlock<float>>> build_cluster_ranges(Cells, std::span<const float>, const ClusterShape&);
template std::vector<Array<RangeBlock<double>>> build_cluster_ranges(Cells, std::span<const double>,
                                                                     const ClusterShape&);

}  // namespace rhoray::preprocess

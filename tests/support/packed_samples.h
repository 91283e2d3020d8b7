#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"

/// Small packed files with known content, made in the simplest way: by loops over all cells,
/// without any code of `preprocess`.
namespace rhoray::tests {

struct MacroChoice {
  std::int64_t factor = 2;
  int level_count = 2;
};

/// Range, number of values without data, and a histogram of 16 bins.
template <class T>
formats::FieldSummary summarize(std::string name, std::span<const T> values) {
  formats::FieldSummary field;
  field.name = std::move(name);
  field.type = formats::element_type_of<T>();
  for (const T value : values) {
    const auto number = static_cast<double>(value);
    if (std::isfinite(number))
      field.range.include(number);
    else
      ++field.no_data_count;
  }
  if (field.range.is_empty()) return field;
  field.histogram.resize(16);
  for (const T value : values)
    if (std::isfinite(static_cast<double>(value)))
      ++field.histogram[formats::histogram_bin(field.range, 16, static_cast<double>(value))];
  return field;
}

/// The levels above a level of intervals, each [z, y, x, 2].
template <class T>
std::vector<std::vector<T>> levels_above(const formats::MacroShape& shape, int level, std::vector<T> ranges) {
  std::vector<std::vector<T>> levels{std::move(ranges)};
  for (; level < shape.level_count; ++level) {
    const Index3 below = shape.count(level), above = shape.count(level + 1);
    std::vector<Interval<T>> wider(static_cast<std::size_t>(volume(above)));
    for (std::int64_t k = 0; k < below.z; ++k)
      for (std::int64_t j = 0; j < below.y; ++j)
        for (std::int64_t i = 0; i < below.x; ++i) {
          const auto from = static_cast<std::size_t>(2 * ((k * below.y + j) * below.x + i));
          const auto to =
              static_cast<std::size_t>(((k / shape.factor) * above.y + j / shape.factor) * above.x + i / shape.factor);
          const Interval<T> cell{levels.back()[from], levels.back()[from + 1]};
          if (!cell.is_empty()) wider[to].include(cell);
        }
    std::vector<T> flat;
    for (const Interval<T>& interval : wider) flat.insert(flat.end(), {interval.lo, interval.hi});
    levels.push_back(std::move(flat));
  }
  return levels;
}

template <class T>
struct GridSample {
  formats::GridDescription description;
  std::vector<T> samples;              ///< in the layout's order
  std::vector<std::vector<T>> levels;  ///< level 1, 2, ...

  formats::PackedFileWriter& write_into(formats::PackedFileWriter& writer) const {
    for (std::size_t l = 0; l < levels.size(); ++l)
      writer.write_all(concat("macro.", l + 1), std::span<const T>(levels[l]));
    writer.write_all("samples", std::span<const T>(samples));
    return writer;
  }
};

/// A grid of value(i, j, k), with one world unit between samples.
template <class T>
GridSample<T> sample_grid(const formats::BrickLayout& layout,
                          const std::function<T(std::int64_t, std::int64_t, std::int64_t)>& value,
                          const MacroChoice& macro = {}) {
  GridSample<T> grid;
  const Index3 n = layout.sample_count, padded = layout.padded_count();
  grid.description.layout = layout;
  grid.description.length_unit = "mm";
  grid.description.macro = {n - Index3(1, 1, 1), macro.factor, macro.level_count};

  std::vector<T> values;
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i) values.push_back(value(i, j, k));
  grid.description.fields = {summarize("density", std::span<const T>(values))};
  const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return values[static_cast<std::size_t>((k * n.y + j) * n.x + i)];
  };

  const formats::AxisTables tables(layout);
  grid.samples.resize(static_cast<std::size_t>(volume(padded)));
  for (std::int64_t k = 0; k < padded.z; ++k)
    for (std::int64_t j = 0; j < padded.y; ++j)
      for (std::int64_t i = 0; i < padded.x; ++i)
        grid.samples[tables.address(i, j, k)] = at(std::min(i, n.x - 1), std::min(j, n.y - 1), std::min(k, n.z - 1));

  std::vector<T> leaves;  // level 0, not stored in a grid's file
  for (std::int64_t k = 0; k + 1 < n.z; ++k)
    for (std::int64_t j = 0; j + 1 < n.y; ++j)
      for (std::int64_t i = 0; i + 1 < n.x; ++i) {
        Interval<T> cell;
        bool present = true;
        for (int corner = 0; corner < 8; ++corner) {
          const T corner_value = at(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
          present = present && std::isfinite(static_cast<double>(corner_value));
          cell.include(corner_value);
        }
        if (!present) cell = {};
        leaves.insert(leaves.end(), {cell.lo, cell.hi});
      }
  grid.levels = levels_above(grid.description.macro, 0, leaves);
  grid.levels.erase(grid.levels.begin());
  return grid;
}

template <class T>
formats::BrickGrid packed(const GridSample<T>& grid, const std::filesystem::path& path) {
  formats::PackedFileWriter writer(path, formats::describe(grid.description), formats::grid_arrays(grid.description));
  grid.write_into(writer).commit();
  return formats::BrickGrid(formats::PackedFile::open(path));
}

/// Clusters of cells, as arrays of a file; ranges are in TetSample.
struct ClusterSample {
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint8_t> corners;
  std::vector<std::vector<float>> boxes;  ///< per level: [blocks, 2, 3, 8]
};

struct TetSample {
  formats::TetMeshDescription description;
  std::vector<double> points;
  std::vector<std::uint32_t> cells;
  std::vector<std::uint32_t> cell_ids;     ///< written if not empty
  std::vector<std::uint32_t> point_ranks;  ///< written if not empty
  std::vector<std::uint64_t> boundary;     ///< written if not empty
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint32_t> items;
  std::vector<std::vector<float>> values;  ///< per field, at points
  /// per field: leaf cells, level 1, ...; or clusters, ...
  std::vector<std::vector<std::vector<float>>> ranges;
  ClusterSample clusters;  ///< used instead of lists if the description has clusters

  formats::PackedFileWriter& write_into(formats::PackedFileWriter& writer) const {
    writer.write_all("points", std::span<const double>(points));
    if (description.clusters) {
      writer.write_all("cluster.offsets", std::span<const std::uint64_t>(clusters.offsets));
      writer.write_all("cluster.vertices", std::span<const std::uint32_t>(clusters.vertices));
      writer.write_all("cluster.corners", std::span<const std::uint8_t>(clusters.corners));
      for (std::size_t l = 0; l < clusters.boxes.size(); ++l)
        writer.write_all(concat("cluster.boxes.", l), std::span<const float>(clusters.boxes[l]));
    } else {
      writer.write_all("leaf.offsets", std::span<const std::uint64_t>(offsets));
      writer.write_all("leaf.items", std::span<const std::uint32_t>(items));
      writer.write_all("cells", std::span<const std::uint32_t>(cells));
    }
    if (!boundary.empty()) writer.write_all("boundary", std::span<const std::uint64_t>(boundary));
    if (!cell_ids.empty()) writer.write_all("cell_ids", std::span<const std::uint32_t>(cell_ids));
    if (!point_ranks.empty()) writer.write_all("point_ranks", std::span<const std::uint32_t>(point_ranks));
    for (std::size_t f = 0; f < values.size(); ++f) {
      writer.write_all(concat("field.", f), std::span<const float>(values[f]));
      for (std::size_t l = 0; l < ranges[f].size(); ++l)
        writer.write_all(concat("range.", f, ".", l), std::span<const float>(ranges[f][l]));
    }
    return writer;
  }
};

struct NamedField {
  std::string name;
  std::function<double(const Vec3&)> value;
};

/// The box from (0, 0, 0) to `size`: edge^3 bricks, each of six tetrahedra around its diagonal,
/// with fields sampled at the points. Leaf lists hold every tetrahedron whose bounding box touches
/// the leaf cell.
inline TetSample sample_tets(std::int64_t edge, const std::vector<NamedField>& fields, const Index3& leaf_count,
                             const Vec3& size = {1, 1, 1}, const MacroChoice& macro = {}) {
  TetSample mesh;
  const std::int64_t side = edge + 1;
  for (std::int64_t k = 0; k < side; ++k)
    for (std::int64_t j = 0; j < side; ++j)
      for (std::int64_t i = 0; i < side; ++i) {
        const Vec3 p = Vec3(Index3(i, j, k)) / static_cast<double>(edge) * size;
        mesh.points.insert(mesh.points.end(), {p.x, p.y, p.z});
      }
  // From corner 000 to 111 along three edges; the order of the axes gives the orientation.
  constexpr std::array<std::array<int, 3>, 6> paths{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  const std::array<std::int64_t, 3> step{1, side, side * side};
  for (std::int64_t k = 0; k < edge; ++k)
    for (std::int64_t j = 0; j < edge; ++j)
      for (std::int64_t i = 0; i < edge; ++i)
        for (std::size_t path = 0; path < paths.size(); ++path) {
          std::array<std::int64_t, 4> v{(k * side + j) * side + i, 0, 0, 0};
          for (std::size_t a = 0; a < 3; ++a) v[a + 1] = v[a] + step[static_cast<std::size_t>(paths[path][a])];
          if (path >= 3) std::swap(v[1], v[2]);
          for (const std::int64_t vertex : v) mesh.cells.push_back(static_cast<std::uint32_t>(vertex));
        }

  formats::TetMeshDescription& d = mesh.description;
  d.origin = {10, 20, 30};
  d.length_unit = "m";
  d.point_count = mesh.points.size() / 3;
  d.cell_count = mesh.cells.size() / 4;
  d.lattice = {{0, 0, 0}, size / Vec3(leaf_count), {leaf_count, macro.factor, macro.level_count}};
  for (const NamedField& field : fields) {
    std::vector<float> values;
    for (std::size_t p = 0; p < mesh.points.size(); p += 3)
      values.push_back(static_cast<float>(field.value({mesh.points[p], mesh.points[p + 1], mesh.points[p + 2]})));
    d.fields.push_back(summarize(field.name, std::span<const float>(values)));
    mesh.values.push_back(std::move(values));
  }

  std::vector<std::vector<float>> leaf_ranges(fields.size());
  mesh.offsets.push_back(0);
  for (std::int64_t k = 0; k < leaf_count.z; ++k)
    for (std::int64_t j = 0; j < leaf_count.y; ++j)
      for (std::int64_t i = 0; i < leaf_count.x; ++i) {
        constexpr double rounding = 1e-9;
        const Vec3 low = d.lattice.leaf_size * Vec3(Index3(i, j, k)) - Vec3(rounding);
        const Vec3 high = d.lattice.leaf_size * Vec3(Index3(i + 1, j + 1, k + 1)) + Vec3(rounding);
        std::vector<Interval<float>> range(fields.size());
        for (std::uint32_t cell = 0; cell < d.cell_count; ++cell) {
          Box3 box;
          for (std::size_t v = 0; v < 4; ++v) {
            const std::size_t p = 3 * std::size_t{mesh.cells[4 * cell + v]};
            box.extendBy(Vec3(mesh.points[p], mesh.points[p + 1], mesh.points[p + 2]));
          }
          if (!box.intersects(Box3(low, high))) continue;
          mesh.items.push_back(cell);
          for (std::size_t f = 0; f < fields.size(); ++f) {
            Interval<float> reached;
            bool present = true;
            for (std::size_t v = 0; v < 4; ++v) {
              const float value = mesh.values[f][mesh.cells[4 * cell + v]];
              present = present && std::isfinite(value);
              reached.include(value);
            }
            if (present) range[f].include(reached);
          }
        }
        mesh.offsets.push_back(mesh.items.size());
        for (std::size_t f = 0; f < fields.size(); ++f)
          leaf_ranges[f].insert(leaf_ranges[f].end(), {range[f].lo, range[f].hi});
      }
  for (const std::vector<float>& leaves : leaf_ranges) mesh.ranges.push_back(levels_above(d.lattice.macro, 0, leaves));
  d.leaf_item_count = mesh.items.size();
  return mesh;
}

/// Entries of an octal tree, each with intervals per channel: 3 for a box, 1 for a field's range.
/// Returned as arrays of a file, [level][block][lo, hi][channel][entry], with empty entries up to
/// the next multiple of eight.
inline std::vector<std::vector<float>> tree_of_eights(std::vector<std::vector<Interval<float>>> entries) {
  std::vector<std::vector<float>> levels;
  for (;;) {
    const std::size_t channels = entries.front().size(), blocks = (entries.size() + 7) / 8;
    entries.resize(8 * blocks, std::vector<Interval<float>>(channels));
    levels.emplace_back();
    std::vector<std::vector<Interval<float>>> above(blocks, std::vector<Interval<float>>(channels));
    for (std::size_t block = 0; block < blocks; ++block) {
      for (const bool is_high : {false, true})
        for (std::size_t c = 0; c < channels; ++c)
          for (std::size_t e = 0; e < 8; ++e) {
            const Interval<float>& interval = entries[8 * block + e][c];
            levels.back().push_back(is_high ? interval.hi : interval.lo);
            above[block][c].include(interval);
          }
    }
    if (blocks == 1) return levels;
    entries = std::move(above);
  }
}

/// The same mesh with clusters of `size` cells instead of leaf lists. Its coordinates must be exact
/// in floats.
inline TetSample clustered(TetSample mesh, std::uint64_t size) {
  formats::TetMeshDescription& d = mesh.description;
  d.leaf_item_count = 0;
  mesh.ranges.clear();
  std::vector<std::vector<Interval<float>>> boxes;
  std::vector<std::vector<std::vector<Interval<float>>>> ranges(mesh.values.size());
  mesh.clusters.offsets = {0};
  for (std::uint64_t first = 0; first < d.cell_count; first += size) {
    const std::uint64_t end = std::min(first + size, d.cell_count);
    std::vector<std::uint32_t> table(mesh.cells.begin() + static_cast<std::ptrdiff_t>(4 * first),
                                     mesh.cells.begin() + static_cast<std::ptrdiff_t>(4 * end));
    std::sort(table.begin(), table.end());
    table.erase(std::unique(table.begin(), table.end()), table.end());
    std::vector<Interval<float>> box(3);
    for (const std::uint32_t vertex : table)
      for (std::size_t axis = 0; axis < 3; ++axis)
        box[axis].include(static_cast<float>(mesh.points[3 * std::size_t{vertex} + axis]));
    boxes.push_back(box);
    for (std::uint64_t corner = 4 * first; corner < 4 * end; ++corner)
      mesh.clusters.corners.push_back(
          static_cast<std::uint8_t>(std::lower_bound(table.begin(), table.end(), mesh.cells[corner]) - table.begin()));
    for (std::size_t f = 0; f < mesh.values.size(); ++f) {
      Interval<float> range;
      for (std::uint64_t cell = first; cell < end; ++cell) {
        Interval<float> of_cell;
        bool present = true;
        for (std::size_t v = 0; v < 4; ++v) {
          const float value = mesh.values[f][mesh.cells[4 * cell + v]];
          present = present && std::isfinite(value);
          of_cell.include(value);
        }
        if (present) range.include(of_cell);
      }
      ranges[f].push_back({range});
    }
    mesh.clusters.vertices.insert(mesh.clusters.vertices.end(), table.begin(), table.end());
    mesh.clusters.offsets.push_back(mesh.clusters.vertices.size());
  }
  d.clusters = {.cluster_size = size, .vertex_count = mesh.clusters.vertices.size(), .box_unit = 1};
  mesh.clusters.boxes = tree_of_eights(boxes);
  for (const auto& field : ranges) mesh.ranges.push_back(tree_of_eights(field));
  return mesh;
}

inline formats::TetMesh packed(const TetSample& mesh, const std::filesystem::path& path) {
  formats::PackedFileWriter writer(path, formats::describe(mesh.description),
                                   formats::tet_mesh_arrays(mesh.description));
  mesh.write_into(writer).commit();
  return formats::TetMesh(formats::PackedFile::open(path));
}

}  // namespace rhoray::tests

#include "formats/cell_clusters.h"

#include <limits>

#include "formats/base/text.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

constexpr std::uint64_t width = ClusterShape::width;

std::string box_array(int level) {
  return concat("cluster.boxes.", level);
}
std::string range_array(std::size_t field, int level) {
  return concat("range.", field, ".", level);
}

std::uint64_t divided_up(std::uint64_t count, std::uint64_t by) {
  return count / by + (count % by != 0 ? 1 : 0);
}

/// Views the numbers of an array as blocks.
template <class Block, class T>
std::span<const Block> blocks(std::span<const T> numbers) {
  static_assert(sizeof(Block) % (width * sizeof(T)) == 0);
  return {reinterpret_cast<const Block*>(numbers.data()), numbers.size() * sizeof(T) / sizeof(Block)};
}

/// Calls is_empty(last block, entry) for the entries beyond the last one of a level.
template <class IsEmpty>
void check_beyond(const PackedFile& file, const std::string& array, std::uint64_t count, IsEmpty&& is_empty) {
  for (std::uint64_t entry = count; entry < divided_up(count, width) * width; ++entry)
    if (!is_empty(entry % width))
      refuse(file.name(), concat("array '", array, "', entry ", entry), "one that is not empty",
             concat(count, " entries, and empty ones behind them"));
}

}  // namespace

std::uint64_t ClusterShape::count(int level) const {
  std::uint64_t entries = divided_up(cell_count, cluster_size);
  for (int l = 0; l < level; ++l) entries = divided_up(entries, width);
  return entries;
}

std::uint64_t ClusterShape::block_count(int level) const {
  return divided_up(count(level), width);
}

int ClusterShape::top_level() const {
  int level = 0;
  while (count(level) > width) ++level;
  return level;
}

std::vector<ArraySpec> cluster_box_arrays(const ClusterShape& shape) {
  std::vector<ArraySpec> arrays;
  for (int level = 0; level <= shape.top_level(); ++level)
    arrays.push_back(
        {.name = box_array(level), .type = ElementType::F32, .shape = {shape.block_count(level), 2, 3, width}});
  return arrays;
}

std::vector<ArraySpec> cluster_range_arrays(const ClusterShape& shape, std::size_t field, ElementType type) {
  std::vector<ArraySpec> arrays;
  for (int level = 0; level <= shape.top_level(); ++level)
    arrays.push_back({.name = range_array(field, level), .type = type, .shape = {shape.block_count(level), 2, width}});
  return arrays;
}

std::vector<std::span<const BoxBlock>> view_cluster_boxes(const PackedFile& file, const ClusterShape& shape) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::vector<std::span<const BoxBlock>> levels;
  for (int level = 0; level <= shape.top_level(); ++level) {
    const std::string name = box_array(level);
    levels.push_back(blocks<BoxBlock>(file.array<float>(name, {shape.block_count(level), 2, 3, width})));
    check_beyond(file, name, shape.count(level), [&](std::uint64_t entry) {
      const BoxBlock& last = levels.back().back();
      bool is_empty = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        is_empty = is_empty && last.lo[axis][entry] == infinity && last.hi[axis][entry] == -infinity;
      return is_empty;
    });
  }
  return levels;
}

template <class T>
ClusterRangesView<T> view_cluster_ranges(const PackedFile& file, const ClusterShape& shape, std::size_t field) {
  ClusterRangesView<T> levels;
  for (int level = 0; level <= shape.top_level(); ++level) {
    const std::string name = range_array(field, level);
    levels.push_back(blocks<RangeBlock<T>>(file.array<T>(name, {shape.block_count(level), 2, width})));
    check_beyond(file, name, shape.count(level),
                 [&](std::uint64_t entry) { return levels.back().back().lo[entry] > levels.back().back().hi[entry]; });
  }
  return levels;
}

template ClusterRangesView<float> view_cluster_ranges(const PackedFile&, const ClusterShape&, std::size_t);
template ClusterRangesView<double> view_cluster_ranges(const PackedFile&, const ClusterShape&, std::size_t);

}  // namespace rhoray::formats

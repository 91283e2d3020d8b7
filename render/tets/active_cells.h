#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/tets/tet_data.h"

namespace rhoray::render {

namespace active_cells {

/// Visits the leaf cells of a mesh's lattice that have values on both sides of the isovalue, from
/// the top of the hierarchy down.
template <class Act>
void for_each_leaf(const TetData& view, double isovalue, int level, const Index3& cell, Act&& act) {
  const Interval<double> range = view.range(level, cell);
  if (!(range.lo < isovalue && isovalue <= range.hi)) return;
  if (level == 0) {
    act(cell);
    return;
  }
  const formats::MacroShape& shape = view.description().lattice.macro;
  const Index3 count = shape.count(level - 1);
  Index3 end, child;
  for (int axis = 0; axis < 3; ++axis) end[axis] = std::min((cell[axis] + 1) * shape.factor, count[axis]);
  for (child.z = cell.z * shape.factor; child.z < end.z; ++child.z)
    for (child.y = cell.y * shape.factor; child.y < end.y; ++child.y)
      for (child.x = cell.x * shape.factor; child.x < end.x; ++child.x)
        for_each_leaf(view, isovalue, level - 1, child, act);
}

/// Visits the clusters below an entry of the tree that have values on both sides of the isovalue,
/// in increasing order.
template <class Act>
void for_each_cluster(const TetData& view, double isovalue, int level, std::uint64_t block, Act&& act) {
  view.with_cluster_ranges(level, block, [&](const auto& ranges) {
    for (std::size_t e = 0; e < formats::ClusterShape::width; ++e) {
      const double lo = static_cast<double>(ranges.lo[e]), hi = static_cast<double>(ranges.hi[e]);
      if (!(lo < isovalue && isovalue <= hi)) continue;
      const std::uint64_t entry = block * formats::ClusterShape::width + e;
      if (level == 0)
        act(entry);
      else
        for_each_cluster(view, isovalue, level - 1, entry, act);
    }
  });
}

/// Candidates of a mesh with clusters; a word of bits holds one cluster or several.
template <class Act>
void for_each_word_of_clusters(const TetData& view, double isovalue, Act&& act) {
  const formats::CellClustersView& clusters = view.clusters();
  std::uint64_t word = 0, bits = 0;
  const auto flush = [&] {
    if (bits != 0) act(static_cast<std::uint32_t>(64 * word), bits);
    bits = 0;
  };
  const int top = clusters.shape.top_level();
  for (std::uint64_t block = 0; block < clusters.shape.block_count(top); ++block)
    for_each_cluster(view, isovalue, top, block, [&](std::uint64_t cluster) {
      const std::uint64_t first = clusters.first_cell(cluster), count = clusters.end_cell(cluster) - first;
      if (first / 64 != word) flush(), word = first / 64;
      bits |= (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << first % 64;
    });
  flush();
}

/// Candidates of a mesh with leaf lists, each once although several leaf cells list it.
template <class Act>
void for_each_word_of_lists(const TetData& view, double isovalue, Act&& act) {
  std::vector<std::uint64_t> listed((view.description().cell_count + 63) / 64);
  const formats::MacroShape& shape = view.description().lattice.macro;
  const Index3 count = shape.count(shape.level_count);
  Index3 cell;
  for (cell.z = 0; cell.z < count.z; ++cell.z)
    for (cell.y = 0; cell.y < count.y; ++cell.y)
      for (cell.x = 0; cell.x < count.x; ++cell.x)
        for_each_leaf(view, isovalue, shape.level_count, cell, [&](const Index3& leaf) {
          for (const std::uint32_t tet : view.tetrahedra_at(leaf)) listed[tet / 64] |= std::uint64_t{1} << tet % 64;
        });
  for (std::size_t word = 0; word < listed.size(); ++word)
    if (listed[word] != 0) act(static_cast<std::uint32_t>(64 * word), listed[word]);
}

}  // namespace active_cells

/// Calls act(first, bits) with increasing multiples of 64 as `first`: bit i stands for the cell at
/// index first + i. Cells whose bit is clear, or for which there is no call, have all their values
/// on one side of the isovalue. The others may or may not. Each cell comes up once.
template <class Act>
void for_each_candidate(const TetData& view, double isovalue, Act&& act) {
  if (view.has_clusters())
    active_cells::for_each_word_of_clusters(view, isovalue, act);
  else
    active_cells::for_each_word_of_lists(view, isovalue, act);
}

}  // namespace rhoray::render

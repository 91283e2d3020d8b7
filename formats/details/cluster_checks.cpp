#include "formats/details/cluster_checks.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <functional>

#include "formats/base/parallel.h"

namespace rhoray::formats::details {
namespace {

constexpr std::uint64_t width = ClusterShape::width;
constexpr std::uint64_t scan_piece = 1 << 12;  // clusters

std::string cluster_text(std::uint64_t cluster) {
  return concat("cluster ", cluster);
}
std::string entry_text(int level, std::uint64_t entry) {
  return concat("entry ", entry, " of level ", level);
}

void check_table(const CellClustersView& clusters, std::uint64_t cluster, Findings& findings) {
  const std::span<const std::uint32_t> table = clusters.table(cluster);
  const auto name = [&] { return cluster_text(cluster); };
  if (std::adjacent_find(table.begin(), table.end(), std::greater_equal<>()) != table.end())
    findings.add("a table of vertices that does not rise", cluster, name);
  std::bitset<256> used;
  for (std::uint64_t cell = clusters.first_cell(cluster); cell < clusters.end_cell(cluster); ++cell)
    for (const std::uint8_t corner : clusters.corners[cell]) used.set(corner);
  if (used.count() != table.size()) findings.add("a table with vertices that no cell of it uses", cluster, name);
}

void check_box(const TetMesh& mesh, std::uint64_t cluster, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  const BoxBlock& block = clusters.boxes[0][cluster / width];
  bool holds = true;
  for (const std::uint32_t vertex : clusters.table(cluster))
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = mesh.points()[vertex][axis];
      const double lo = static_cast<double>(block.lo[axis][cluster % width]) * clusters.box_unit;
      const double hi = static_cast<double>(block.hi[axis][cluster % width]) * clusters.box_unit;
      holds = holds && lo <= x && x <= hi;
    }
  if (!holds) findings.add("a cluster that reaches out of its box", cluster, [&] { return cluster_text(cluster); });
}

/// Every entry above level 0 must hold the block below it.
/// @param holds  (entry, its block, the block below)
template <class Block, class Holds>
void check_upward(const ClusterShape& shape, const std::vector<std::span<const Block>>& levels, const std::string& what,
                  Findings& findings, const Holds& holds) {
  for (int level = 1; level <= shape.top_level(); ++level) {
    const auto l = static_cast<std::size_t>(level);
    for (std::uint64_t entry = 0; entry < shape.count(level); ++entry)
      if (!holds(entry % width, levels[l][entry / width], levels[l - 1][entry]))
        findings.add(what, entry, [&] { return entry_text(level, entry); });
  }
}

bool holds_boxes(std::size_t entry, const BoxBlock& block, const BoxBlock& below) {
  bool holds = true;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t e = 0; e < width; ++e)  // written so that a NaN does not hold
      holds = holds && block.lo[axis][entry] <= below.lo[axis][e] && block.hi[axis][entry] >= below.hi[axis][e];
  return holds;
}

template <class T>
bool holds_ranges(std::size_t entry, const RangeBlock<T>& block, const RangeBlock<T>& below) {
  Interval<T> needed;
  for (std::size_t e = 0; e < width; ++e)
    if (below.lo[e] <= below.hi[e]) needed.include({below.lo[e], below.hi[e]});
  const Interval<T> stored{block.lo[entry], block.hi[entry]};
  return needed.is_empty() ? stored.is_empty() : stored.lo <= needed.lo && needed.hi <= stored.hi;
}

template <class T>
void check_ranges(const TetMesh& mesh, std::size_t field, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  const ClusterRangesView<T> levels = mesh.cluster_ranges<T>(field);
  const std::span<const T> values = mesh.values<T>(field);
  const std::string what = concat("ranges of field '", mesh.description().fields[field].name, "'");
  for_each_range(clusters.cluster_count(), scan_piece, 0, [&](std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t cluster = first; cluster < last; ++cluster) {
      RangeBlock<T> needed{};
      Interval<T> range;
      for (std::uint64_t cell = clusters.first_cell(cluster); cell < clusters.end_cell(cluster); ++cell) {
        const std::array<std::uint32_t, 4> v = clusters.cell(cell);
        if (!std::all_of(v.begin(), v.end(), [&](std::uint32_t p) { return is_value(values[p]); })) continue;
        for (const std::uint32_t p : v) range.include(values[p]);
      }
      needed.lo.fill(range.lo);
      needed.hi.fill(range.hi);
      if (!holds_ranges<T>(cluster % width, levels[0][cluster / width], needed))
        findings.add(concat(what, ": a cluster's lacks a value of its cells"), cluster,
                     [&] { return cluster_text(cluster); });
    }
  });
  check_upward(clusters.shape, levels, concat(what, ": an entry does not match the level below"), findings,
               holds_ranges<T>);
}

}  // namespace

void check_clusters(const TetMesh& mesh, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  for_each_range(clusters.cluster_count(), scan_piece, 0, [&](std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t cluster = first; cluster < last; ++cluster) {
      check_table(clusters, cluster, findings);
      check_box(mesh, cluster, findings);
    }
  });
  check_upward(clusters.shape, clusters.boxes, "a box that does not hold those below it", findings, holds_boxes);
  for (std::size_t field = 0; field < mesh.description().fields.size(); ++field)
    if (mesh.description().fields[field].type == ElementType::F32)
      check_ranges<float>(mesh, field, findings);
    else
      check_ranges<double>(mesh, field, findings);
}

}  // namespace rhoray::formats::details

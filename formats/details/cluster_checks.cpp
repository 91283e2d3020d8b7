#include "formats/details/cluster_checks.h"

#include <algorithm>
#include <bitset>
#include <functional>

#include "formats/base/parallel.h"

namespace rhoray::formats::details {
namespace {

constexpr std::uint64_t cluster_piece = 1 << 12;  // clusters

void check_table(const CellClustersView& clusters, std::uint64_t cluster, Findings& findings) {
  const std::span<const std::uint32_t> table = clusters.table(cluster);
  const auto name = [&] { return concat("cluster ", cluster); };
  if (std::adjacent_find(table.begin(), table.end(), std::greater_equal<>()) != table.end())
    findings.add("a table of vertices that does not rise", cluster, name);
  std::bitset<256> used;
  for (std::uint64_t cell = clusters.first_cell(cluster); cell < clusters.end_cell(cluster); ++cell)
    for (const std::uint8_t corner : clusters.corners[cell]) used.set(corner);
  if (used.count() != table.size()) findings.add("a table with vertices that no cell of it uses", cluster, name);
}

}  // namespace

void check_clusters(const TetMesh& mesh, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  for_each_range(clusters.cluster_count(), cluster_piece, 0, [&](std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t cluster = first; cluster < last; ++cluster) check_table(clusters, cluster, findings);
  });
}

}  // namespace rhoray::formats::details

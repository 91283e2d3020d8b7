#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "formats/base/parallel.h"
#include "preprocess/mesh/inspect/finding.h"

namespace rhoray::preprocess::inspect {
namespace {

bool is_finite(const std::array<double, 3>& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// Finds points with the coordinates of an earlier point.
Finding coincident_points(const NeutralMesh& mesh) {
  std::vector<std::uint64_t> order;
  for (std::uint64_t p = 0; p < mesh.points.size(); ++p)
    if (is_finite(mesh.points[p])) order.push_back(p);
  parallel_sort(std::span(order), [&](std::uint64_t a, std::uint64_t b) {
    return mesh.points[a] != mesh.points[b] ? mesh.points[a] < mesh.points[b] : a < b;
  });
  Tally tally;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (mesh.points[order[i]] == mesh.points[order[i - 1]]) tally.add(order[i]);
  return std::move(tally).finding("points at the place of another", "point",
                                  "kept apart: cells on both sides do not share them");
}

}  // namespace

void coordinates(const NeutralMesh& mesh, Findings& findings) {
  Tally not_finite, unreferenced;
  std::vector<bool> is_used(mesh.points.size(), false);
  for (const auto& cell : mesh.cells)
    for (const std::uint64_t vertex : cell) is_used[vertex] = true;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (!is_finite(mesh.points[p])) not_finite.add(p);
    if (!is_used[p]) unreferenced.add(p);
  }
  findings.push_back(
      std::move(not_finite).finding("points with a coordinate that is not finite", "point", "their cells are dropped"));
  findings.push_back(coincident_points(mesh));
  findings.push_back(std::move(unreferenced).finding("points without a cell", "point", "dropped"));
}

}  // namespace rhoray::preprocess::inspect

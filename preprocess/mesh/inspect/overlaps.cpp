#include <algorithm>
#include <array>
#include <atomic>

#include "formats/base/parallel.h"
#include "preprocess/mesh/inspect/finding.h"
#include "preprocess/mesh/inspect/orientation.h"
#include "preprocess/mesh/inspect/point_tree.h"

namespace rhoray::preprocess::inspect {
namespace {

Finding duplicated_cells(const NeutralMesh& mesh) {
  struct Named {
    std::array<std::uint64_t, 4> vertices;
    std::size_t cell;
  };
  std::vector<Named> cells;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (!is_traceable(mesh, c)) continue;
    cells.push_back({mesh.cells[c], c});
    std::sort(cells.back().vertices.begin(), cells.back().vertices.end());
  }
  parallel_sort(std::span(cells), [](const Named& a, const Named& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.cell < b.cell;
  });
  Tally tally;
  for (std::size_t i = 1; i < cells.size(); ++i)
    if (cells[i].vertices == cells[i - 1].vertices) tally.add(id_of_cell(mesh, cells[i].cell));
  return std::move(tally).finding("cells given before", "cell", "kept: the picture is the same with one of them");
}

/// True when p lies inside the cell, faces excluded; false for a flat cell.
bool lies_inside(const NeutralMesh& mesh, const std::array<double, 3>& p, const std::array<std::uint64_t, 4>& cell) {
  const auto& a = mesh.points[cell[0]];
  const auto& b = mesh.points[cell[1]];
  const auto& c = mesh.points[cell[2]];
  const auto& d = mesh.points[cell[3]];
  const int side = orientation(a, b, c, p);
  return side != 0 && orientation(a, c, d, p) == side && orientation(a, d, b, p) == side &&
         orientation(b, d, c, p) == side && orientation(a, b, c, d) == side;
}

std::array<double, 3> centre_of(const NeutralMesh& mesh, const std::array<std::uint64_t, 4>& cell) {
  std::array<double, 3> centre{};
  for (const std::uint64_t vertex : cell)
    for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] += mesh.points[vertex][axis] / 4;
  return centre;
}

/// A cell with the same vertices is a duplicate and counted as such.
bool has_same_vertices(std::array<std::uint64_t, 4> a, std::array<std::uint64_t, 4> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  return a == b;
}

Finding overlapping_cells(const NeutralMesh& mesh) {
  std::vector<PointTree::Point> centres;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    if (is_traceable(mesh, c)) {
      const std::array<double, 3> centre = centre_of(mesh, mesh.cells[c]);
      centres.push_back({{centre[0], centre[1], centre[2]}, c});
    }
  const PointTree tree(std::move(centres));
  std::vector<std::atomic<std::uint8_t>> overlaps(mesh.cells.size());
  const auto mark_overlapped = [&](std::size_t c) {
    if (!is_traceable(mesh, c)) return;
    const auto& cell = mesh.cells[c];
    Box3 box;
    for (const std::uint64_t vertex : cell)
      box.extendBy(Vec3(mesh.points[vertex][0], mesh.points[vertex][1], mesh.points[vertex][2]));
    tree.for_each_in(box, [&](std::uint64_t other) {
      if (other != c && lies_inside(mesh, centre_of(mesh, mesh.cells[other]), cell) &&
          !has_same_vertices(mesh.cells[other], cell))
        overlaps[other].store(1, std::memory_order_relaxed);
    });
  };
  parallel_for(mesh.cells.size(), 64, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) mark_overlapped(c);
  });
  Tally tally;
  for (std::size_t c = 0; c < overlaps.size(); ++c)
    if (overlaps[c] != 0) tally.add(id_of_cell(mesh, c));
  return std::move(tally).finding("cells whose centre lies in another cell", "cell",
                                  "kept: where they overlap, the one met first is shown");
}

}  // namespace

void overlaps(const NeutralMesh& mesh, Findings& findings) {
  findings.push_back(duplicated_cells(mesh));
  findings.push_back(overlapping_cells(mesh));
}

}  // namespace rhoray::preprocess::inspect

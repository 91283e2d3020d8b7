#include "preprocess/grid/resample/faces.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "formats/base/parallel.h"
#include "preprocess/mesh/inspect/orientation.h"

namespace rhoray::preprocess {
namespace {

/// A face in the list of its lowest vertex.
struct Face {
  std::uint64_t others;  ///< the other two vertices, ascending
  /// 8 * cell + 2 * face + 1 when the sorted vertices have the reverse winding
  std::uint64_t cell_and_side;

  friend bool operator<(const Face& a, const Face& b) {
    return a.others != b.others ? a.others < b.others : a.cell_and_side < b.cell_and_side;
  }
};

struct Keyed {
  std::uint32_t lowest;
  Face face;
};

Keyed keyed(const std::array<std::uint32_t, 4>& cell, std::uint64_t c, std::size_t f) {
  std::uint32_t a = cell[face_vertices[f][0]], b = cell[face_vertices[f][1]], d = cell[face_vertices[f][2]];
  std::uint64_t turned = 0;
  const auto order = [&](std::uint32_t& x, std::uint32_t& y) {
    if (x <= y) return;
    std::swap(x, y);
    turned ^= 1;
  };
  order(a, b);
  order(b, d);
  order(a, b);
  return {a, {std::uint64_t{b} << 32 | d, c * 8 + f * 2 + turned}};
}

/// Matches the sorted faces of one lowest vertex: two cells that face each other, and no third.
void match(std::span<const Face> faces, FaceNeighbors& neighbors) {
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].others == faces[i].others) ++end;
    const std::uint64_t a = faces[i].cell_and_side, b = faces[end - 1].cell_and_side;
    if (end - i == 2 && ((a ^ b) & 1) == 1) {
      neighbors.cells[a / 8][a / 2 % 4] = static_cast<std::uint32_t>(b / 8);
      neighbors.cells[b / 8][b / 2 % 4] = static_cast<std::uint32_t>(a / 8);
    }
    i = end;
  }
}

std::vector<bool> flat_cells(std::span<const std::array<double, 3>> points,
                             std::span<const std::array<std::uint32_t, 4>> cells) {
  std::vector<std::uint8_t> flat(cells.size());
  parallel_for(cells.size(), 4096, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      const auto& cell = cells[c];
      flat[c] = orientation(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]) == 0;
    }
  });
  return {flat.begin(), flat.end()};
}

}  // namespace

FaceNeighbors match_faces(std::span<const std::array<double, 3>> points,
                          std::span<const std::array<std::uint32_t, 4>> cells) {
  FaceNeighbors neighbors;
  neighbors.is_flat = flat_cells(points, cells);
  constexpr std::uint32_t none = FaceNeighbors::none;
  neighbors.cells.assign(cells.size(), {none, none, none, none});

  // Count, sum up, fill: the faces of each lowest vertex become consecutive.
  std::vector<std::uint64_t> offsets(points.size() + 1, 0);
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (!neighbors.is_flat[c])
      for (std::size_t f = 0; f < 4; ++f) ++offsets[keyed(cells[c], c, f).lowest + std::size_t{1}];
  for (std::size_t p = 0; p < points.size(); ++p) offsets[p + 1] += offsets[p];
  std::vector<Face> faces(offsets.back());
  std::vector<std::uint64_t> next(offsets.begin(), offsets.end() - 1);
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (!neighbors.is_flat[c])
      for (std::size_t f = 0; f < 4; ++f) {
        const Keyed face = keyed(cells[c], c, f);
        faces[next[face.lowest]++] = face.face;
      }
  parallel_for(points.size(), 1024, [&](const IndexRange& part) {
    for (std::size_t p = part.begin(); p < part.end(); ++p) {
      const std::span<Face> own(faces.data() + offsets[p], offsets[p + 1] - offsets[p]);
      std::sort(own.begin(), own.end());
      match(own, neighbors);
    }
  });
  return neighbors;
}

}  // namespace rhoray::preprocess

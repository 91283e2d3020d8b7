#include "formats/mesh_boundary.h"

#include <algorithm>
#include <mutex>

#include "formats/base/parallel.h"
#include "formats/base/stopping.h"
#include "formats/tet_mesh.h"

namespace rhoray::formats {

namespace {

using Cell = std::array<std::uint32_t, 4>;

/// A face without its lowest point.
struct HigherPoints {
  std::uint32_t middle, highest;
  std::uint64_t number;
};

std::uint32_t lowest_point(const Cell& cell, unsigned opposite) {
  const auto points = face_points(cell, opposite);
  return std::min({points[0], points[1], points[2]});
}

HigherPoints higher_points(const Cell& cell, const CellFace& face) {
  auto points = face_points(cell, face.opposite);
  std::sort(points.begin(), points.end());
  return {points[1], points[2], face_number(face)};
}

/// Appends the faces that occur once. All have the same lowest point.
void append_single(std::span<HigherPoints> faces, FaceNumbers& single) {
  std::sort(faces.begin(), faces.end(), [](const HigherPoints& a, const HigherPoints& b) {
    return a.middle != b.middle ? a.middle < b.middle : a.highest < b.highest;
  });
  for (std::size_t begin = 0, end; begin < faces.size(); begin = end) {
    const auto is_same = [&](const HigherPoints& other) {
      return other.middle == faces[begin].middle && other.highest == faces[begin].highest;
    };
    for (end = begin + 1; end < faces.size() && is_same(faces[end]);) ++end;
    if (end == begin + 1) single.push_back(faces[begin].number);
  }
}

}  // namespace

FaceNumbers boundary_faces(std::span<const Cell> cells, std::uint64_t point_count, std::uint64_t most_at_once,
                           const Watch& watch) {
  std::pmr::vector<std::uint64_t> first(point_count + 1);  // place of a point's first face, by lowest points
  for_each_until_stopped(0, cells.size(), light_piece, watch.stop, [&](std::uint64_t c) {
    for (unsigned k = 0; k < 4; ++k) ++first[lowest_point(cells[c], k) + 1];
  });
  for (std::uint64_t point = 0; point < point_count; ++point) first[point + 1] += first[point];

  FaceNumbers boundary;
  std::mutex guard;
  ProgressMeter meter(watch.progress, "finding the boundary (points)", point_count);
  std::pmr::vector<HigherPoints> faces;
  for (std::uint64_t begin = 0, end; begin < point_count; begin = end) {
    for (end = begin + 1; end < point_count && first[end + 1] - first[begin] <= most_at_once;) ++end;
    faces.resize(first[end] - first[begin]);
    std::pmr::vector<std::uint64_t> next(first.begin() + static_cast<std::ptrdiff_t>(begin),
                                         first.begin() + static_cast<std::ptrdiff_t>(end));
    for_each_until_stopped(0, cells.size(), light_piece, watch.stop, [&](std::uint64_t c) {
      for (unsigned k = 0; k < 4; ++k)
        if (const std::uint32_t lowest = lowest_point(cells[c], k); lowest >= begin && lowest < end)
          faces[next[lowest - begin]++ - first[begin]] = higher_points(cells[c], {c, k});
    });
    for_each_range(end - begin, 1 << 14, 0, [&](std::uint64_t from, std::uint64_t to) {
      FaceNumbers found;
      for_each_until_stopped(
          begin + from, begin + to, light_piece / 16, watch.stop,
          [&](std::uint64_t point) {
            append_single(std::span(faces).subspan(first[point] - first[begin], first[point + 1] - first[point]),
                          found);
          },
          &meter);
      const std::lock_guard lock(guard);
      boundary.insert(boundary.end(), found.begin(), found.end());
    });
  }
  parallel_sort(std::span(boundary), std::less<>());
  return boundary;
}

FaceNumbers computed_boundary_faces(const TetMesh& mesh, const Watch& watch) {
  std::pmr::vector<Cell> cells(mesh.description().cell_count);
  for_each_until_stopped(cells.size(), 1 << 16, light_piece, 0, watch.stop,
                         [&](std::uint64_t cell) { cells[cell] = mesh.cell(cell); });
  return boundary_faces(cells, mesh.description().point_count, most_faces_at_once, watch);
}

FaceNumbers boundary_faces(const TetMesh& mesh, std::span<const std::uint64_t> part, const Watch& watch) {
  std::pmr::vector<Cell> cells(part.size());
  for_each_until_stopped(0, part.size(), light_piece, watch.stop,
                         [&](std::uint64_t c) { cells[c] = mesh.cell(part[c]); });
  FaceNumbers faces = boundary_faces(cells, mesh.description().point_count, most_faces_at_once, watch);
  for (std::uint64_t& number : faces) {
    const CellFace face = face_of_number(number);
    number = face_number({part[face.cell], face.opposite});
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

FaceNumbers boundary_faces(const TetMesh& mesh, const Watch& watch) {
  const std::span<const std::uint64_t> stored = mesh.boundary();
  if (!stored.empty()) return {stored.begin(), stored.end()};
  return computed_boundary_faces(mesh, watch);
}

}  // namespace rhoray::formats

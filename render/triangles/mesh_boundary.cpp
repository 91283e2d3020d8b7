#include "render/triangles/mesh_boundary.h"

#include <algorithm>
#include <limits>

#include "formats/base/error.h"
#include "formats/base/stopping.h"
#include "formats/base/text.h"

namespace rhoray::render {

namespace {

/// The values of a cell field.
class CellLabels {
 public:
  CellLabels(const formats::TetMesh& mesh, std::size_t field) {
    if (mesh.description().cell_fields[field].type == formats::ElementType::F32)
      floats_ = mesh.cell_values<float>(field);
    else
      doubles_ = mesh.cell_values<double>(field);
  }
  std::uint64_t count() const { return floats_.size() + doubles_.size(); }
  double operator[](std::uint64_t cell) const {
    return doubles_.empty() ? static_cast<double>(floats_[cell]) : doubles_[cell];
  }

 private:
  std::span<const float> floats_;  ///< one of these two is empty
  std::span<const double> doubles_;
};

/// Faces between a label and labels to leave out belong to no cell alone in the part of both.
formats::FaceNumbers faces_of(const formats::TetMesh& mesh, std::size_t cell_field, int label,
                              std::span<const int> without, const Watch& watch) {
  const CellLabels labels(mesh, cell_field);
  std::vector<std::uint64_t> part;
  for_each_until_stopped(0, labels.count(), light_piece, watch.stop, [&](std::uint64_t cell) {
    if (labels[cell] == label || std::find(without.begin(), without.end(), labels[cell]) != without.end())
      part.push_back(cell);
  });
  formats::FaceNumbers faces = formats::boundary_faces(mesh, part, watch);
  if (!without.empty())
    std::erase_if(faces, [&](std::uint64_t number) { return labels[formats::face_of_number(number).cell] != label; });
  return faces;
}

}  // namespace

MeshBoundary::MeshBoundary(const TetData& of, const Watch& watch)
    : MeshBoundary(of, formats::boundary_faces(of.mesh(), watch), watch) {}

MeshBoundary::MeshBoundary(const TetData& of, std::size_t cell_field, int label, std::span<const int> without,
                           const Watch& watch)
    : MeshBoundary(of, faces_of(of.mesh(), cell_field, label, without, watch), watch) {}

MeshBoundary::MeshBoundary(const TetData& of, const formats::FaceNumbers& faces, const Watch& watch) : mesh(of) {
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  if (faces.size() >= none)
    throw Error(ErrorCode::unsupported, concat(mesh.mesh().file().name(), ": a boundary of ", faces.size(),
                                               " faces; expected fewer than ", none));
  triangles.reserve(faces.size()), cells.reserve(faces.size());
  std::vector<std::uint32_t> place(mesh.points().size(), none);
  for_each_until_stopped(0, faces.size(), light_piece, watch.stop, [&](std::uint64_t f) {
    const auto [cell, opposite] = formats::face_of_number(faces[f]);
    cells.push_back(static_cast<std::uint32_t>(cell));
    std::array<std::uint32_t, 3> corners = formats::face_points(mesh.vertices(cells.back()), opposite);
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    for (const std::uint32_t corner : corners) place[corner] = 0;
    triangles.push_back(corners);
  });
  for (std::size_t point = 0; point < place.size(); ++point)
    if (place[point] != none) {
      place[point] = static_cast<std::uint32_t>(points.size());
      points.push_back(mesh.points()[point]);
    }
  for (std::array<std::uint32_t, 3>& corners : triangles)
    for (std::uint32_t& corner : corners) corner = place[corner];
}

}  // namespace rhoray::render

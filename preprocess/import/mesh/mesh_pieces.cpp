#include "preprocess/import/mesh/mesh_pieces.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "formats/base/text.h"
#include "preprocess/import/mesh/merge_points.h"

namespace rhoray::preprocess {
namespace {

template <class T>
void append_to(Array<T>& whole, const Array<T>& piece) {
  whole.insert(whole.end(), piece.begin(), piece.end());
}

/// Keeps the fields that both have, with the same name and number of components. Stores the names
/// of the others.
void append_fields(std::vector<NeutralField>& whole, std::vector<NeutralField> piece, const char* owners,
                   std::set<std::string>& incomplete) {
  std::erase_if(whole, [&](NeutralField& field) {
    const auto found = std::find_if(piece.begin(), piece.end(), [&](const NeutralField& other) {
      return other.name == field.name && other.component_count == field.component_count;
    });
    if (found == piece.end()) {
      incomplete.insert(concat("field '", field.name, "' ", owners));
      return true;
    }
    append_to(field.values, found->values);
    field.was_single_precision = field.was_single_precision && found->was_single_precision;
    piece.erase(found);
    return false;
  });
  for (const NeutralField& field : piece) incomplete.insert(concat("field '", field.name, "' ", owners));
}

/// Adds `distance` to the nodes of checked cells; counts in polyhedron streams stay unchanged.
void shift_nodes(CellMesh& mesh, std::uint64_t distance) {
  for (std::uint64_t cell = 0; cell < mesh.kinds.size(); ++cell) {
    const auto nodes = std::span(mesh.cell_nodes)
                           .subspan(mesh.cell_offsets[cell], mesh.cell_offsets[cell + 1] - mesh.cell_offsets[cell]);
    if (mesh.kinds[cell] != CellKind::polyhedron) {
      for (std::uint64_t& node : nodes) node += distance;
      continue;
    }
    for (std::size_t at = 1; at < nodes.size();) {
      const std::size_t end = at + 1 + nodes[at];
      for (++at; at < end; ++at) nodes[at] += distance;
    }
  }
}

/// Gives a mesh without cell_ids those that the cells have by their order.
void number_cells(CellMesh& mesh) {
  if (!mesh.cell_ids.empty()) return;
  mesh.cell_ids.resize(mesh.kinds.size());
  std::iota(mesh.cell_ids.begin(), mesh.cell_ids.end(), std::uint64_t{0});
}

}  // namespace

void MeshPieces::add(CellMesh piece, ForeignCells cells, const std::filesystem::path& path) {
  if (piece.points.empty() && cells.kinds.empty()) return;
  const std::uint64_t count = cells.kinds.size();
  left_out_.include(sift_cells(piece, std::move(cells), path));
  append(std::move(piece), count);
  foreign_cell_count_ += count;
  point_offsets_.push_back(whole_.points.size());
}

void MeshPieces::append(CellMesh piece, std::uint64_t foreign_cell_count) {
  if (point_offsets_.size() == 1) {
    whole_ = std::move(piece);
    return;
  }
  shift_nodes(piece, whole_.points.size());
  const bool has_ids = whole_.kinds.size() != foreign_cell_count_ || piece.kinds.size() != foreign_cell_count;
  if (has_ids) {
    number_cells(whole_);
    number_cells(piece);
    for (const std::uint64_t id : piece.cell_ids) whole_.cell_ids.push_back(foreign_cell_count_ + id);
  }
  const std::uint64_t first_node = whole_.cell_nodes.size();
  for (std::size_t cell = 1; cell < piece.cell_offsets.size(); ++cell)
    whole_.cell_offsets.push_back(first_node + piece.cell_offsets[cell]);
  append_to(whole_.kinds, piece.kinds);
  append_to(whole_.cell_nodes, piece.cell_nodes);
  append_to(whole_.points, piece.points);
  append_fields(whole_.point_fields, std::move(piece.point_fields), "at points", incomplete_fields_);
  append_fields(whole_.cell_fields, std::move(piece.cell_fields), "in cells", incomplete_fields_);
  for (const std::string& note : piece.notes)
    if (std::find(whole_.notes.begin(), whole_.notes.end(), note) == whole_.notes.end()) whole_.notes.push_back(note);
}

CellMesh MeshPieces::finish(const std::filesystem::path& path) {
  finish_cells(whole_, left_out_, path);
  for (const std::string& field : incomplete_fields_)
    whole_.notes.push_back(field + " left out: not every piece has it");
  merge_coincident_points(whole_, point_offsets_);
  return std::move(whole_);
}

}  // namespace rhoray::preprocess

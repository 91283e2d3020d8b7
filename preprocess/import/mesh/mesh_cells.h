#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Cells of all kinds, as VTK's formats hold them: cell c has kind kinds[c] (VTK's number) and the
/// nodes nodes[offsets[c] .. offsets[c+1]-1]; those of a polyhedron are the stream of its faces
/// (CellMesh).
struct ForeignCells {
  Array<std::uint8_t> kinds{};
  Array<std::uint64_t> offsets{};
  Array<std::uint64_t> nodes{};
  Array<std::uint8_t> ghosts{};        ///< VTK's vtkGhostType of each cell; empty = none is one
  Array<std::uint8_t> point_ghosts{};  ///< of each point; empty = none is hidden
};

/// What VTK's arrays vtkGhostType say (vtkDataSetAttributes.h), as far as it is asked here.
constexpr std::uint8_t ghost_duplicate = 1, ghost_refined = 8, ghost_hidden_cell = 32, ghost_hidden_point = 2;

/// How many cells were left out, and why.
struct LeftOut {
  std::map<std::string_view, std::uint64_t> not_filling;  ///< by the plural of their kind
  std::uint64_t duplicates = 0, refined = 0, hidden = 0, blanked = 0;

  void include(const LeftOut& other);
};

/// Fills `mesh` with the cells that fill space. Left out are vertices, lines and faces; duplicates
/// of cells in other pieces, cells that finer ones replace, and hidden ones (vtkGhostType); and
/// cells with a hidden point. `cell_ids` then say where the others stood, and cell fields are
/// shortened alike. Refuses kinds that are not known, offsets and node counts that do not fit their
/// kind, nodes that are not there, and streams of polyhedra that are not faces of at least three
/// corners, four at least. Expects points and fields, one value for each foreign cell, to be there
/// already.
LeftOut sift_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path);

/// Notes what was left out; refuses a mesh without cells.
void finish_cells(CellMesh& mesh, const LeftOut& left_out, const std::filesystem::path& path);

/// Both of them, for a mesh in one piece.
void take_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path);

/// Refuses offsets that do not rise from 0 to the number of nodes, one more than there are kinds.
void check_offsets(const ForeignCells& cells, const std::filesystem::path& path);

/// Refuses a field that does not have one value for each of `owners`.
void check_field(const NeutralField& field, std::uint64_t owners, const std::filesystem::path& path);

/// True when every value is the same as a 32-bit float.
bool fits_single_precision(const Array<double>& values);

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/reading/ghost_values.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Cells of all kinds, as VTK's formats store them. Cell c has kind kinds[c] (VTK's number) and the
/// nodes nodes[offsets[c] .. offsets[c+1]-1]. For a polyhedron these are its face stream
/// (CellMesh).
struct ForeignCells {
  Array<std::uint8_t> kinds{};
  Array<std::uint64_t> offsets{};
  Array<std::uint64_t> nodes{};
  Array<std::uint8_t> ghosts{};        ///< vtkGhostType of each cell; empty: no ghosts
  Array<std::uint8_t> point_ghosts{};  ///< vtkGhostType of each point; empty: none is hidden
};

/// Number of cells left out, and why.
struct LeftOut {
  std::map<std::string_view, std::uint64_t> not_filling;  ///< key: plural name of the cell kind
  std::uint64_t duplicates = 0, refined = 0, hidden = 0, blanked = 0;

  void include(const LeftOut& other);
};

/// Fills `mesh` with the cells that fill space. Leaves out vertices, lines and faces. Also leaves
/// out duplicates of cells in other pieces, cells replaced by finer ones, hidden cells
/// (vtkGhostType), and cells with a hidden point. `cell_ids` then gives the source index of each
/// remaining cell, and cell fields are shortened accordingly.
///
/// Refuses unknown kinds, offsets and node counts that do not fit their kind, and nodes that do not
/// exist. Refuses a polyhedron's face stream unless it has at least four faces with at least three
/// corners each. `mesh` must already have its points and fields, with one value per foreign cell.
LeftOut sift_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path);

/// Adds notes about what was left out; refuses a mesh without cells.
void finish_cells(CellMesh& mesh, const LeftOut& left_out, const std::filesystem::path& path);

/// Calls sift_cells and finish_cells, for a mesh in one piece.
void take_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path);

/// Refuses offsets that do not increase from 0 to the number of nodes, or whose number is not that
/// of the kinds plus one.
void check_offsets(const ForeignCells& cells, const std::filesystem::path& path);

/// Lagrange hexahedra of old VTK files have the nodes of the last two upright edges exchanged:
/// exchanges them again.
void renew_lagrange_hexahedra(ForeignCells& cells, const std::filesystem::path& path);

/// Refuses a field that does not have one value per element of `owners`.
void check_field(const NeutralField& field, std::uint64_t owners, const std::filesystem::path& path);

/// True when every value can be stored exactly as a 32-bit float.
bool fits_single_precision(const Array<double>& values);

/// A field of its values, in single precision if that holds them.
NeutralField field_of(std::string name, Array<double> values, int component_count = 1);

/// Sets `was_single_precision` of a field that was read from numbers of this type. Adds a note when
/// 64-bit integers were rounded.
void note_precision(NeutralField& field, formats::ElementType type, std::vector<std::string>& notes);

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Cells of all kinds, as VTK's formats hold them: cell c has kind kinds[c] (VTK's number) and the nodes
/// nodes[offsets[c] .. offsets[c+1]-1]; those of a polyhedron are the stream of its faces (CellMesh).
struct ForeignCells {
  Array<std::uint8_t> kinds;
  Array<std::uint64_t> offsets;
  Array<std::uint64_t> nodes;
};

/// Fills `mesh` with the cells that fill space. Vertices, lines and faces are left out: `cell_ids` and a note then say
/// so, and cell fields are shortened alike. Refuses kinds that are not known, offsets and node counts that do not fit
/// their kind, and nodes that are not there. Expects points and fields, one value for each foreign cell, to be there
/// already.
void take_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path);

/// Refuses a field that does not have one value for each of `owners`.
void check_field(const NeutralField& field, std::uint64_t owners, const std::filesystem::path& path);

/// True when every value is the same as a 32-bit float.
bool fits_single_precision(const Array<double>& values);

}  // namespace rhoray::preprocess

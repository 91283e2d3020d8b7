#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Cells of all kinds, as VTK's formats hold them: cell c has kind kinds[c] (VTK's number) and the corners
/// corners[offsets[c] .. offsets[c+1]-1].
struct ForeignCells {
  Array<std::uint8_t> kinds;
  Array<std::uint64_t> offsets;
  Array<std::uint64_t> corners;
};

/// Keeps the tetrahedra: fills `cells` and, when others were left out, `cell_ids` and a note; shortens cell fields
/// alike. Vertices, lines and faces are left out; any other volume cell is refused with its kind and count, and so are
/// offsets or corners that do not fit. Expects points and fields to be there already.
void keep_tetrahedra(NeutralMesh& mesh, const ForeignCells& cells, const std::filesystem::path& path);

/// Refuses a field that does not have one value for each of `owners`.
void check_field(const NeutralField& field, std::uint64_t owners, const std::filesystem::path& path);

/// True when every value is the same as a 32-bit float.
bool fits_single_precision(const Array<double>& values);

}  // namespace rhoray::preprocess

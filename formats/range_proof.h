#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"

namespace rhoray::formats {

/// Proves that rays skip only cells without a crossing of one field: value ranges contain the
/// samples or the values at vertices, boxes contain the points, leaf lists name every cell that
/// touches (details/range_checks.h), the field's range contains its values, and a field with
/// no_data_count 0 has no gaps. Opening a file checks none of this, and checksums cannot: whoever
/// writes a file can write its checksums.
///
/// Reads the field and the structure over it once. Refuses (ErrorCode::invalid) with the first
/// finding; the code is that of `rhoray verify --deep`, and shares nothing with the code that
/// packs.
/// @param threads  0 = all cores
/// @return         bytes of the file that were compared
std::uint64_t prove_ranges(const BrickGrid& grid, std::size_t field, unsigned threads = 0);
std::uint64_t prove_ranges(const TetMesh& mesh, std::size_t field, unsigned threads = 0);

}  // namespace rhoray::formats

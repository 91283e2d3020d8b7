#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/base/progress.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"

namespace rhoray::formats {

/// Proves for one field that rays skip only cells without a crossing. Value ranges must contain the
/// samples or the values at vertices. Boxes must contain the points. Leaf lists must name every
/// cell that touches the leaf (details/range_checks.h). The field's range must contain its values,
/// and a field with no_data_count 0 must have no gaps. Opening a file checks none of this.
/// Checksums cannot check it, because whoever writes a file can also write its checksums.
///
/// Reads the field and the structure over it once. Refuses (ErrorCode::invalid) with the first
/// finding. `rhoray verify --deep` uses the same code; the code shares nothing with the packer.
/// A stop request ends it between rows of macrocells or groups of cells (ErrorCode::interrupted);
/// then it has proven nothing.
/// @param threads  0 = all cores
/// @return         number of bytes of the file that were compared
std::uint64_t prove_ranges(const BrickGrid& grid, std::size_t field, unsigned threads = 0, const Watch& watch = {});
std::uint64_t prove_ranges(const TetMesh& mesh, std::size_t field, unsigned threads = 0, const Watch& watch = {});

}  // namespace rhoray::formats

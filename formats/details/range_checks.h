#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/base/interval.h"
#include "formats/brick_grid.h"
#include "formats/details/deep_checks.h"
#include "formats/tet_mesh.h"

/// Whether stored value ranges, boxes and leaf lists hold what they stand for. They are compared with the samples,
/// points and cells of the file; nothing here is shared with the code that packs.
namespace rhoray::formats::details {

/// What the check has read.
struct RangesRead {
  Interval<double> values{};  ///< of the field, where it has data
  bool has_gaps = false;      ///< the field has no data at some sample or point
  std::uint64_t bytes = 0;    ///< of the arrays compared; of a mesh with those of check_boxes_and_lists
};

/// What rays skip cells by, whatever the field: points lie in the lattice and each cell is listed in every leaf
/// cell that it touches; or each cluster's box holds its points, and each box above holds those below.
/// @param threads  0 = all cores
void check_boxes_and_lists(const TetMesh& mesh, unsigned threads, Findings& findings);

/// The ranges of one field. In a grid each macrocell of level 1 contains the samples of its cells that have data; in a
/// mesh each leaf cell or cluster the values at the vertices of its cells that have data; each level above contains the
/// one below.
/// @param threads  0 = all cores
RangesRead check_ranges(const BrickGrid& grid, std::size_t field, unsigned threads, Findings& findings);
RangesRead check_ranges(const TetMesh& mesh, std::size_t field, unsigned threads, Findings& findings);

}  // namespace rhoray::formats::details

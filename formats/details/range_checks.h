#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/base/interval.h"
#include "formats/brick_grid.h"
#include "formats/details/deep_checks.h"
#include "formats/tet_mesh.h"

/// Checks whether stored value ranges, boxes and leaf lists contain what they should. Compares them
/// with the samples, points and cells of the file; shares nothing with the packer.
namespace rhoray::formats::details {

/// Results of reading a field's values.
struct RangesRead {
  Interval<double> values{};  ///< of the field, where it has data
  bool has_gaps = false;      ///< the field has no data at some sample or point
  /// of the arrays compared; for a mesh, includes those of check_boxes_and_lists
  std::uint64_t bytes = 0;
};

/// Checks that all points lie in the lattice of leaf cells, and returns whether they do. No proof
/// relies on it for a mesh with clusters.
bool check_points(const TetMesh& mesh, const CheckOptions& options, Findings& findings);

/// Checks the parts of the hierarchy that do not depend on a field. Leaf lists: all points lie in
/// the lattice, and every leaf cell lists each tetrahedron that touches it. Clusters: each box
/// contains its points, and each box above contains the boxes below.
void check_boxes_and_lists(const TetMesh& mesh, const CheckOptions& options, Findings& findings);

/// Checks the ranges of one field. In a grid, each macrocell of level 1 must contain the samples of
/// those of its cells that have data. In a mesh, each leaf cell or cluster must contain the values
/// at the vertices of those of its cells that have data. Each higher level must contain the one
/// below.
RangesRead check_ranges(const BrickGrid& grid, std::size_t field, const CheckOptions& options, Findings& findings);
RangesRead check_ranges(const TetMesh& mesh, std::size_t field, const CheckOptions& options, Findings& findings);

}  // namespace rhoray::formats::details

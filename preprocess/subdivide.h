#pragma once

#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct SubdivideOptions {
  /// Largest error of higher-order cells: the difference between the curved cell and its
  /// tetrahedra. The geometric error is a fraction of the mesh's box diagonal, that of a point
  /// field a fraction of its range.
  double max_error = 0.01;
  /// The point fields whose error counts, as NAME or NAME.component; the others are carried along.
  /// Empty: all.
  std::vector<std::string> fields{};
  /// An edge that spans less than this fraction of its higher-order cell is not cut to reduce the
  /// error.
  double finest = 1.0 / 256;
};

/// Cuts cells of every kind into tetrahedra. Where two cells share a face, both cut it in the same
/// way, even where cells are collapsed (name a point twice). `cell_ids` tells which cell each
/// tetrahedron came from; cell fields are copied to it. A mesh of tetrahedra is moved unchanged.
///
/// Cells with flat faces are cut along their own edges; where tetrahedra would overlap, they get a
/// point inside. Higher-order cells are cut by their shape functions until the error is small
/// enough. Notes give the sampled error when it is larger than requested, and the errors for which
/// cuts were made. Nodes that no tetrahedron needs are left out.
///
/// Refuses:
///  * ErrorCode::invalid: points that do not exist, node counts that do not fit their kind, and
///    polyhedra that are not closed;
///  * ErrorCode::unsupported: Lagrange cells of an order above 10 or of different orders along
///    their axes;
///  * ErrorCode::usage: errors that are not above 0.
NeutralMesh subdivide(CellMesh mesh, const SubdivideOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

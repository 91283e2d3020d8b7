#pragma once

#include <string>
#include <vector>

#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

struct SubdivideOptions {
  /// Largest error of higher-order cells, geometric as a share of the mesh's box diagonal and of every point field as a
  /// share of its range: between the curved cell and the tetrahedra that stand for it.
  double max_error = 0.01;
  /// The point fields whose error counts, by their names, as NAME or NAME.component; the others come along. Empty: all.
  std::vector<std::string> fields{};
  /// An edge that stretches over less than this share of its higher-order cell is not cut for the sake of the error.
  double finest = 1.0 / 256;
};

/// Makes tetrahedra of cells of every kind. Their faces agree with the neighbours': wherever a face is shared by two
/// cells, both cut it alike, also where cells are collapsed (name a point twice). `cell_ids` tells which cell each came
/// from; cell fields go with it. A mesh of tetrahedra is moved as it is.
///
/// Cells of flat faces are cut along their own edges; where tetrahedra would overlap, they get a point inside. Cells of
/// higher order are cut until the error holds, by their shape functions; notes say how large it is, as sampled, when it
/// is larger than asked for, and which errors the cuts were made for. Nodes that no tetrahedron needs are left out.
///
/// Refuses (ErrorCode::invalid) points that are not there, node counts that do not fit their kind and polyhedra that
/// are not closed; (ErrorCode::unsupported) Lagrange cells of an order above 10 or of different orders along their
/// axes; (ErrorCode::usage) errors that are not above 0.
NeutralMesh subdivide(CellMesh mesh, const SubdivideOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

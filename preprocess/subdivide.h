#pragma once

#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

struct SubdivideOptions {
  /// Largest error of higher-order cells, geometric as a share of the mesh's box diagonal and of every point field as a
  /// share of its range: between the curved cell and the tetrahedra that stand for it.
  double max_error = 0.01;
};

/// Makes tetrahedra of cells of every kind. Their faces agree with the neighbours': wherever a face is shared by two
/// cells, both cut it alike. `cell_ids` tells which cell each came from; cell fields go with it. A mesh of tetrahedra
/// is moved as it is.
NeutralMesh subdivide(CellMesh mesh, const SubdivideOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

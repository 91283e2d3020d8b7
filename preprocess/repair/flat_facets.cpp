#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

#include "preprocess/repair/steps.h"

namespace rhoray::preprocess::repair {

bool remove_flat_facets(TriangleMesh& mesh) {
  const bool all = CGAL::Polygon_mesh_processing::remove_degenerate_faces(mesh);
  mesh.collect_garbage();
  return all;
}

}  // namespace rhoray::preprocess::repair

#include <CGAL/Polygon_mesh_processing/corefinement.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

std::optional<TriangleMesh> with_facets_cut(TriangleMesh mesh) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  try {
    if (!pmp::experimental::autorefine_and_remove_self_intersections(mesh)) return std::nullopt;
  } catch (const pmp::Corefinement::Triple_intersection_exception&) {  // three sheets through one point
    return std::nullopt;
  }
  mesh.collect_garbage();
  return mesh;
}

}  // namespace rhoray::preprocess::repair

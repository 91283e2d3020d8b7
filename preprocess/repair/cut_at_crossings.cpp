#include <CGAL/Polygon_mesh_processing/corefinement.h>

#include "preprocess/repair/steps.h"

namespace rhoray::preprocess::repair {

bool cut_at_crossings(TriangleMesh& mesh) {
  TriangleMesh changed = mesh;
  if (!CGAL::Polygon_mesh_processing::experimental::autorefine_and_remove_self_intersections(changed)) return false;
  changed.collect_garbage();
  mesh = std::move(changed);
  return true;
}

}  // namespace rhoray::preprocess::repair

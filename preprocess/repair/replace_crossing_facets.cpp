#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>

#include "preprocess/repair/steps.h"

namespace rhoray::preprocess::repair {

bool replace_crossing_facets(TriangleMesh& mesh) {
  TriangleMesh changed = mesh;
  // Giving up the number of tunnels lets it close the bridges by which a sheet touches itself.
  if (!CGAL::Polygon_mesh_processing::experimental::remove_self_intersections(
          changed, CGAL::parameters::preserve_genus(false)))
    return false;
  changed.collect_garbage();
  mesh = std::move(changed);
  return true;
}

}  // namespace rhoray::preprocess::repair

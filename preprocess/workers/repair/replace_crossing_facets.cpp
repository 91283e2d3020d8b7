#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

std::optional<TriangleMesh> with_facets_replaced(TriangleMesh mesh) {
  // Giving up the number of tunnels lets it close the bridges by which a sheet touches itself.
  if (!CGAL::Polygon_mesh_processing::experimental::remove_self_intersections(mesh,
                                                                              CGAL::parameters::preserve_genus(false)))
    return std::nullopt;
  mesh.collect_garbage();
  return mesh;
}

}  // namespace rhoray::preprocess::repair

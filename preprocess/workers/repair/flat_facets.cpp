#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

bool remove_flat_facets(TriangleMesh& mesh) {
  const bool all = CGAL::Polygon_mesh_processing::remove_degenerate_faces(mesh);
  mesh.collect_garbage();
  return all;
}

void remove_needles(TriangleMesh& mesh, double longest_collapsed) {
  constexpr double flattest_cap = -0.9962;  // cosine of 175 degrees
  constexpr double slimmest_needle = 30;    // longest edge to shortest
  TriangleMesh changed = mesh;
  CGAL::Polygon_mesh_processing::experimental::remove_almost_degenerate_faces(changed, flattest_cap, slimmest_needle,
                                                                              longest_collapsed);
  changed.collect_garbage();
  if (changed.number_of_faces() > 0 && count_crossings(changed) == 0) mesh = std::move(changed);
}

}  // namespace rhoray::preprocess::repair

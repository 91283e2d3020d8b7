#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

std::vector<TriangleMesh> parts_of(const TriangleMesh& mesh) {
  std::vector<TriangleMesh> parts;
  pmp::split_connected_components(mesh, parts);
  return parts;
}

double area_of(const TriangleMesh& mesh) {
  return CGAL::to_double(pmp::area(mesh));
}

}  // namespace rhoray::preprocess::repair

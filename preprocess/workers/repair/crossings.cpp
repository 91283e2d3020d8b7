#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include <iterator>
#include <utility>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

std::uint64_t count_crossings(const TriangleMesh& mesh) {
  std::vector<std::pair<TriangleMesh::Face_index, TriangleMesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(mesh, std::back_inserter(pairs));
  return pairs.size();
}

}  // namespace rhoray::preprocess::repair

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include <iterator>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

void fill_holes(TriangleMesh& mesh, RepairReport& report) {
  std::vector<TriangleMesh::Halfedge_index> rings;
  pmp::extract_boundary_cycles(mesh, std::back_inserter(rings));
  for (const auto ring : rings) {
    std::vector<TriangleMesh::Face_index> facets;
    std::vector<TriangleMesh::Vertex_index> points;
    pmp::triangulate_and_refine_hole(mesh, ring, std::back_inserter(facets), std::back_inserter(points));
    report.filled_holes += !facets.empty();
  }
}

}  // namespace rhoray::preprocess::repair

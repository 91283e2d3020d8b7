#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include "preprocess/repair/steps.h"

namespace rhoray::preprocess::repair {

void stitch(TriangleMesh& mesh, RepairReport& report) {
  report.stitched_edges += CGAL::Polygon_mesh_processing::stitch_borders(mesh);
}

}  // namespace rhoray::preprocess::repair

#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

void stitch(TriangleMesh& mesh, RepairReport& report) {
  report.stitched_edges += CGAL::Polygon_mesh_processing::stitch_borders(mesh);
}

}  // namespace rhoray::preprocess::repair

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>  // before distance.h, which needs it
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/distance.h>

#include <cmath>

#include "preprocess/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

void measure(const TriangleMesh& old_mesh, const TriangleMesh& new_mesh, RepairReport& report) {
  const CGAL::Bbox_3 box = pmp::bbox(old_mesh);
  report.box_diagonal = std::hypot(box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin());
  report.distance_error = 1e-4 * report.box_diagonal;
  const auto farthest = [&](const TriangleMesh& from, const TriangleMesh& to) {
    return pmp::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(from, to, report.distance_error);
  };
  report.farthest_new_from_old = farthest(new_mesh, old_mesh);
  report.farthest_old_from_new = farthest(old_mesh, new_mesh);
}

}  // namespace rhoray::preprocess::repair

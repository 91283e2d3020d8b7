#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>  // before distance.h, which needs it
#include <CGAL/Polygon_mesh_processing/distance.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

double farthest(const TriangleMesh& from, const TriangleMesh& to, double error) {
  return pmp::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(from, to, error);
}

}  // namespace rhoray::preprocess::repair

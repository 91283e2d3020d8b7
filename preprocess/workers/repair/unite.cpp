#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/intersection.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

/// Whether the two could be united; `first` then holds both.
bool unite(TriangleMesh& first, const TriangleMesh& second) {
  TriangleMesh a = first, b = second, both;
  if (!pmp::is_outward_oriented(a)) pmp::reverse_face_orientations(a);
  if (!pmp::is_outward_oriented(b)) pmp::reverse_face_orientations(b);
  try {
    if (!pmp::corefine_and_compute_union(a, b, both, CGAL::parameters::throw_on_self_intersection(true))) return false;
  } catch (const pmp::Corefinement::Self_intersection_exception&) {
    return false;
  } catch (const pmp::Corefinement::Triple_intersection_exception&) {
    return false;
  }
  both.collect_garbage();
  first = std::move(both);
  return true;
}

}  // namespace

void unite_crossing_parts(std::vector<TriangleMesh>& parts, RepairReport& report) {
  // Each part takes in those behind it that cross it, until none does.
  for (std::size_t i = 0; i < parts.size(); ++i) {
    bool united = false;
    for (std::size_t j = i + 1; j < parts.size();) {
      if (CGAL::is_closed(parts[i]) && CGAL::is_closed(parts[j]) && pmp::do_intersect(parts[i], parts[j]) &&
          unite(parts[i], parts[j])) {
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(j));
        report.united_parts += united ? 1 : 2;
        united = true;
        j = i + 1;
      } else {
        ++j;
      }
    }
  }
}

}  // namespace rhoray::preprocess::repair

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>

#include <cmath>

#include "formats/base/error.h"
#include "preprocess/workers/faces/cut_faces.h"
#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

bool is_finite(const std::array<double, 3>& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

}  // namespace

Soup soup_of(const NeutralSurface& surface, RepairReport& report) {
  Soup soup;
  for (const auto& p : surface.points)
    soup.points.push_back(is_finite(p) ? Point(p[0], p[1], p[2]) : Point(0, 0, 0));  // the latter is then unused
  const CutFaces cut = cut_faces(surface);
  report.dropped_not_finite += cut.not_finite;
  for (const auto& triangle : cut.triangles) soup.facets.emplace_back(triangle.begin(), triangle.end());
  pmp::remove_isolated_points_in_polygon_soup(soup.points, soup.facets);
  return soup;
}

void clean_soup(Soup& soup, RepairReport& report) {
  report.merged_points += pmp::merge_duplicate_points_in_polygon_soup(soup.points, soup.facets);
  report.dropped_flat += std::erase_if(soup.facets, [&](const std::vector<std::size_t>& f) {
    return CGAL::collinear(soup.points[f[0]], soup.points[f[1]], soup.points[f[2]]);
  });
  report.dropped_twins += pmp::merge_duplicate_polygons_in_polygon_soup(
      soup.points, soup.facets, CGAL::parameters::erase_all_duplicates(false).require_same_orientation(false));
  pmp::remove_isolated_points_in_polygon_soup(soup.points, soup.facets);
}

TriangleMesh mesh_of(Soup soup, RepairReport& report) {
  const std::size_t before = soup.points.size();
  pmp::orient_polygon_soup(soup.points, soup.facets);
  report.split_points += soup.points.size() - before;
  TriangleMesh mesh;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.facets, mesh);
  return mesh;
}

}  // namespace rhoray::preprocess::repair

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

using Ring = std::vector<Point>;

/// The corners of a ring of open edges.
Ring ring_of(const TriangleMesh& mesh, TriangleMesh::Halfedge_index start) {
  Ring ring;
  for (const auto edge : mesh.halfedges_around_face(start)) ring.push_back(mesh.point(mesh.target(edge)));
  return ring;
}

/// Cuts a ring where it comes back to a point, so that each of the rings has different points.
std::vector<Ring> simple_rings(const Ring& ring) {
  std::vector<Ring> rings;
  Ring path;
  for (const Point& point : ring) {
    if (const auto before = std::find(path.begin(), path.end(), point); before != path.end()) {
      rings.emplace_back(before, path.end());
      path.erase(before, path.end());
    }
    path.push_back(point);
  }
  rings.push_back(std::move(path));
  std::erase_if(rings, [](const Ring& each) { return each.size() < 3; });  // an edge, there and back
  return rings;
}

/// Fills holes that touch each other in a point. The mesh has that point twice, so that the holes
/// are one ring, and CGAL 5.5 crashes when it refines the triangles of such a ring. The facets are
/// therefore added as polygons, and connected anew.
TriangleMesh with_filled(const TriangleMesh& mesh, const std::vector<Ring>& rings, RepairReport& report) {
  Soup soup;
  pmp::polygon_mesh_to_polygon_soup(mesh, soup.points, soup.facets);
  for (const Ring& ring : rings) {
    std::vector<CGAL::Triple<int, int, int>> facets;
    pmp::triangulate_hole_polyline(ring, std::back_inserter(facets));
    const std::size_t first = soup.points.size();
    soup.points.insert(soup.points.end(), ring.begin(), ring.end());
    for (const auto& facet : facets)
      soup.facets.push_back({first + static_cast<std::size_t>(facet.first),
                             first + static_cast<std::size_t>(facet.second),
                             first + static_cast<std::size_t>(facet.third)});
    report.filled_holes += !facets.empty();
  }
  pmp::merge_duplicate_points_in_polygon_soup(soup.points, soup.facets);
  return mesh_of(std::move(soup), report);
}

}  // namespace

void fill_holes(TriangleMesh& mesh, RepairReport& report) {
  std::vector<TriangleMesh::Halfedge_index> starts;
  pmp::extract_boundary_cycles(mesh, std::back_inserter(starts));
  std::vector<Ring> touching;
  for (const auto start : starts) {
    if (std::vector<Ring> rings = simple_rings(ring_of(mesh, start)); rings.size() > 1) {
      touching.insert(touching.end(), rings.begin(), rings.end());
      continue;
    }
    std::vector<TriangleMesh::Face_index> facets;
    std::vector<TriangleMesh::Vertex_index> points;
    pmp::triangulate_and_refine_hole(mesh, start, std::back_inserter(facets), std::back_inserter(points));
    report.filled_holes += !facets.empty();
  }
  if (!touching.empty()) mesh = with_filled(mesh, touching, report);
}

}  // namespace rhoray::preprocess::repair

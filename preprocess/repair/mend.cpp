#include "preprocess/repair/mend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "formats/base/trouble.h"
#include "preprocess/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace {

/// The larger of the distances between two surfaces, there and back.
double distance(const TriangleMesh& a, const TriangleMesh& b, double error) {
  return std::max(farthest(a, b, error), farthest(b, a, error));
}

/// Of the two ways to be rid of crossings, the one that moves the part less.
void resolve_crossings(TriangleMesh& part, double error, RepairReport& report) {
  if (count_crossings(part) == 0) return;
  remove_flat_facets(part);
  std::optional<TriangleMesh> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const auto way : {with_facets_replaced, with_facets_cut}) {
    std::optional<TriangleMesh> candidate = way(part);
    if (!candidate || candidate->number_of_faces() == 0) continue;
    fill_holes(*candidate, report);
    if (count_crossings(*candidate) > 0) continue;
    const double moved = distance(part, *candidate, error);
    if (moved < least) {
      least = moved;
      nearest = std::move(candidate);
    }
  }
  if (!nearest) return;
  part = std::move(*nearest);
  ++report.mended_parts;
}

TriangleMesh mended(TriangleMesh mesh, const RepairOptions& options, RepairReport& report) {
  stitch(mesh, report);
  fill_holes(mesh, report);
  report.crossing_pairs = count_crossings(mesh);

  std::vector<TriangleMesh> parts = parts_of(mesh);
  if (options.largest_part_only && parts.size() > 1) {
    const auto largest = std::max_element(parts.begin(), parts.end(), [](const TriangleMesh& a, const TriangleMesh& b) {
      return area_of(a) < area_of(b);
    });
    report.dropped_parts = parts.size() - 1;
    parts = {std::move(*largest)};
  }
  if (report.crossing_pairs > 0) {
    for (TriangleMesh& part : parts) resolve_crossings(part, report.distance_error, report);
    unite_crossing_parts(parts, report);
  }
  TriangleMesh whole;
  for (TriangleMesh& part : parts) {
    remove_flat_facets(part);
    remove_needles(part, 10 * report.distance_error);
    whole += part;
  }
  return whole;
}

NeutralSurface neutral(const TriangleMesh& mesh) {
  NeutralSurface surface;
  std::vector<std::uint64_t> position(mesh.num_vertices() + mesh.number_of_removed_vertices());
  for (const auto v : mesh.vertices()) {
    position[v] = surface.points.size();
    const Point& p = mesh.point(v);
    surface.points.push_back({p.x(), p.y(), p.z()});
  }
  for (const auto f : mesh.faces()) {
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) surface.facet_corners.push_back(position[v]);
    surface.facet_offsets.push_back(surface.facet_corners.size());
  }
  return surface;
}

double diagonal_of(const Soup& soup) {
  CGAL::Bbox_3 box;
  for (const Point& p : soup.points) box += p.bbox();
  return std::hypot(box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin());
}

}  // namespace

RepairedSurface mend(const NeutralSurface& surface, const RepairOptions& options) {
  RepairedSurface result;
  RepairReport& report = result.report;
  Soup soup = soup_of(surface, report);
  clean_soup(soup, report);
  if (soup.facets.empty()) throw Error(Trouble::invalid, "surface: no facet has an area; there is nothing to repair");

  TriangleMesh before, after;
  report.box_diagonal = diagonal_of(soup);
  report.distance_error = 1e-4 * report.box_diagonal;
  if (options.wrap > 0) {
    RepairReport ignored;
    before = mesh_of(soup, ignored);
    const double gap = options.wrap * report.box_diagonal;
    after = wrap(soup, gap, gap / 20);
    report.wrapped = true;
  } else {
    before = mesh_of(std::move(soup), report);
    after = mended(before, options, report);
  }
  if (after.number_of_faces() == 0) throw Error(Trouble::invalid, "surface: nothing was left of it by the repair");
  report.farthest_new_from_old = farthest(after, before, report.distance_error);
  report.farthest_old_from_new = farthest(before, after, report.distance_error);
  result.surface = neutral(after);
  result.surface.holes = surface.holes;
  result.surface.regions = surface.regions;
  return result;
}

}  // namespace rhoray::preprocess::repair

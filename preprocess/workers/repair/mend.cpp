#include "preprocess/workers/repair/mend.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "formats/base/error.h"
#include "preprocess/workers/repair/apart.h"
#include "preprocess/workers/repair/report.h"
#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

namespace {

/// Names what comes next. Nobody hears of it unless the process is ended there.
void announce(const char* step) {
  std::fprintf(stderr, "%s\n", step);
}

/// The larger of the distances between two surfaces, there and back.
double distance(const TriangleMesh& a, const TriangleMesh& b, double error) {
  return std::max(farthest(a, b, error), farthest(b, a, error));
}

struct Way {
  const char* step;
  std::optional<TriangleMesh> (*without_crossings)(TriangleMesh);
};

/// Of the two ways to be rid of crossings, the one that moves the part less. Returns how far.
double resolve_crossings(TriangleMesh& part, RepairReport& report) {
  if (count_crossings(part) == 0) return 0;
  remove_flat_facets(part);
  std::optional<TriangleMesh> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const Way way : {Way{"replacing intersecting facets", with_facets_replaced},
                        Way{"cutting intersecting facets", with_facets_cut}}) {
    announce(way.step);
    std::optional<TriangleMesh> candidate = run_apart(part, way.without_crossings);
    if (!candidate || candidate->number_of_faces() == 0) continue;
    fill_holes(*candidate, report);
    if (count_crossings(*candidate) > 0) continue;
    announce("measuring how far the surface moved");
    const double moved = distance(part, *candidate, report.distance_error);
    if (moved < least) {
      least = moved;
      nearest = std::move(candidate);
    }
  }
  if (!nearest) return 0;
  part = std::move(*nearest);
  ++report.mended_parts;
  return least;
}

TriangleMesh whole_of(const std::vector<TriangleMesh>& parts) {
  TriangleMesh whole;
  for (const TriangleMesh& part : parts) whole += part;
  return whole;
}

/// Returns the parts without them, as one.
TriangleMesh without_needles(std::vector<TriangleMesh>& parts, RepairReport& report) {
  announce("removing flat facets and needles");
  const TriangleMesh before = whole_of(parts);
  for (TriangleMesh& part : parts) {
    remove_flat_facets(part);
    remove_needles(part, 10 * report.distance_error);
  }
  TriangleMesh after = whole_of(parts);
  if (before.number_of_faces() > 0 && after.number_of_faces() > 0)
    report.moved += distance(before, after, report.distance_error);
  return after;
}

TriangleMesh mended(TriangleMesh mesh, const RepairOptions& options, RepairReport& report) {
  announce("joining open edges");
  stitch(mesh, report);
  announce("filling holes");
  fill_holes(mesh, report);
  announce("searching intersecting facets");
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
    for (TriangleMesh& part : parts) report.moved = std::max(report.moved, resolve_crossings(part, report));
    announce("uniting intersecting parts");
    unite_crossing_parts(parts, report);
  }
  return without_needles(parts, report);
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

void refuse_if_moved_too_far(const RepairReport& report, double max_move) {
  const double share = report.moved / report.box_diagonal;
  if (!(share > max_move)) return;
  throw Error(ErrorCode::invalid,
              concat("surface: the repair would move it by ", rounded(report.moved), ", ", rounded(100 * share),
                     " % of the box diagonal; expected at most ", 100 * max_move, " %"),
              concat("--max-move ", std::ceil(1000 * share) / 1000,
                     " accepts this; --wrap 0.01 wraps it in a new closed surface instead"));
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
  if (soup.facets.empty()) throw Error(ErrorCode::invalid, "surface: no facet has an area; there is nothing to repair");

  TriangleMesh before, after;
  report.box_diagonal = diagonal_of(soup);
  report.distance_error = 1e-4 * report.box_diagonal;
  if (options.wrap > 0) {
    RepairReport ignored;
    before = mesh_of(soup, ignored);
    announce("wrapping");
    const double gap = options.wrap * report.box_diagonal;
    after = wrap(soup, gap, gap / 20);
    report.wrapped = true;
  } else {
    before = mesh_of(std::move(soup), report);
    after = mended(before, options, report);
  }
  if (after.number_of_faces() == 0) throw Error(ErrorCode::invalid, "surface: the repair removed all of it");
  if (!report.wrapped) refuse_if_moved_too_far(report, options.max_move);
  announce("measuring the distance between the old surface and the new");
  report.farthest_new_from_old = farthest(after, before, report.distance_error);
  report.farthest_old_from_new = farthest(before, after, report.distance_error);
  result.surface = neutral(after);
  result.surface.holes = surface.holes;
  result.surface.regions = surface.regions;
  return result;
}

}  // namespace rhoray::preprocess::repair

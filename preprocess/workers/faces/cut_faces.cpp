#include "preprocess/workers/faces/cut_faces.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "formats/base/error.h"
#include "formats/base/vector.h"
#include "preprocess/mesh/inspect/cut_polygon.h"

namespace rhoray::preprocess {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
/// Vertices know their point, faces whether they are outside or in an opening.
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint64_t, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<bool, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::No_constraint_intersection_requiring_constructions_tag>;

using Corners = std::span<const std::uint64_t>;
using Openings = std::multimap<std::uint64_t, std::array<double, 3>>;  // seeds by face

Corners corners_of(const NeutralSurface& surface, std::size_t facet) {
  return Corners(surface.facet_corners)
      .subspan(surface.facet_offsets[facet], surface.facet_offsets[facet + 1] - surface.facet_offsets[facet]);
}

Vec3 vec3_of(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

bool is_finite(const std::array<double, 3>& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

void cut_facet(const NeutralSurface& surface, Corners corners, CutFaces& cut) {
  if (corners.size() < 3) return;
  std::vector<Vec3> places;
  for (const std::uint64_t corner : corners) places.push_back(vec3_of(surface.points[corner]));
  for (const auto& t : cut_polygon(places)) cut.triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
}

/// A coordinate plane that sees a face from its front: two of the three axes, in this order.
struct Projection {
  std::size_t u = 0, v = 1;

  Kernel::Point_2 operator()(const std::array<double, 3>& p) const { return {p[u], p[v]}; }
};

/// The plane in which the outline with the largest area there runs counter-clockwise.
Projection projection_of(const NeutralSurface& surface, const std::vector<Corners>& outlines) {
  Projection projection;
  double largest = 0;
  for (const Corners corners : outlines) {
    Vec3 normal(0, 0, 0);
    const Vec3 first = vec3_of(surface.points[corners[0]]);
    for (std::size_t i = 2; i < corners.size(); ++i)
      normal += (vec3_of(surface.points[corners[i - 1]]) - first).cross(vec3_of(surface.points[corners[i]]) - first);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double area = normal[static_cast<int>(axis)];
      if (!(std::abs(area) > largest)) continue;
      largest = std::abs(area);
      projection = {(axis + 1) % 3, (axis + 2) % 3};
      if (area < 0) std::swap(projection.u, projection.v);
    }
  }
  return projection;
}

/// Marks all faces that are reached from this one without crossing an outline.
void leave_out(const Triangulation& triangulation, Triangulation::Face_handle start) {
  if (start->info()) return;
  start->info() = true;
  std::vector<Triangulation::Face_handle> reached{start};
  while (!reached.empty()) {
    const Triangulation::Face_handle face = reached.back();
    reached.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Triangulation::Face_handle beside = face->neighbor(i);
      if (beside->info() || triangulation.is_constrained({face, i})) continue;
      beside->info() = true;
      reached.push_back(beside);
    }
  }
}

/// Cuts a face of several outlines, or with openings.
void cut_face(const NeutralSurface& surface, const std::vector<Corners>& outlines,
              const std::vector<std::array<double, 3>>& openings, CutFaces& cut) {
  const Projection projection = projection_of(surface, outlines);
  Triangulation triangulation;
  for (const Corners corners : outlines) {
    std::vector<Triangulation::Vertex_handle> ring;
    for (const std::uint64_t corner : corners) {
      ring.push_back(triangulation.insert(projection(surface.points[corner])));
      ring.back()->info() = corner;
    }
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (const auto next = ring[(i + 1) % ring.size()]; next != ring[i])
        triangulation.insert_constraint(ring[i], next);
  }
  if (triangulation.dimension() < 2) return;
  for (const auto face : triangulation.all_face_handles()) face->info() = false;
  leave_out(triangulation, triangulation.infinite_face());
  for (const auto& seed : openings) leave_out(triangulation, triangulation.locate(projection(seed)));
  for (const auto face : triangulation.finite_face_handles())
    if (!face->info())
      cut.triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
}

}  // namespace

CutFaces cut_faces(const NeutralSurface& surface) {
  Openings openings;
  for (const auto& opening : surface.openings) {
    if (!is_finite(opening.seed))
      throw Error(ErrorCode::invalid, "surface: the seed of an opening is not finite", "correct the seeds of openings");
    openings.emplace(opening.face, opening.seed);
  }
  const std::size_t facet_count = surface.facet_offsets.size() - 1;
  const auto face_of = [&](std::size_t facet) {
    return surface.facet_faces.empty() ? facet : surface.facet_faces[facet];
  };
  CutFaces cut;
  for (std::size_t first = 0, next; first < facet_count; first = next) {
    std::vector<Corners> outlines;
    for (next = first; next < facet_count && face_of(next) == face_of(first); ++next) {
      const Corners corners = corners_of(surface, next);
      if (!std::all_of(corners.begin(), corners.end(), [&](auto c) { return is_finite(surface.points[c]); }))
        ++cut.not_finite;
      else if (!corners.empty())
        outlines.push_back(corners);
    }
    std::vector<std::array<double, 3>> seeds;
    const auto [begin, end] = openings.equal_range(face_of(first));
    for (auto at = begin; at != end; ++at) seeds.push_back(at->second);
    if (outlines.size() == 1 && seeds.empty()) {
      cut_facet(surface, outlines.front(), cut);
      continue;
    }
    try {
      if (!outlines.empty()) cut_face(surface, outlines, seeds, cut);
    } catch (const Triangulation::Intersection_of_constraints_exception&) {
      throw Error(ErrorCode::invalid,
                  concat("surface: the outlines of facet ", first, " and of others in the same face cross"),
                  "each face takes outlines that do not cross");
    }
  }
  return cut;
}

}  // namespace rhoray::preprocess

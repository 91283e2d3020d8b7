#include "preprocess/pack_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "preprocess/mesh/inspect/cut_polygon.h"

namespace rhoray::preprocess {
namespace {

using Corners = std::array<std::uint64_t, 3>;  // indices of points

Vec3 point_at(const NeutralSurface& surface, std::uint64_t position) {
  const std::array<double, 3>& p = surface.points[position];
  return {p[0], p[1], p[2]};
}

bool is_finite(const NeutralSurface& surface, std::uint64_t position) {
  const std::array<double, 3>& p = surface.points[position];
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

bool has_area(const NeutralSurface& surface, const Corners& corners) {
  const Vec3 a = point_at(surface, corners[0]);
  const Vec3 normal = (point_at(surface, corners[1]) - a).cross(point_at(surface, corners[2]) - a);
  return normal.x != 0 || normal.y != 0 || normal.z != 0;
}

/// Nested outlines mean holes, which triangles between the corners of each outline would fill.
void refuse_outlines(const NeutralSurface& surface, const std::string& source_name) {
  const auto& faces = surface.facet_faces;
  if (surface.openings.empty() && std::adjacent_find(faces.begin(), faces.end()) == faces.end()) return;
  throw Error(ErrorCode::unsupported,
              concat(source_name, ": has faces of several outlines; expected facets of one outline each"),
              "tetrahedralize reads such faces");
}

/// Triangulates a facet; returns nothing unless all its corners are finite.
std::vector<Corners> triangles_of(const NeutralSurface& surface, std::span<const std::uint64_t> facet) {
  std::vector<Corners> triangles;
  if (facet.size() < 3 || !std::all_of(facet.begin(), facet.end(), [&](auto c) { return is_finite(surface, c); }))
    return triangles;
  std::vector<Vec3> places;
  for (const std::uint64_t corner : facet) places.push_back(point_at(surface, corner));
  for (const auto& cut : cut_polygon(places)) {
    const Corners corners{facet[cut[0]], facet[cut[1]], facet[cut[2]]};
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) triangles.push_back(corners);
  }
  return triangles;
}

/// Assigns indices in the packed file to points, in the order of the source.
Array<std::uint32_t> keep_points(const NeutralSurface& surface, const std::vector<Corners>& triangles,
                                 Array<std::array<double, 3>>& kept) {
  Array<std::uint32_t> positions(surface.points.size(), 0);
  for (const Corners& corners : triangles)
    for (const std::uint64_t corner : corners) positions[corner] = 1;
  for (std::size_t p = 0; p < positions.size(); ++p) {
    if (positions[p] == 0) continue;
    positions[p] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(surface.points[p]);
  }
  return positions;
}

bool are_floats(const Array<std::array<double, 3>>& points) {
  return std::all_of(points.begin(), points.end(), [](const std::array<double, 3>& p) {
    return std::all_of(p.begin(), p.end(), [](double x) {
      return std::abs(x) <= std::numeric_limits<float>::max() && static_cast<double>(static_cast<float>(x)) == x;
    });
  });
}

void require_index(std::uint64_t count, const char* what, const std::string& source_name) {
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::unsupported, concat(source_name, ": ", count, " ", what, "; expected fewer than 2^32"));
}

void note(std::vector<std::string>& notes, std::uint64_t count, const char* one, const char* many, const char* what) {
  if (count != 0) notes.push_back(concat(count, " ", count == 1 ? one : many, " ", what));
}

template <class T>
void write(formats::PackedFileWriter& writer, const char* array, const Array<T>& values) {
  writer.write(array, 0, std::as_bytes(std::span<const T>(values)));
}

Array<std::array<float, 3>> as_floats(const Array<std::array<double, 3>>& points) {
  Array<std::array<float, 3>> floats;
  floats.reserve(points.size());
  for (const auto& p : points)
    floats.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  return floats;
}

}  // namespace

PackSurfaceReport pack_surface(const NeutralSurface& surface, const formats::Destination& destination,
                               const PackSurfaceOptions& options, const Progress& progress) {
  const DefaultFloatingPoint default_floating_point;
  const std::string source_name = options.source_name.empty() ? "surface" : options.source_name;
  refuse_outlines(surface, source_name);
  require_index(surface.points.size(), "points", source_name);
  const std::uint64_t facet_count = surface.facet_offsets.size() - 1;
  require_index(facet_count, "facets", source_name);

  PackSurfaceReport report;
  formats::TriangleMeshDescription& packed = report.description;
  std::vector<Corners> triangles;
  Array<std::uint32_t> ids;
  std::uint64_t cut_count = 0;
  if (progress) progress("cutting facets", 0, 0);
  for (std::uint64_t f = 0; f < facet_count; ++f) {
    const std::uint64_t first = surface.facet_offsets[f], end = surface.facet_offsets[f + 1];
    const std::vector<Corners> of_facet =
        triangles_of(surface, std::span(surface.facet_corners).subspan(first, end - first));
    packed.dropped_facet_count += of_facet.empty() ? 1 : 0;
    cut_count += end - first > 3 && !of_facet.empty() ? 1 : 0;
    for (const Corners& corners : of_facet) {
      packed.flat_triangle_count += has_area(surface, corners) ? 0 : 1;
      triangles.push_back(corners);
      ids.push_back(static_cast<std::uint32_t>(f));
    }
  }
  if (triangles.empty())
    throw Error(ErrorCode::invalid, concat(source_name, ": ", facet_count,
                                           " facets; expected at least one with three different finite corners"));
  require_index(triangles.size(), "triangles", source_name);

  Array<std::array<double, 3>> points;
  const Array<std::uint32_t> positions = keep_points(surface, triangles, points);
  Array<std::array<std::uint32_t, 3>> corners;
  corners.reserve(triangles.size());
  for (const Corners& t : triangles) corners.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});

  const bool single = are_floats(points);
  packed.point_type = single ? formats::ElementType::F32 : formats::ElementType::F64;
  packed.point_count = points.size();
  packed.triangle_count = corners.size();
  for (const auto& p : points) packed.bounds.extendBy(Vec3(p[0], p[1], p[2]));
  packed.has_source_order = cut_count == 0 && packed.dropped_facet_count == 0;
  packed.unused_point_count = surface.points.size() - points.size();
  packed.provenance = {.source_name = options.source_name, .source_checksum = {}, .command = options.command};
  note(report.notes, cut_count, "facet", "facets", "with more than three corners cut into triangles");
  note(report.notes, packed.dropped_facet_count, "facet", "facets",
       "dropped because of a repeated corner or a coordinate that is not finite");
  note(report.notes, packed.flat_triangle_count, "triangle", "triangles", "of zero area kept");
  note(report.notes, packed.unused_point_count, "point", "points", "without a triangle dropped");

  if (progress) progress("writing", 0, 0);
  formats::PackedFileWriter writer(destination, formats::describe(packed), formats::triangle_mesh_arrays(packed),
                                   {.replace_existing = options.replace_existing});
  if (single)
    write(writer, "points", as_floats(points));
  else
    write(writer, "points", points);
  write(writer, "triangles", corners);
  if (!packed.has_source_order) write(writer, "triangle_ids", ids);
  report.file_bytes = writer.commit();
  return report;
}

}  // namespace rhoray::preprocess

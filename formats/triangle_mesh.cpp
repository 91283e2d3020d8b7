#include "formats/triangle_mesh.h"

#include <limits>

#include "formats/base/text.h"
#include "formats/details/deep_checks.h"
#include "formats/details/details.h"
#include "formats/details/scan.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

using details::Json;

// 32-bit indices
constexpr std::uint64_t largest_count = std::numeric_limits<std::uint32_t>::max();

TriangleMeshDescription read_description(const PackedFile& file) {
  if (file.description().kind != TriangleMesh::kind)
    refuse(file.name(), "header, __metadata__, kind", concat("'", file.description().kind, "'"), "'surface'");
  const Json json = details::parse(file);
  const details::Reader reader(json, file.name(), "details");
  TriangleMeshDescription surface;
  surface.length_unit = reader.text("length_unit");
  surface.point_type = reader.element_type("point_type");
  if (surface.point_type != ElementType::F32 && surface.point_type != ElementType::F64)
    reader.refuse_value("point_type", "F32 or F64");
  surface.point_count = reader.count("point_count", 1, largest_count);
  surface.triangle_count = reader.count("triangle_count", 1, largest_count);
  const details::Reader bounds = reader.object("bounds");
  surface.bounds = Box3(bounds.vector("low"), bounds.vector("high"));
  if (surface.bounds.isEmpty()) reader.refuse_value("bounds", "a low corner that is nowhere above the high one");
  surface.has_source_order = !reader.has("order");
  if (!surface.has_source_order && reader.text("order") != "ids") reader.refuse_value("order", "\"ids\"");
  surface.flat_triangle_count = reader.count("flat_triangle_count");
  surface.dropped_facet_count = reader.count("dropped_facet_count");
  surface.unused_point_count = reader.count("unused_point_count");
  surface.provenance = details::read_provenance(reader.object("provenance"));
  return surface;
}

}  // namespace

TriangleMesh::TriangleMesh(PackedFile file, const Watch& watch)
    : file_(std::move(file)), description_(read_description(file_)) {
  const TriangleMeshDescription& d = description_;
  const auto corners = file_.array<std::uint32_t>("triangles", {d.triangle_count, 3});
  if (!d.has_source_order) triangle_ids_ = file_.array<std::uint32_t>("triangle_ids", {d.triangle_count});
  const auto view_points = [&]<class T>(std::span<const std::array<T, 3>>& points) {
    const std::span<const T> coordinates = file_.array<T>("points", {d.point_count, 3});
    details::check_finite(file_, "points", coordinates, watch);
    points = details::grouped<3>(coordinates);
  };
  if (d.point_type == ElementType::F32)
    view_points(floats_);
  else
    view_points(doubles_);
  details::check_below(file_, "triangles", corners, d.point_count, watch);
  triangles_ = details::grouped<3>(corners);
}

std::vector<ArraySpec> triangle_mesh_arrays(const TriangleMeshDescription& d) {
  std::vector<ArraySpec> arrays{{.name = "points", .type = d.point_type, .shape = {d.point_count, 3}},
                                {.name = "triangles", .type = ElementType::U32, .shape = {d.triangle_count, 3}}};
  if (!d.has_source_order)
    arrays.push_back({.name = "triangle_ids", .type = ElementType::U32, .shape = {d.triangle_count}});
  return arrays;
}

FileDescription describe(const TriangleMeshDescription& d) {
  Json json{{"length_unit", d.length_unit},
            {"point_type", std::string(element_name(d.point_type))},
            {"point_count", d.point_count},
            {"triangle_count", d.triangle_count},
            {"bounds",
             {{"low", details::vector_json(d.bounds.min, "bounds.low")},
              {"high", details::vector_json(d.bounds.max, "bounds.high")}}},
            {"flat_triangle_count", d.flat_triangle_count},
            {"dropped_facet_count", d.dropped_facet_count},
            {"unused_point_count", d.unused_point_count},
            {"provenance", details::provenance_json(d.provenance)}};
  if (!d.has_source_order) json["order"] = "ids";
  return {.kind = TriangleMesh::kind, .required = {}, .details = details::dump(json), .minor_version = 3};
}

std::vector<std::string> deep_findings(const TriangleMesh& surface) {
  details::Findings findings;
  const TriangleMeshDescription& d = surface.description();
  Box3 bounds;
  for (std::uint64_t p = 0; p < d.point_count; ++p) {
    const std::array<double, 3> point = surface.point(p);
    bounds.extendBy(Vec3(point[0], point[1], point[2]));
  }
  if (bounds != d.bounds)
    findings.add("bounds that are not those of the points", 0, [&] {
      const auto text = [](const Vec3& v) { return concat("(", v.x, ", ", v.y, ", ", v.z, ")"); };
      return concat(text(bounds.min), " to ", text(bounds.max));
    });
  std::vector<bool> used(d.point_count);
  for (std::uint64_t t = 0; t < d.triangle_count; ++t) {
    const auto& corners = surface.triangles()[t];
    const auto name = [&] { return concat("triangle ", t); };
    for (const std::uint32_t corner : corners) used[corner] = true;
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
      findings.add("a triangle with a corner twice", t, name);
    if (t > 0 && surface.triangle_id(t) < surface.triangle_id(t - 1)) findings.add("triangle ids that fall", t, name);
  }
  for (std::uint64_t p = 0; p < d.point_count; ++p)
    if (!used[p]) findings.add("a point that no triangle has", p, [&] { return concat("point ", p); });
  return findings.sentences();
}

}  // namespace rhoray::formats

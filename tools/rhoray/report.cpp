#include "tools/rhoray/report.h"

#include <algorithm>
#include <cmath>

#include "formats/automatic_isovalue.h"
#include "formats/base/number_text.h"
#include "render/isovalue.h"
#include "render/scene_spec.h"

namespace rhoray::tools {

namespace {

constexpr int shown_percentiles[] = {1, 5, 25, 50, 75, 95, 99};

/// Position of a corner sample in the lattice's frame; bit a of `corner` says at which end of axis
/// a.
Vec3 corner_of(const SampleLattice& lattice, int corner) {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) {
    const bool last = (corner >> axis & 1) != 0;
    const std::vector<double>& table = lattice.axes[static_cast<std::size_t>(axis)];
    if (table.empty())
      p[axis] = last ? static_cast<double>(lattice.sample_count[axis] - 1) : 0;
    else
      p[axis] = last ? table.back() : table.front();
  }
  return p;
}

Json certificate_json(const formats::Certificate& certificate) {
  const auto optional_json = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  return {{"coverage", optional_json(certificate.coverage)},
          {"max_error", certificate.max_error},
          {"rms_error", certificate.rms_error},
          {"max_at", json_of(certificate.max_at)},
          {"point_count", certificate.point_count},
          {"requested_error", optional_json(certificate.requested_error)},
          {"meets_request", certificate.meets_request()}};
}

Json layout_json(const formats::BrickLayout& layout) {
  Json json{{"linear", layout.is_linear()},
            {"brick_edge", layout.brick_edge},
            {"superbrick_edge", json_of(layout.superbrick_edge)},
            {"padded_samples", json_of(layout.padded_count())},
            {"sparse", layout.is_sparse}};
  if (layout.is_sparse) {
    json["stored_bricks"] = layout.stored_brick_count;
    json["bricks"] = volume(layout.brick_count());
  }
  return json;
}

std::string content_of(const formats::GridDescription& grid) {
  const Index3& count = grid.layout.sample_count;
  std::string types;
  for (const formats::FieldSummary& field : grid.fields)
    types += concat(types.empty() ? "" : ", ", formats::element_name(field.type));
  return concat(text_of(count), " = ", grouped(static_cast<std::uint64_t>(volume(count))), " samples ", types);
}

std::string content_of(const formats::ColorGridDescription& grid) {
  const Index3& count = grid.layout.sample_count;
  return concat(text_of(count), " = ", grouped(static_cast<std::uint64_t>(volume(count))), " colours ",
                grid.has_alpha() ? "RGBA" : "RGB");
}

std::string content_of(const formats::TetMeshDescription& mesh) {
  return concat(counted(mesh.cell_count, "tetrahedron", "tetrahedra"), ", ",
                counted(mesh.point_count, "point", "points"), ", ", counted(mesh.fields.size(), "field", "fields"),
                mesh.cell_fields.empty()
                    ? ""
                    : concat(", ", counted(mesh.cell_fields.size(), "field of cells", "fields of cells")));
}

std::string content_of(const formats::TriangleMeshDescription& surface) {
  return concat(counted(surface.triangle_count, "triangle", "triangles"), ", ",
                counted(surface.point_count, "point", "points"));
}

}  // namespace

Json json_of(const Index3& index) {
  return {index.x, index.y, index.z};
}
Json json_of(const Box3& box) {
  return {{"low", json_of(box.min)}, {"high", json_of(box.max)}};
}

Json json_of(const SampleLattice& lattice) {
  const Affine& map = lattice.world_from_grid;
  const std::array<Vec3, 3> axes{map.x_axis, map.y_axis, map.z_axis};
  Json mean = Json::array(), ranges = Json::array(), directions = Json::array();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double unit = axes[axis].length();
    const std::vector<double>& table = lattice.axes[axis];
    Interval<double> range;
    for (std::size_t i = 1; i < table.size(); ++i) range.include((table[i] - table[i - 1]) * unit);
    if (table.empty()) range = {unit, unit};
    mean.push_back(table.empty() ? unit
                                 : (table.back() - table.front()) * unit / static_cast<double>(table.size() - 1));
    ranges.push_back(json_of(range));
    directions.push_back(json_of(axes[axis].normalized()));
  }
  return {{"spacing", mean},
          {"spacing_range", ranges},
          {"origin", json_of(map.point(corner_of(lattice, 0)))},
          {"direction", directions}};
}

Json json_of(const Affine& world_from_grid) {
  const Index3 one(1, 1, 1);
  const std::array<std::vector<double>, 3> even;
  return json_of(SampleLattice{world_from_grid, one, even});
}

Json json_of(const formats::FieldSummary& field) {
  Json json{{"name", field.name},
            {"unit", field.unit},
            {"type", formats::element_name(field.type)},
            {"range", json_of(field.range)},
            {"no_data_count", field.no_data_count},
            {"otsu_threshold", nullptr},
            {"percentiles", Json::object()},
            {"histogram", field.histogram}};
  for (const auto& [label, name] : field.label_names) json["label_names"][concat(label)] = name;
  if (const auto threshold = formats::otsu_threshold(field)) json["otsu_threshold"] = *threshold;
  const auto chosen = formats::automatic_isovalue(field);
  if (chosen && !field.mean_gradient.empty()) {
    const render::Isovalue isovalue = render::choose_isovalue("auto", field);
    json["automatic_isovalue"] = {
        {"value", isovalue.value}, {"from", isovalue.from}, {"other_valleys", chosen->other_valleys}};
  }
  if (!field.range.is_empty())
    for (const int percent : shown_percentiles)
      json["percentiles"][concat(percent)] = formats::percentile(field, percent / 100.0);
  return json;
}

Json json_of(const formats::Provenance& provenance) {
  return {{"source_name", provenance.source_name},
          {"source_checksum", provenance.source_checksum},
          {"command", provenance.command}};
}

Json json_of(const formats::GridDescription& grid) {
  Json fields = Json::array();
  for (std::size_t field = 0; field < grid.fields.size(); ++field) {
    fields.push_back(json_of(grid.fields[field]));
    const auto certificate = grid.certificates.find(field);
    if (certificate != grid.certificates.end()) fields.back()["certificate"] = certificate_json(certificate->second);
  }
  const SampleLattice lattice{grid.world_from_grid, grid.layout.sample_count, grid.axes};
  return {{"samples", json_of(grid.layout.sample_count)},
          {"cells", volume(grid.macro.leaf_count)},
          {"geometry", json_of(lattice)},
          {"length_unit", grid.length_unit},
          {"space", formats::space_word(grid.space)},
          {"box", json_of(bounds_of(lattice))},
          {"layout", layout_json(grid.layout)},
          {"macro_levels", {{"count", grid.macro.level_count}, {"factor", grid.macro.factor}}},
          {"fields", fields},
          {"provenance", json_of(grid.provenance)}};
}

Json json_of(const formats::ColorGridDescription& grid) {
  return {{"texels", json_of(grid.layout.sample_count)}, {"components", grid.has_alpha() ? "RGBA" : "RGB"},
          {"geometry", json_of(grid.world_from_grid)},   {"length_unit", grid.length_unit},
          {"space", formats::space_word(grid.space)},    {"box", json_of(grid.bounds())},
          {"layout", layout_json(grid.layout)},          {"provenance", json_of(grid.provenance)}};
}

Json json_of(const formats::TetMeshDescription& mesh) {
  Json fields = Json::array();
  for (const formats::FieldSummary& field : mesh.fields) fields.push_back(json_of(field));
  Json cell_fields = Json::array();
  for (const formats::FieldSummary& field : mesh.cell_fields) cell_fields.push_back(json_of(field));
  Json json{{"points", mesh.point_count},
            {"cells", mesh.cell_count},
            {"origin", json_of(mesh.origin)},
            {"length_unit", mesh.length_unit}};
  const formats::LeafLattice& lattice = mesh.lattice;
  if (mesh.clusters)
    json["clusters"] = {{"count", formats::cluster_shape(mesh).count(0)},
                        {"size", mesh.clusters->cluster_size},
                        {"vertices", mesh.clusters->vertex_count}};
  else
    json.update(Json{{"leaf_cells",
                      {{"count", json_of(lattice.macro.leaf_count)},
                       {"size", json_of(lattice.leaf_size)},
                       {"items", mesh.leaf_item_count}}},
                     {"macro_levels", {{"count", lattice.macro.level_count}, {"factor", lattice.macro.factor}}}});
  json.update(Json{{"fields", fields},
                   {"cell_fields", cell_fields},
                   {"boundary_faces", mesh.boundary_face_count},
                   {"packing",
                    {{"flipped_cells", mesh.flipped_cell_count},
                     {"flat_cells", mesh.flat_cell_count},
                     {"dropped_cells", mesh.dropped_cell_count},
                     {"unused_points", mesh.unused_point_count}}},
                   {"provenance", json_of(mesh.provenance)}});
  return json;
}

Json json_of(const formats::TriangleMeshDescription& surface) {
  return {{"points", surface.point_count},
          {"triangles", surface.triangle_count},
          {"point_type", formats::element_name(surface.point_type)},
          {"length_unit", surface.length_unit},
          {"box", json_of(surface.bounds)},
          {"packing",
           {{"flat_triangles", surface.flat_triangle_count},
            {"dropped_facets", surface.dropped_facet_count},
            {"unused_points", surface.unused_point_count}}},
          {"provenance", json_of(surface.provenance)}};
}

Box3 bounds_of(const SampleLattice& lattice) {
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) box.extendBy(lattice.world_from_grid.point(corner_of(lattice, corner)));
  return box;
}

std::string content_of(const preprocess::PackReport& packed) {
  return std::visit([](const auto& description) { return content_of(description); }, packed.description);
}

std::string text_of(const Vec3& v) {
  return concat(rounded(v.x), " ", rounded(v.y), " ", rounded(v.z));
}
std::string text_of(const Index3& index) {
  return concat(index.x, " x ", index.y, " x ", index.z);
}

std::string histogram_bars(const formats::FieldSummary& field, std::size_t width) {
  static constexpr const char* blocks[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  const std::size_t bins = field.histogram.size();
  width = std::min(width, bins);
  std::vector<double> counts(width);
  for (std::size_t bin = 0; bin < bins; ++bin) counts[bin * width / bins] += static_cast<double>(field.histogram[bin]);
  const double highest = counts.empty() ? 0 : std::log1p(*std::max_element(counts.begin(), counts.end()));
  std::string bars;
  for (const double count : counts) {
    const double share = highest > 0 ? std::log1p(count) / highest : 0;
    bars += blocks[static_cast<std::size_t>(std::ceil(share * 8))];  // ceil: what is there is seen
  }
  return bars;
}

Json scene_json(const render::SceneSpec& scene_spec, const std::filesystem::path& folder) {
  return Json::parse(render::scene_text(scene_spec, folder));
}

}  // namespace rhoray::tools

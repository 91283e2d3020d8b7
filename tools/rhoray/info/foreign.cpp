#include "tools/rhoray/info/foreign.h"

#include <cmath>
#include <cstring>

#include "formats/base/error.h"
#include "preprocess/components.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/input_file.h"
#include "preprocess/open_vdb.h"

namespace rhoray::tools {

namespace {

constexpr std::size_t bin_count = 256;

/// The work of `summarize` for values that are given one by one: value_at(i) for i below count.
template <class ValueAt>
formats::FieldSummary summarize_each(std::size_t count, const ValueAt& value_at) {
  formats::FieldSummary field;
  for (std::size_t i = 0; i < count; ++i) {
    const double value = value_at(i);
    if (std::isfinite(value))
      field.range.include(value);
    else
      ++field.no_data_count;
  }
  if (field.range.is_empty()) return field;
  field.histogram.assign(bin_count, 0);
  for (std::size_t i = 0; i < count; ++i)
    if (const double value = value_at(i); std::isfinite(value))
      ++field.histogram[formats::histogram_bin(field.range, bin_count, value)];
  return field;
}

Json head(const std::filesystem::path& path, const char* kind) {
  return {{"file", path.string()}, {"kind", kind}, {"packed", false}, {"file_bytes", preprocess::input_bytes(path)}};
}

Json volume_info(const std::filesystem::path& path, const preprocess::PackOptions& pack, bool with_findings) {
  preprocess::ImportVolumeOptions import;
  import.memory_limit_bytes = pack.memory_limit_bytes;
  if (!pack.raw.empty()) import.raw = preprocess::parse_raw_volume(pack.raw);
  import.spacing = pack.spacing, import.origin = pack.origin, import.time = pack.time;
  const preprocess::NeutralVolume volume = preprocess::import_volume(path, import);
  formats::FieldSummary field = formats::with_element_type(volume.type, [&]<class T>(T) {
    return summarize_each(volume.samples.size() / sizeof(T), [&](std::size_t i) {
      T value;
      std::memcpy(&value, volume.samples.data() + i * sizeof(T), sizeof(T));
      return static_cast<double>(value);
    });
  });
  field.name = volume.field_name;
  field.unit = volume.field_unit;
  field.label_names = volume.label_names;
  field.type = volume.type;
  Json json = head(path, "volume");
  json["samples"] = json_of(volume.sample_count);
  const SampleLattice lattice{volume.world_from_grid, volume.sample_count, volume.axes};
  json["geometry"] = json_of(lattice);
  json["length_unit"] = volume.length_unit;
  json["space"] = formats::space_word(volume.space);
  json["box"] = json_of(bounds_of(lattice));
  json["fields"] = Json::array({json_of(field)});
  json["other_fields"] = volume.other_fields;
  json["vectors"] = Json::array();
  for (const preprocess::VectorArray& array : volume.vectors)
    json["vectors"].push_back({{"name", array.name},
                               {"components", array.component_count},
                               {"scalars", preprocess::scalars_text(array.name, array.component_count)}});
  json["memory"] = {{"unpacked_bytes", volume.samples.size()}};
  json["notes"] = volume.notes;
  if (with_findings) json["findings"] = findings_json(preprocess::inspect_volume(volume));
  return json;
}

Json json_of_neutral(const preprocess::NeutralField& values, const char* stands) {
  formats::FieldSummary field = summarize(values.values);
  field.name = values.name;
  field.unit = values.unit;
  field.label_names = values.label_names;
  field.type = values.was_single_precision ? formats::ElementType::F32 : formats::ElementType::F64;
  Json json = json_of(field);
  json["at"] = stands;
  json["components"] = values.component_count;
  return json;
}

Box3 box_of(std::span<const std::array<double, 3>> points) {
  Box3 box;
  for (const auto& p : points)
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) box.extendBy(Vec3(p[0], p[1], p[2]));
  return box;
}

Json mesh_info(const std::filesystem::path& path, const preprocess::PackOptions& pack, bool with_findings) {
  const preprocess::NeutralMesh mesh =
      preprocess::import_mesh(path, {.time = pack.time, .memory_limit_bytes = pack.memory_limit_bytes});
  Json json = head(path, "mesh");
  json["points"] = mesh.points.size();
  json["cells"] = mesh.cells.size();
  json["length_unit"] = mesh.length_unit;
  if (!mesh.points.empty()) json["box"] = json_of(box_of(mesh.points));
  json["fields"] = Json::array();
  std::uint64_t value_count = 0;
  for (const auto& field : mesh.point_fields) {
    json["fields"].push_back(json_of_neutral(field, "points"));
    value_count += field.values.size();
  }
  for (const auto& field : mesh.cell_fields) {
    json["fields"].push_back(json_of_neutral(field, "cells"));
    value_count += field.values.size();
  }
  json["memory"] = {{"unpacked_bytes", sizeof(mesh.points[0]) * mesh.points.size() +
                                           sizeof(mesh.cells[0]) * mesh.cells.size() + sizeof(double) * value_count}};
  json["notes"] = mesh.notes;
  if (with_findings) json["findings"] = findings_json(preprocess::inspect_mesh(mesh));
  return json;
}

Json json_of_grid(const preprocess::VdbGridFacts& grid) {
  Json json{{"name", grid.name},
            {"value_type", grid.value_type},
            {"class", grid.grid_class},
            {"active_voxels", grid.active_voxel_count}};
  if (grid.active_voxel_count != 0) {
    json["first_active"] = json_of(grid.first_active);
    json["last_active"] = json_of(grid.last_active);
  }
  if (grid.background) json["background"] = *grid.background;
  json["map_type"] = grid.map_type;
  if (grid.world_from_index) json["geometry"] = json_of(*grid.world_from_index);
  json["metadata"] = Json::object();
  for (const auto& [key, value] : grid.metadata) json["metadata"][key] = value;
  return json;
}

/// What an OpenVDB file holds, grid by grid, of whatever kind; read in a process of its own.
Json vdb_info(const std::filesystem::path& path, std::uint64_t memory_limit_bytes) {
  const std::vector<preprocess::VdbGridFacts> grids = preprocess::inspect_vdb(path, memory_limit_bytes);
  Json json{{"file", path.string()},  {"kind", "vdb"},
            {"packed", false},        {"file_bytes", std::filesystem::file_size(path)},
            {"length_unit", ""},      {"grids", Json::array()},
            {"fields", Json::array()}};
  for (const preprocess::VdbGridFacts& grid : grids) {
    json["grids"].push_back(json_of_grid(grid));
    if (grid.field) json["fields"].push_back(json_of(*grid.field));
    if (grid.field && grid.world_from_index && !json.contains("geometry"))
      json["geometry"] = json_of(*grid.world_from_index);
  }
  return json;
}

/// Faults are looked for in the grid that is shown by default.
Json vdb_with_findings(const std::filesystem::path& path, std::uint64_t memory_limit_bytes, bool with_findings) {
  Json json = vdb_info(path, memory_limit_bytes);
  if (!with_findings || json["fields"].empty()) return json;
  preprocess::ImportVolumeOptions import;
  import.memory_limit_bytes = memory_limit_bytes;
  json["findings"] = findings_json(preprocess::inspect_volume(preprocess::import_volume(path, import)));
  return json;
}

Json surface_info(const std::filesystem::path& path, std::uint64_t memory_limit_bytes) {
  const preprocess::NeutralSurface surface =
      preprocess::import_surface(path, {}, {.memory_limit_bytes = memory_limit_bytes});
  Json json = head(path, "surface");
  json["points"] = surface.points.size();
  json["facets"] = surface.facet_offsets.size() - 1;
  json["holes"] = surface.holes.size();
  json["regions"] = surface.regions.size();
  json["has_point_sizes"] = !surface.point_sizes.empty();
  json["length_unit"] = "";
  if (!surface.points.empty()) json["box"] = json_of(box_of(surface.points));
  json["memory"] = {
      {"unpacked_bytes", sizeof(surface.points[0]) * surface.points.size() +
                             sizeof(std::uint64_t) * (surface.facet_corners.size() + surface.facet_offsets.size())}};
  json["notes"] = surface.notes;
  return json;
}

}  // namespace

Json findings_json(const std::vector<preprocess::Finding>& findings) {
  Json list = Json::array();
  for (const preprocess::Finding& finding : findings)
    list.push_back({{"name", finding.name},
                    {"count", finding.count},
                    {"first", finding.first_ids},
                    {"of", finding.thing},
                    {"packing", finding.packing}});
  return list;
}

formats::FieldSummary summarize(std::span<const double> values) {
  return summarize_each(values.size(), [&](std::size_t i) { return values[i]; });
}

Json foreign_info(const std::filesystem::path& path, const preprocess::PackOptions& pack, bool with_findings) {
  const std::uint64_t memory_limit_bytes = pack.memory_limit_bytes;
  if (!preprocess::option_words(pack).empty()) preprocess::check_pack(path, pack);
  if (!pack.raw.empty()) return volume_info(path, pack, with_findings);
  if (preprocess::is_vdb(path)) return vdb_with_findings(path, memory_limit_bytes, with_findings);
  switch (preprocess::foreign_kind(path)) {
    case preprocess::ForeignKind::volume:
      return volume_info(path, pack, with_findings);
    case preprocess::ForeignKind::mesh:
      return mesh_info(path, pack, with_findings);
    case preprocess::ForeignKind::surface:
      return surface_info(path, memory_limit_bytes);
    case preprocess::ForeignKind::unknown:
      break;
  }
  const std::string advice = preprocess::advice_on(path);
  throw Error(ErrorCode::unsupported, preprocess::unsupported_type(path),
              !advice.empty()
                  ? advice
                  : concat("supported: .rho; volumes ", preprocess::extensions_of(preprocess::ForeignKind::volume),
                           "; meshes ", preprocess::extensions_of(preprocess::ForeignKind::mesh), "; surfaces ",
                           preprocess::extensions_of(preprocess::ForeignKind::surface)));
}

}  // namespace rhoray::tools

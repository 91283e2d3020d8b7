#include "formats/tet_mesh.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <set>

#include "formats/base/bytes.h"
#include "formats/base/parallel.h"
#include "formats/details/details.h"
#include "formats/details/scan.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

using details::check_below;
using details::check_finite;
using details::first_bad;
using details::grouped;
using details::Json;
using details::scan_piece;

constexpr std::string_view mesh_kind = "tets";
constexpr std::string_view clusters_feature = "cell-clusters";
// order of cells; the source's order has no name in the file
constexpr std::string_view curve_order = "curve";
constexpr std::uint64_t largest_count =
    std::numeric_limits<std::uint32_t>::max();  // of points and cells: 32-bit indices

// ---- description --------------------------------------------------------------------------------

LeafLattice read_lattice(const details::Reader& reader) {
  LeafLattice lattice;
  lattice.low = reader.vector("low");
  lattice.leaf_size = reader.vector("leaf_size");
  if (!(lattice.leaf_size.x > 0 && lattice.leaf_size.y > 0 && lattice.leaf_size.z > 0))
    reader.refuse_value("leaf_size", "three positive numbers");
  lattice.macro = details::read_macro(reader, reader.index("leaf_count", 1, details::largest_axis));
  const Vec3 high = lattice.low + lattice.leaf_size * Vec3(lattice.macro.leaf_count);
  if (!(std::isfinite(high.x) && std::isfinite(high.y) && std::isfinite(high.z)))
    reader.refuse_value("leaf_size", "a lattice whose far corner is finite");
  return lattice;
}

std::vector<FieldSummary> read_fields(const details::Reader& reader, const std::string& key) {
  std::vector<FieldSummary> fields;
  std::set<std::string> names;
  for (const details::Reader& one : reader.objects(key)) {
    fields.push_back(details::read_field(one));
    if (!names.insert(fields.back().name).second) one.refuse_value("name", "a name that no other field has");
    if (fields.back().type != ElementType::F32 && fields.back().type != ElementType::F64)
      one.refuse_value("type", "F32 or F64");
  }
  if (fields.empty()) reader.refuse_value(key, "at least one field");
  return fields;
}

ClusterDescription read_clusters(const details::Reader& reader) {
  ClusterDescription clusters;
  clusters.cluster_size = reader.count("size", 1, ClusterShape::largest_cell_count);
  if (!std::has_single_bit(clusters.cluster_size)) reader.refuse_value("size", "a power of two");
  clusters.vertex_count = reader.count("vertex_count", 1);
  clusters.box_unit = reader.number("box_unit", 0);
  int exponent = 0;
  if (std::frexp(clusters.box_unit, &exponent) != 0.5) reader.refuse_value("box_unit", "a power of two");
  return clusters;
}

bool requires_clusters(const PackedFile& file) {
  const std::vector<std::string>& required = file.description().required;
  return std::find(required.begin(), required.end(), clusters_feature) != required.end();
}

TetMeshDescription read_description(const PackedFile& file) {
  if (file.description().kind != mesh_kind)
    refuse(file.name(), "header, __metadata__, kind", concat("'", file.description().kind, "'"), "'tets'");
  const Json json = details::parse(file);
  const details::Reader reader(json, file.name(), "details");
  TetMeshDescription description;
  description.origin = reader.vector("origin");
  description.length_unit = reader.text("length_unit");
  description.point_count = reader.count("point_count", 1, largest_count);
  description.cell_count = reader.count("cell_count", 1, largest_count);
  description.fields = read_fields(reader, "fields");
  if (reader.has("cell_fields")) description.cell_fields = read_fields(reader, "cell_fields");
  description.lattice = read_lattice(reader.object("lattice"));
  if (requires_clusters(file))
    description.clusters = read_clusters(reader.object("clusters"));
  else
    description.leaf_item_count = reader.count("leaf_item_count");
  if (reader.has("boundary_face_count"))
    description.boundary_face_count = reader.count("boundary_face_count", 1, 4 * description.cell_count);
  description.in_source_order = !reader.has("order");
  if (!description.in_source_order && reader.text("order") != curve_order) reader.refuse_value("order", "\"curve\"");
  description.flipped_cell_count = reader.count("flipped_cell_count");
  description.flat_cell_count = reader.count("flat_cell_count");
  description.dropped_cell_count = reader.count("dropped_cell_count");
  description.unused_point_count = reader.count("unused_point_count");
  description.provenance = details::read_provenance(reader.object("provenance"));
  return description;
}

// ---- the scan at opening ------------------------------------------------------------------------

void check_offsets(const PackedFile& file, std::string_view array, std::span<const std::uint64_t> offsets,
                   std::uint64_t item_count, const Watch& watch) {
  if (offsets.front() != 0) refuse(file.name(), concat("array '", array, "', element 0"), concat(offsets.front()), "0");
  if (offsets.back() != item_count)
    refuse(file.name(), concat("array '", array, "', element ", offsets.size() - 1), concat(offsets.back()),
           concat(item_count, ", the number of items"));
  const auto is_bad = [&](std::uint64_t first, std::uint64_t last) {
    std::uint64_t falls = 0;
    for (std::uint64_t i = first; i < last; ++i) falls += offsets[i + 1] < offsets[i] ? 1 : 0;
    return falls != 0;
  };
  if (const auto bad = first_bad(array, offsets.size() - 1, watch, is_bad))
    refuse(file.name(), concat("array '", array, "', element ", *bad + 1), concat(offsets[*bad + 1]),
           concat("at least ", offsets[*bad], ", the one before"));
}

/// Readers keep the vertices of a cluster in arrays of this size, and a corner is a one-byte index.
constexpr std::uint64_t largest_table = 4 * ClusterShape::largest_cell_count;

void check_tables(const PackedFile& file, const CellClustersView& clusters, const Watch& watch) {
  const auto is_bad = [&](std::uint64_t first, std::uint64_t last) {
    std::uint64_t largest = 0;
    for (std::uint64_t cluster = first; cluster < last; ++cluster)
      largest = std::max<std::uint64_t>(largest, clusters.table(cluster).size());
    return largest > largest_table;
  };
  if (const auto bad = first_bad("cluster.offsets", clusters.cluster_count(), watch, is_bad))
    refuse(file.name(), concat("array 'cluster.offsets', cluster ", *bad),
           concat("a table of ", clusters.table(*bad).size(), " vertices"),
           concat("at most ", largest_table, " vertices"));
}

/// Checks that corners lie in the table of their cluster.
void check_corners(const PackedFile& file, const CellClustersView& clusters, const Watch& watch) {
  const auto largest_corner = [&](std::uint64_t cluster) {
    std::uint8_t largest = 0;
    for (std::uint64_t cell = clusters.first_cell(cluster); cell < clusters.end_cell(cluster); ++cell)
      for (const std::uint8_t corner : clusters.corners[cell]) largest = std::max(largest, corner);
    return largest;
  };
  const auto is_bad = [&](std::uint64_t first, std::uint64_t last) {
    std::uint64_t bad = 0;
    for (std::uint64_t cluster = first; cluster < last; ++cluster)
      bad += largest_corner(cluster) >= clusters.table(cluster).size() ? 1 : 0;
    return bad != 0;
  };
  if (const auto bad = first_bad("cluster.corners", clusters.cluster_count(), watch, is_bad))
    refuse(file.name(), concat("array 'cluster.corners', cluster ", *bad), concat(+largest_corner(*bad)),
           concat("positions in its table of ", clusters.table(*bad).size(), " vertices"));
}

std::optional<std::size_t> place_of(std::string_view name, const std::vector<FieldSummary>& fields) {
  for (std::size_t field = 0; field < fields.size(); ++field)
    if (fields[field].name == name) return field;
  return std::nullopt;
}

std::uint64_t leaf_count_of(const TetMeshDescription& description) {
  return static_cast<std::uint64_t>(volume(description.lattice.macro.leaf_count));
}

}  // namespace

TetMesh::TetMesh(PackedFile file, const Watch& watch) : file_(std::move(file)), description_(read_description(file_)) {
  const TetMeshDescription& d = description_;
  const std::span<const double> coordinates = file_.array<double>("points", {d.point_count, 3});
  if (has_clusters())
    view_clusters(watch);
  else
    view_leaf_lists(watch);
  if (!d.in_source_order) point_ranks_ = file_.array<std::uint32_t>("point_ranks", {d.point_count});
  if (file_.has("cell_ids") || d.dropped_cell_count != 0 || !d.in_source_order)
    cell_ids_ = file_.array<std::uint32_t>("cell_ids", {d.cell_count});
  for (std::size_t field = 0; field < d.fields.size(); ++field)
    with_element_type(d.fields[field].type, [&](auto zero) {
      using T = decltype(zero);
      values<T>(field);
      if (!has_clusters()) macro_levels<T>(field);
    });
  for (std::size_t field = 0; field < d.cell_fields.size(); ++field)
    with_element_type(d.cell_fields[field].type, [&](auto zero) { cell_values<decltype(zero)>(field); });

  if (d.boundary_face_count != 0) view_boundary(watch);

  check_finite<double>(file_, "points", coordinates, watch);
  check_below(file_, "point_ranks", point_ranks_, d.point_count, watch);
  points_ = grouped<3>(coordinates);
}

void TetMesh::view_boundary(const Watch& watch) {
  boundary_ = file_.array<std::uint64_t>("boundary", {description_.boundary_face_count});
  details::check_rising(file_, "boundary", boundary_, 4 * description_.cell_count, watch);
}

void TetMesh::view_leaf_lists(const Watch& watch) {
  const TetMeshDescription& d = description_;
  const std::span<const std::uint32_t> vertices = file_.array<std::uint32_t>("cells", {d.cell_count, 4});
  leaf_lists_.offsets = file_.array<std::uint64_t>("leaf.offsets", {leaf_count_of(d) + 1});
  leaf_lists_.items = file_.array<std::uint32_t>("leaf.items", {d.leaf_item_count});
  // if the description says 0, the shape check accepts any size
  if (leaf_lists_.items.size() != d.leaf_item_count)
    refuse(file_.name(), "array 'leaf.items'", concat(leaf_lists_.items.size(), " elements"), "none");
  check_below(file_, "cells", vertices, d.point_count, watch);
  check_offsets(file_, "leaf.offsets", leaf_lists_.offsets, d.leaf_item_count, watch);
  check_below(file_, "leaf.items", leaf_lists_.items, d.cell_count, watch);
  cells_ = grouped<4>(vertices);
}

void TetMesh::view_clusters(const Watch& watch) {
  const TetMeshDescription& d = description_;
  clusters_.shape = cluster_shape(d);
  clusters_.box_unit = d.clusters->box_unit;
  clusters_.table_starts = file_.array<std::uint64_t>("cluster.offsets", {clusters_.cluster_count() + 1});
  clusters_.tables = file_.array<std::uint32_t>("cluster.vertices", {d.clusters->vertex_count});
  clusters_.corners = grouped<4>(file_.array<std::uint8_t>("cluster.corners", {d.cell_count, 4}));
  clusters_.boxes = view_cluster_boxes(file_, clusters_.shape);
  check_offsets(file_, "cluster.offsets", clusters_.table_starts, d.clusters->vertex_count, watch);
  check_below(file_, "cluster.vertices", clusters_.tables, d.point_count, watch);
  check_tables(file_, clusters_, watch);
  check_corners(file_, clusters_, watch);
  for (std::size_t field = 0; field < d.fields.size(); ++field)
    if (d.fields[field].type == ElementType::F32)
      cluster_ranges<float>(field);
    else
      cluster_ranges<double>(field);
}

std::optional<std::size_t> TetMesh::find_field(std::string_view name) const {
  return place_of(name, description_.fields);
}

std::optional<std::size_t> TetMesh::find_cell_field(std::string_view name) const {
  return place_of(name, description_.cell_fields);
}

ClusterShape cluster_shape(const TetMeshDescription& description) {
  return {.cell_count = description.cell_count, .cluster_size = description.clusters->cluster_size};
}

std::vector<ArraySpec> tet_mesh_arrays(const TetMeshDescription& description) {
  using enum ElementType;
  std::vector<ArraySpec> arrays;
  if (description.clusters) {
    const ClusterShape shape = cluster_shape(description);
    arrays = cluster_box_arrays(shape);
    arrays.push_back({.name = "cluster.offsets", .type = U64, .shape = {shape.count(0) + 1}});
    arrays.push_back({.name = "cluster.vertices", .type = U32, .shape = {description.clusters->vertex_count}});
    arrays.push_back({.name = "cluster.corners", .type = U8, .shape = {description.cell_count, 4}});
  } else {
    arrays.push_back({.name = "leaf.offsets", .type = U64, .shape = {leaf_count_of(description) + 1}});
    arrays.push_back({.name = "leaf.items", .type = U32, .shape = {description.leaf_item_count}});
  }
  arrays.push_back({.name = "points", .type = F64, .shape = {description.point_count, 3}});
  if (!description.clusters) arrays.push_back({.name = "cells", .type = U32, .shape = {description.cell_count, 4}});
  if (description.boundary_face_count != 0)
    arrays.push_back({.name = "boundary", .type = U64, .shape = {description.boundary_face_count}});
  if (description.dropped_cell_count != 0 || !description.in_source_order)
    arrays.push_back({.name = "cell_ids", .type = U32, .shape = {description.cell_count}});
  if (!description.in_source_order)
    arrays.push_back({.name = "point_ranks", .type = U32, .shape = {description.point_count}});
  for (std::size_t field = 0; field < description.fields.size(); ++field) {
    const ElementType type = description.fields[field].type;
    for (ArraySpec& level : description.clusters
                                ? cluster_range_arrays(cluster_shape(description), field, type)
                                : macro_arrays(description.lattice.macro, 0, type, concat("range.", field, ".")))
      arrays.push_back(std::move(level));
    arrays.push_back({.name = concat("field.", field), .type = type, .shape = {description.point_count}});
  }
  for (std::size_t field = 0; field < description.cell_fields.size(); ++field)
    arrays.push_back({.name = concat("cell_field.", field),
                      .type = description.cell_fields[field].type,
                      .shape = {description.cell_count}});
  return arrays;
}

namespace {

/// The first version that has all that the file uses.
int first_minor_version(const TetMeshDescription& description) {
  for (const std::vector<FieldSummary>* fields : {&description.fields, &description.cell_fields})
    for (const FieldSummary& field : *fields)
      if (!field.label_names.empty()) return 8;
  if (description.boundary_face_count != 0 || !description.cell_fields.empty()) return 7;
  return description.clusters || !description.in_source_order ? 2 : 0;
}

}  // namespace

FileDescription describe(const TetMeshDescription& description) {
  const LeafLattice& lattice = description.lattice;
  Json lattice_json = details::macro_json(lattice.macro);
  lattice_json["leaf_count"] = details::index_json(lattice.macro.leaf_count);
  lattice_json["low"] = details::vector_json(lattice.low, "lattice.low");
  lattice_json["leaf_size"] = details::vector_json(lattice.leaf_size, "lattice.leaf_size");
  Json fields = Json::array();
  for (const FieldSummary& field : description.fields) fields.push_back(details::field_json(field));
  Json json{{"origin", details::vector_json(description.origin, "origin")},
            {"length_unit", description.length_unit},
            {"point_count", description.point_count},
            {"cell_count", description.cell_count},
            {"fields", fields},
            {"lattice", lattice_json}};
  if (description.clusters)
    json["clusters"] = {{"size", description.clusters->cluster_size},
                        {"vertex_count", description.clusters->vertex_count},
                        {"box_unit", details::number_json(description.clusters->box_unit, "clusters.box_unit")}};
  else
    json["leaf_item_count"] = description.leaf_item_count;
  json.update({{"flipped_cell_count", description.flipped_cell_count},
               {"flat_cell_count", description.flat_cell_count},
               {"dropped_cell_count", description.dropped_cell_count},
               {"unused_point_count", description.unused_point_count},
               {"provenance", details::provenance_json(description.provenance)}});
  if (!description.in_source_order) json["order"] = curve_order;
  for (const FieldSummary& field : description.cell_fields) json["cell_fields"].push_back(details::field_json(field));
  if (description.boundary_face_count != 0) json["boundary_face_count"] = description.boundary_face_count;
  return {.kind = std::string(mesh_kind),
          .required = description.clusters ? std::vector{std::string(clusters_feature)} : std::vector<std::string>{},
          .details = details::dump(json),
          .minor_version = first_minor_version(description)};
}

}  // namespace rhoray::formats

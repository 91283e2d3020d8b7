#include "preprocess/pack_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/mesh_boundary.h"
#include "preprocess/mesh/build_clusters.h"
#include "preprocess/mesh/inspect/choose_fields.h"
#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/mesh/leaf_lists/build_leaf_lists.h"
#include "preprocess/mesh/leaf_lists/choose_lattice.h"
#include "preprocess/mesh/order_cells.h"
#include "preprocess/values/build_levels.h"
#include "preprocess/values/leaf_ranges.h"
#include "preprocess/values/summarize.h"

namespace rhoray::preprocess {
namespace {

/// At least one leaf cell: the product may be less for few tetrahedra.
double wanted_leaf_cells(const PackMeshOptions& options, std::size_t cell_count) {
  const double share = options.leaf_cells_per_tetrahedron;
  if (!std::isfinite(share) || share <= 0)
    throw Error(ErrorCode::usage, concat("leaf cells per tetrahedron: found ", share, "; expected a number above 0"));
  if (options.leaf_cell_count > 0) return static_cast<double>(options.leaf_cell_count);
  return std::max(1.0, share * static_cast<double>(cell_count));
}

/// Indices of the cells in the source file.
Array<std::uint32_t> cell_ids(const NeutralMesh& mesh, const CleanMesh& clean, const std::string& source_name) {
  Array<std::uint32_t> ids;
  ids.reserve(clean.source_cells.size());
  for (const std::uint64_t cell : clean.source_cells) {
    const std::uint64_t id = mesh.cell_ids.empty() ? cell : mesh.cell_ids[cell];
    if (id > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::unsupported, concat(source_name, ", cell ", id, ": expected a position below 2^32"));
    ids.push_back(static_cast<std::uint32_t>(id));
  }
  return ids;
}

formats::FieldSummary summary_of(const ScalarField& field) {
  formats::FieldSummary summary = std::visit(
      [&]<class T>(const Array<T>& values) { return summarize(std::span<const T>(values), field.name, field.unit); },
      field.values);
  summary.label_names = field.label_names;
  return summary;
}

void check_cluster_size(const PackMeshOptions& options) {
  if (std::has_single_bit(options.cluster_size) && options.cluster_size <= formats::ClusterShape::largest_cell_count)
    return;
  throw Error(ErrorCode::usage,
              concat("cells of a cluster: found ", options.cluster_size, "; expected a power of two, at most ",
                     formats::ClusterShape::largest_cell_count));
}

/// Fills everything but the counts of the structure.
formats::TetMeshDescription description_of(const NeutralMesh& mesh, const CleanMesh& clean, const ChosenFields& fields,
                                           const PackMeshOptions& options) {
  formats::TetMeshDescription packed;
  packed.origin = clean.origin;
  packed.length_unit = mesh.length_unit;
  packed.point_count = clean.points.size();
  packed.cell_count = clean.cells.size();
  for (const ScalarField& field : fields.of_points) packed.fields.push_back(summary_of(field));
  for (const ScalarField& field : fields.of_cells) packed.cell_fields.push_back(summary_of(field));
  packed.lattice = choose_lattice(clean.box, {.leaf_cell_count = wanted_leaf_cells(options, clean.cells.size()),
                                              .macro_factor = options.macro_factor,
                                              .macro_level_count = options.macro_level_count});
  packed.in_source_order = false;
  packed.flipped_cell_count = clean.flipped_cell_count;
  packed.flat_cell_count = clean.flat_cell_count;
  packed.dropped_cell_count = clean.dropped_cell_count;
  packed.unused_point_count = clean.unused_point_count;
  packed.provenance = {.source_name = options.source_name, .source_checksum = {}, .command = options.command};
  return packed;
}

std::uint64_t bytes_of(const std::vector<formats::ArraySpec>& arrays) {
  std::uint64_t bytes = 0;
  for (const formats::ArraySpec& array : arrays) {
    std::uint64_t size = formats::element_bytes(array.type);
    for (const std::uint64_t count : array.shape) size *= count;
    bytes += size;
  }
  return bytes;
}

/// Writes arrays in pieces, so that progress is reported.
class MeteredWriter {
 public:
  MeteredWriter(formats::PackedFileWriter& writer, const Progress& progress, std::uint64_t bytes)
      : writer_(writer), meter_(progress, "writing (bytes)", bytes) {}

  template <class T>
  void write(const std::string& array, std::span<const T> values) {
    constexpr std::size_t piece_bytes = std::size_t{16} << 20;
    const std::span<const std::byte> bytes = std::as_bytes(values);
    for (std::size_t at = 0; at < bytes.size(); at += piece_bytes) {
      const std::span<const std::byte> piece = bytes.subspan(at, std::min(piece_bytes, bytes.size() - at));
      writer_.write(array, at, piece);
      meter_.add(piece.size());
    }
  }

 private:
  formats::PackedFileWriter& writer_;
  ProgressMeter meter_;
};

/// Either leaf lists or clusters; one of them is set.
struct Structure {
  std::optional<LeafLists> lists;
  std::optional<Clusters> clusters;
};

/// Builds the structure and completes its description.
Structure build_structure(const CleanMesh& clean, const PackMeshOptions& options, const Progress& progress,
                          formats::TetMeshDescription& packed) {
  Structure structure;
  if (options.structure == MeshStructure::leaves) {
    structure.lists = build_leaf_lists(clean.points, clean.cells, packed.lattice, progress);
    packed.leaf_item_count = structure.lists->items.size();
  } else {
    structure.clusters = build_clusters(clean.points, clean.cells, options.cluster_size, progress);
    packed.clusters = {.cluster_size = options.cluster_size,
                       .vertex_count = structure.clusters->tables.size(),
                       .box_unit = structure.clusters->box_unit};
  }
  return structure;
}

void write_structure(MeteredWriter& writer, const Structure& structure, const CleanMesh& clean) {
  if (structure.lists) {
    writer.write<std::array<std::uint32_t, 4>>("cells", clean.cells);
    writer.write<std::uint64_t>("leaf.offsets", structure.lists->offsets);
    writer.write<std::uint32_t>("leaf.items", structure.lists->items);
    return;
  }
  const Clusters& clusters = *structure.clusters;
  writer.write<std::uint64_t>("cluster.offsets", clusters.table_starts);
  writer.write<std::uint32_t>("cluster.vertices", clusters.tables);
  writer.write<std::array<std::uint8_t, 4>>("cluster.corners", clusters.corners);
  for (std::size_t level = 0; level < clusters.boxes.size(); ++level)
    writer.write<formats::BoxBlock>(concat("cluster.boxes.", level), clusters.boxes[level]);
}

template <class Level>
void write_ranges(MeteredWriter& writer, std::size_t field, const std::vector<Level>& levels) {
  for (std::size_t level = 0; level < levels.size(); ++level)
    writer.write(concat("range.", field, ".", level), std::span<const typename Level::value_type>(levels[level]));
}

/// Writes the field's values and its intervals on every level.
template <class T>
void write_field(MeteredWriter& writer, std::size_t field, const Array<T>& values, const CleanMesh& clean,
                 const Structure& structure, const formats::MacroShape& shape) {
  const std::span<const T> of_points(values);
  writer.write(concat("field.", field), of_points);
  if (structure.clusters)
    return write_ranges(writer, field, build_cluster_ranges(clean.cells, of_points, structure.clusters->shape));
  Levels<T> levels(1, build_leaf_ranges(clean.cells, of_points, structure.lists->view()));
  add_levels_above_leaves(levels, shape);
  write_ranges(writer, field, levels);
}

}  // namespace

namespace {

PackMeshReport write_mesh(const NeutralMesh& mesh, const formats::Destination& destination,
                          const PackMeshOptions& options, const Progress& progress) {
  const std::string source_name = options.source_name.empty() ? "mesh" : options.source_name;
  check_cluster_size(options);
  ProgressMeter inspecting(progress, "inspecting the mesh", 2);
  CleanMesh clean = clean_mesh(mesh, source_name);
  const Array<std::uint32_t> point_ranks = order_cells(clean);
  inspecting.add(1);
  PackMeshReport report;
  report.notes = clean.notes;
  const ChosenFields fields =
      choose_fields(mesh, clean, options.fields, options.cells_to_points, source_name, report.notes);
  const Array<std::uint32_t> ids = cell_ids(mesh, clean, source_name);
  formats::TetMeshDescription& packed = report.description;
  packed = description_of(mesh, clean, fields, options);
  for (const formats::FieldSummary& field : packed.fields)
    note_no_data(field.name, field.no_data_count, "are not drawn", report.notes);
  inspecting.add(1);

  const Structure structure = build_structure(clean, options, progress, packed);
  const formats::FaceNumbers boundary = formats::boundary_faces(clean.cells, clean.points.size());
  packed.boundary_face_count = boundary.size();
  const std::vector<formats::ArraySpec> arrays = formats::tet_mesh_arrays(packed);
  formats::PackedFileWriter file(destination, formats::describe(packed), arrays,
                                 {.replace_existing = options.replace_existing});
  MeteredWriter writer(file, progress, bytes_of(arrays));
  writer.write<std::array<double, 3>>("points", clean.points);
  writer.write<std::uint32_t>("cell_ids", ids);
  writer.write<std::uint32_t>("point_ranks", point_ranks);
  if (!boundary.empty()) writer.write<std::uint64_t>("boundary", boundary);
  write_structure(writer, structure, clean);
  for (std::size_t f = 0; f < fields.of_points.size(); ++f)
    std::visit([&](const auto& values) { write_field(writer, f, values, clean, structure, packed.lattice.macro); },
               fields.of_points[f].values);
  for (std::size_t f = 0; f < fields.of_cells.size(); ++f)
    std::visit(
        [&]<class T>(const Array<T>& values) { writer.write(concat("cell_field.", f), std::span<const T>(values)); },
        fields.of_cells[f].values);
  ProgressMeter sealing(progress, "sealing", 1);
  report.file_bytes = file.commit();
  sealing.add(1);
  return report;
}

}  // namespace

PackMeshReport pack_mesh(const NeutralMesh& mesh, const formats::Destination& destination,
                         const PackMeshOptions& options, const Progress& progress) {
  const DefaultFloatingPoint default_floating_point;
  return write_mesh(mesh, destination, options, progress);
}

}  // namespace rhoray::preprocess

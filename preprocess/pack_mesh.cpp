#include "preprocess/pack_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <variant>

#include "formats/base/trouble.h"
#include "preprocess/cell_order/order_cells.h"
#include "preprocess/inspect/choose_fields.h"
#include "preprocess/inspect/clean_mesh.h"
#include "preprocess/inspect/summarize.h"
#include "preprocess/leaf_lists/build_leaf_lists.h"
#include "preprocess/leaf_lists/choose_lattice.h"
#include "preprocess/macro_levels/build_levels.h"
#include "preprocess/macro_levels/leaf_ranges.h"

namespace rhoray::preprocess {
namespace {

/// At least one leaf cell: a share of few tetrahedra may come out below.
double wanted_leaf_cells(const PackMeshOptions& options, std::size_t cell_count) {
  const double share = options.leaf_cells_per_tetrahedron;
  if (!std::isfinite(share) || share <= 0)
    throw Error(Trouble::usage, concat("leaf cells per tetrahedron: found ", share, "; expected a number above 0"));
  if (options.leaf_cell_count > 0) return static_cast<double>(options.leaf_cell_count);
  return std::max(1.0, share * static_cast<double>(cell_count));
}

/// Positions of the cells in the source file.
Array<std::uint32_t> cell_ids(const NeutralMesh& mesh, const CleanMesh& clean, const std::string& source_name) {
  Array<std::uint32_t> ids;
  ids.reserve(clean.source_cells.size());
  for (const std::uint64_t cell : clean.source_cells) {
    const std::uint64_t id = mesh.cell_ids.empty() ? cell : mesh.cell_ids[cell];
    if (id > std::numeric_limits<std::uint32_t>::max())
      throw Error(Trouble::unsupported, concat(source_name, ", cell ", id, ": expected a position below 2^32"));
    ids.push_back(static_cast<std::uint32_t>(id));
  }
  return ids;
}

void note_no_data(const formats::FieldSummary& field, std::vector<std::string>& notes) {
  if (field.no_data_count == 0) return;
  notes.push_back(concat("field \"", field.name, "\" has no data at ", field.no_data_count,
                         field.no_data_count == 1 ? " point" : " points", ": cells that touch one are absent"));
}

formats::FieldSummary summary_of(const PointField& field) {
  return std::visit(
      [&]<class T>(const Array<T>& values) { return summarize(std::span<const T>(values), field.name, field.unit); },
      field.values);
}

/// All but the leaf lists.
formats::TetMeshDescription description_of(const NeutralMesh& mesh, const CleanMesh& clean,
                                           const std::vector<PointField>& fields, const PackMeshOptions& options) {
  formats::TetMeshDescription packed;
  packed.origin = clean.origin;
  packed.length_unit = mesh.length_unit;
  packed.point_count = clean.points.size();
  packed.cell_count = clean.cells.size();
  for (const PointField& field : fields) packed.fields.push_back(summary_of(field));
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

/// Arrays written piece by piece, so that progress is seen.
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

/// The field's values and its intervals on every level.
template <class T>
void write_field(MeteredWriter& writer, std::size_t field, const Array<T>& values, const CleanMesh& clean,
                 const LeafLists& lists, const formats::MacroShape& shape) {
  writer.write(concat("field.", field), std::span<const T>(values));
  Levels<T> levels(1, build_leaf_ranges(clean.cells, std::span<const T>(values), lists.view()));
  add_levels_above_leaves(levels, shape);
  for (std::size_t level = 0; level < levels.size(); ++level)
    writer.write(concat("range.", field, ".", level), std::span<const T>(levels[level]));
}

}  // namespace

PackMeshReport pack_mesh(const NeutralMesh& mesh, const std::filesystem::path& path, const PackMeshOptions& options,
                         const Progress& progress) {
  const std::string source_name = options.source_name.empty() ? "mesh" : options.source_name;
  ProgressMeter inspecting(progress, "inspecting the mesh", 2);
  CleanMesh clean = clean_mesh(mesh, source_name);
  const Array<std::uint32_t> point_ranks = order_cells(clean);
  inspecting.add(1);
  PackMeshReport report;
  report.notes = clean.notes;
  const std::vector<PointField> fields =
      choose_fields(mesh, clean, options.fields, options.cells_to_points, source_name, report.notes);
  const Array<std::uint32_t> ids = cell_ids(mesh, clean, source_name);
  formats::TetMeshDescription& packed = report.description;
  packed = description_of(mesh, clean, fields, options);
  for (const formats::FieldSummary& field : packed.fields) note_no_data(field, report.notes);
  inspecting.add(1);

  const LeafLists lists = build_leaf_lists(clean.points, clean.cells, packed.lattice, progress);
  packed.leaf_item_count = lists.items.size();

  const std::vector<formats::ArraySpec> arrays = formats::tet_mesh_arrays(packed);
  formats::PackedFileWriter file(path, formats::describe(packed), arrays,
                                 {.replace_existing = options.replace_existing});
  MeteredWriter writer(file, progress, bytes_of(arrays));
  writer.write<std::array<double, 3>>("points", clean.points);
  writer.write<std::array<std::uint32_t, 4>>("cells", clean.cells);
  writer.write<std::uint32_t>("cell_ids", ids);
  writer.write<std::uint32_t>("point_ranks", point_ranks);
  writer.write<std::uint64_t>("leaf.offsets", lists.offsets);
  writer.write<std::uint32_t>("leaf.items", lists.items);
  for (std::size_t f = 0; f < fields.size(); ++f)
    std::visit([&](const auto& values) { write_field(writer, f, values, clean, lists, packed.lattice.macro); },
               fields[f].values);
  ProgressMeter sealing(progress, "sealing", 1);
  report.file_bytes = file.commit();
  sealing.add(1);
  return report;
}

}  // namespace rhoray::preprocess

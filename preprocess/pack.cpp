#include "preprocess/pack.h"

#include <algorithm>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "formats/base/word_list.h"
#include "formats/packed_file.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/input_file.h"
#include "preprocess/pack_colors.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_surface.h"
#include "preprocess/process/memory_cap.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

ForeignKind kind_of(const fs::path& input, const PackOptions& options) {
  return options.raw.empty() ? foreign_kind(input) : ForeignKind::volume;
}

/// Refuses --raw for a file with a known header, which would become samples.
void check_no_header(const fs::path& input) {
  if (fs::is_directory(input)) throw Error(ErrorCode::usage, concat("--raw: ", input.string(), " is a folder"));
  const std::string_view format = known_header(input);
  if (format.empty()) return;
  const std::string hint = foreign_kind(input) != ForeignKind::unknown ? "leave out --raw"
                           : format == "gzip"                          ? "decompress it first: gunzip"
                                                                       : advice_on(input);
  throw Error(ErrorCode::usage,
              concat("--raw: ", input.string(), " begins with a header (", format, "); expected samples alone"), hint);
}

void check_kind(const fs::path& input, const PackOptions& options) {
  const std::string name = input.string();
  if (formats::PackedFile::looks_packed(input))
    throw Error(options.raw.empty() ? ErrorCode::unsupported : ErrorCode::usage,
                concat(name, ": is already a packed file"), concat("show its content: rhoray info ", name));
  if (!options.raw.empty()) return check_no_header(input);
  if (foreign_kind(input) != ForeignKind::unknown) return;
  std::string hint = advice_on(input);
  if (hint.empty())
    hint = concat("`rhoray formats` lists what is read",
                  known_header(input).empty() ? "; --raw 256x256x128:uint16:le reads bytes without a header" : "");
  throw Error(ErrorCode::unsupported, concat(unsupported_type(input), "; expected a volume, a mesh or a surface"),
              hint);
}

/// Options that cannot be combined with --color.
void check_color_options(const fs::path& input, ForeignKind kind, const PackOptions& options) {
  const PackOptions defaults;
  if (kind != ForeignKind::volume)
    throw Error(ErrorCode::usage, concat("--color: only for volumes, but ", input.string(), " is a ", name_of(kind)));
  for (const auto& [given, name] : {std::pair{!options.raw.empty(), "--raw"},
                                    {options.type.has_value(), "--type"},
                                    {options.layout == SampleOrder::sparse, "--layout sparse"},
                                    {options.levels != defaults.levels, "--levels"},
                                    {options.factor != defaults.factor, "--factor"},
                                    {options.fields.size() > 1, "--field with several names"}})
    if (given) throw Error(ErrorCode::usage, concat(name, ": cannot be combined with --color"));
}

/// Refuses options of the other kinds of data, which would be ignored silently.
void check_options(const fs::path& input, ForeignKind kind, const PackOptions& options) {
  struct Row {
    bool given;
    ForeignKind kind;
    const char* name;
  };
  const Row rows[] = {{options.layout.has_value(), ForeignKind::volume, "--layout"},
                      {options.brick_edge.has_value(), ForeignKind::volume, "--brick-edge"},
                      {options.type.has_value(), ForeignKind::volume, "--type"},
                      {options.spacing.has_value(), ForeignKind::volume, "--spacing"},
                      {options.origin.has_value(), ForeignKind::volume, "--origin"},
                      {options.structure.has_value(), ForeignKind::mesh, "--structure"},
                      {options.cells.has_value(), ForeignKind::mesh, "--cells"},
                      {options.leaf_ratio.has_value(), ForeignKind::mesh, "--leaf-ratio"},
                      {options.cell_data, ForeignKind::mesh, "--cell-data"},
                      {options.max_error.has_value(), ForeignKind::mesh, "--max-error"}};
  if (options.color) check_color_options(input, kind, options);
  for (const Row& row : rows)
    if (row.given && row.kind != kind)
      throw Error(ErrorCode::usage,
                  concat(row.name, ": only for ", row.kind == ForeignKind::volume ? "volumes" : "meshes", ", but ",
                         input.string(), " is a ", name_of(kind)));
  if (kind == ForeignKind::surface && !options.time.empty())
    throw Error(ErrorCode::usage, concat("--time: ", input.string(), " is a surface, which has no time steps"));
  if (kind == ForeignKind::surface && !options.fields.empty())
    throw Error(ErrorCode::usage, concat("--field: ", input.string(), " is a surface, which has no fields"));
  if (!options.raw.empty() && options.fields.size() > 1)
    throw Error(ErrorCode::usage,
                concat("--field: found ", options.fields.size(), " names; --raw data have one field"));
  if (options.brick_edge && options.layout == SampleOrder::linear)
    throw Error(ErrorCode::usage, "--brick-edge: has no effect with --layout linear");
}

/// Refuses options of leaf lists, which clusters and surfaces would ignore silently.
void check_structure(ForeignKind kind, const PackOptions& options) {
  if (kind == ForeignKind::volume || options.structure == MeshStructure::leaves) return;
  const PackOptions defaults;
  for (const auto& [given, name] : {std::pair{options.cells.has_value(), "--cells"},
                                    {options.leaf_ratio.has_value(), "--leaf-ratio"},
                                    {options.levels != defaults.levels, "--levels"},
                                    {options.factor != defaults.factor, "--factor"}})
    if (given) throw Error(ErrorCode::usage, concat(name, ": only for volumes or --structure leaves"));
}

/// Checks before reading that the file has enough raw bytes.
void check_raw(const fs::path& input, const PackOptions& options) {
  if (options.raw.empty()) return;
  const RawVolume raw = parse_raw_volume(options.raw);
  const Index3& n = raw.sample_count;
  const auto bytes = checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                                      static_cast<std::uint64_t>(n.z), formats::element_bytes(raw.type)});
  const std::uint64_t there = fs::file_size(input);
  if (!bytes || *bytes > there || raw.skipped_bytes > there - *bytes)
    throw Error(ErrorCode::invalid, concat(input.string(), ": found ", there, " bytes; --raw ", options.raw,
                                           " expects ", bytes ? concat(*bytes + raw.skipped_bytes) : "more than 2^64"));
}

void check_numbers(const PackOptions& options) {
  struct Row {
    const char* name;
    double value, lo, hi;
  };
  const Row rows[] = {{"--cells", static_cast<double>(options.cells.value_or(1)), 1, 1e12},
                      {"--leaf-ratio", options.leaf_ratio.value_or(1), 1e-6, 1e6},
                      {"--levels", static_cast<double>(options.levels), 0, formats::MacroShape::largest_level_count},
                      {"--factor", static_cast<double>(options.factor), 2, 1024}};
  for (const auto& [name, value, lo, hi] : rows)
    if (!(value >= lo && value <= hi))
      throw Error(ErrorCode::usage, concat(name, ": found ", value, "; expected a number from ", lo, " to ", hi));
}

/// The folder for large arrays under a memory cap: that of the packed file, or of temporary files
/// if it has no name. Empty without a cap.
fs::path scratch_folder(const formats::Destination& output, const PackOptions& options) {
  if (options.memory_limit_bytes == 0) return {};
  if (output.descriptor >= 0) return fs::temp_directory_path();
  return output.path.has_parent_path() ? output.path.parent_path() : fs::path(".");
}

ImportVolumeOptions import_options(const formats::Destination& output, const PackOptions& options,
                                   const Progress& progress) {
  ImportVolumeOptions import;
  if (!options.raw.empty()) import.raw = parse_raw_volume(options.raw);
  import.colors = options.color;
  import.spacing = options.spacing;
  import.origin = options.origin;
  import.time = options.time;
  import.memory_limit_bytes = options.memory_limit_bytes;
  import.scratch_folder = scratch_folder(output, options);
  import.progress = progress;
  return import;
}

/// The requested fields, each as a volume; without names the file's first field. Refuses an output
/// that was read.
std::vector<NeutralVolume> import_fields(const fs::path& input, const formats::Destination& output,
                                         const PackOptions& options, const Progress& progress) {
  ImportVolumeOptions import = import_options(output, options, progress);
  std::vector<NeutralVolume> fields;
  fields.reserve(std::max<std::size_t>(1, options.fields.size()));
  if (options.fields.empty()) fields.push_back(import_volume(input, import));
  for (const std::string& name : options.fields) {
    import.field = name;
    fields.push_back(import_volume(input, import));
  }
  for (const NeutralVolume& field : fields) require_not_read(output.path, field.sources);
  return fields;
}

/// Each note once, because fields of one file share most notes.
std::vector<std::string> notes_of(const std::vector<NeutralVolume>& fields) {
  std::vector<std::string> notes;
  for (const NeutralVolume& field : fields)
    for (const std::string& note : field.notes)
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  return notes;
}

std::vector<SourceFile> sources_of(const std::vector<NeutralVolume>& fields) {
  std::vector<SourceFile> sources;
  for (const NeutralVolume& field : fields) sources.insert(sources.end(), field.sources.begin(), field.sources.end());
  return sources;
}

std::uint64_t bytes_of(const std::vector<formats::FieldSummary>& fields) {
  std::uint64_t bytes = 0;
  for (const formats::FieldSummary& field : fields) bytes += formats::element_bytes(field.type);
  return bytes;
}

PackReport pack_volume_file(const fs::path& input, const formats::Destination& output, const PackOptions& options,
                            const Progress& progress) {
  const std::vector<NeutralVolume> fields = import_fields(input, output, options, progress);
  const PackVolumeReport packed = pack_grid(fields, output,
                                            {.order = options.layout.value_or(SampleOrder::bricks),
                                             .brick_edge = options.brick_edge,
                                             .macro_factor = options.factor,
                                             .macro_level_count = options.levels,
                                             .type = options.type,
                                             .command = options.command,
                                             .source_name = input.filename().string(),
                                             .replace_existing = options.replace_existing},
                                            progress);
  const formats::GridDescription& grid = packed.description;
  return {.description = grid,
          .notes = notes_of(fields),
          .sources = sources_of(fields),
          .raw_bytes = static_cast<std::uint64_t>(volume(grid.layout.sample_count)) * bytes_of(grid.fields),
          .file_bytes = packed.file_bytes};
}

PackReport pack_color_file(const fs::path& input, const formats::Destination& output, const PackOptions& options,
                           const Progress& progress) {
  const std::vector<NeutralVolume> fields = import_fields(input, output, options, progress);
  PackColorsOptions pack{.is_linear = options.layout == SampleOrder::linear,
                         .command = options.command,
                         .source_name = input.filename().string(),
                         .replace_existing = options.replace_existing};
  pack.brick_edge = options.brick_edge.value_or(pack.brick_edge);
  const PackColorsReport packed = pack_colors(fields.front(), output, pack, progress);
  const formats::ColorGridDescription& grid = packed.description;
  return {.description = grid,
          .notes = fields.front().notes,
          .sources = fields.front().sources,
          .raw_bytes = static_cast<std::uint64_t>(volume(grid.layout.sample_count)) *
                       static_cast<std::uint64_t>(grid.component_count),
          .file_bytes = packed.file_bytes};
}

PackReport pack_mesh_file(const fs::path& input, const formats::Destination& output, const PackOptions& options,
                          const Progress& progress) {
  PackMeshOptions pack{.fields = options.fields,
                       .cells_to_points = options.cell_data,
                       .structure = options.structure.value_or(MeshStructure::clusters),
                       .leaf_cell_count = static_cast<std::uint64_t>(options.cells.value_or(0)),
                       .macro_factor = options.factor,
                       .macro_level_count = options.levels,
                       .command = options.command,
                       .source_name = input.filename().string(),
                       .replace_existing = options.replace_existing};
  pack.leaf_cells_per_tetrahedron = options.leaf_ratio.value_or(pack.leaf_cells_per_tetrahedron);
  NeutralMesh mesh = import_mesh(input, {.time = options.time,
                                         .max_error = options.max_error.value_or(ImportMeshOptions{}.max_error),
                                         .error_fields = options.fields,
                                         .memory_limit_bytes = options.memory_limit_bytes,
                                         .scratch_folder = scratch_folder(output, options),
                                         .progress = progress});
  require_not_read(output.path, mesh.sources);
  give_fields(mesh, pack.cells_to_points);
  const PackMeshReport packed = pack_mesh(mesh, output, pack, progress);
  const formats::TetMeshDescription& tets = packed.description;
  PackReport report{.description = tets,
                    .notes = mesh.notes,
                    .sources = mesh.sources,
                    .raw_bytes = (3 * sizeof(double) + bytes_of(tets.fields)) * tets.point_count +
                                 4 * sizeof(std::uint32_t) * tets.cell_count,
                    .file_bytes = packed.file_bytes};
  report.notes.insert(report.notes.end(), packed.notes.begin(), packed.notes.end());
  return report;
}

PackReport pack_surface_file(const fs::path& input, const formats::Destination& output, const PackOptions& options,
                             const Progress& progress) {
  const NeutralSurface surface = import_surface(input, {}, {.memory_limit_bytes = options.memory_limit_bytes});
  require_not_read(output.path, surface.sources);
  const PackSurfaceReport packed = pack_surface(surface, output,
                                                {.command = options.command,
                                                 .source_name = input.filename().string(),
                                                 .replace_existing = options.replace_existing},
                                                progress);
  const formats::TriangleMeshDescription& triangles = packed.description;
  PackReport report{.description = triangles,
                    .notes = surface.notes,
                    .sources = surface.sources,
                    .raw_bytes = 3 * formats::element_bytes(triangles.point_type) * triangles.point_count +
                                 3 * sizeof(std::uint32_t) * triangles.triangle_count,
                    .file_bytes = packed.file_bytes};
  report.notes.insert(report.notes.end(), packed.notes.begin(), packed.notes.end());
  return report;
}

}  // namespace

std::vector<std::string> option_words(const PackOptions& options) {
  std::vector<std::string> words;
  const auto add = [&](bool given, const char* name, const std::string& value) {
    if (given) words.insert(words.end(), {name, value});
  };
  const auto numbers = [](const std::optional<Vec3>& v) {
    return v ? concat(v->x, ",", v->y, ",", v->z) : std::string{};
  };
  const auto layout_word = [](SampleOrder order) {
    return order == SampleOrder::sparse ? "sparse" : order == SampleOrder::linear ? "linear" : "bricks";
  };
  const PackOptions defaults;
  add(!options.raw.empty(), "--raw", options.raw);
  add(!options.fields.empty(), "--field", joined(options.fields, ","));
  add(options.structure.has_value(), "--structure", options.structure == MeshStructure::leaves ? "leaves" : "clusters");
  add(options.cells.has_value(), "--cells", concat(options.cells.value_or(0)));
  add(options.leaf_ratio.has_value(), "--leaf-ratio", concat(options.leaf_ratio.value_or(0)));
  add(options.levels != defaults.levels, "--levels", concat(options.levels));
  add(options.factor != defaults.factor, "--factor", concat(options.factor));
  if (options.color) words.emplace_back("--color");
  add(options.type.has_value(), "--type",
      std::string(formats::element_name(options.type.value_or(formats::ElementType::U8))));
  add(options.layout.has_value(), "--layout", layout_word(options.layout.value_or(SampleOrder::bricks)));
  add(options.brick_edge.has_value(), "--brick-edge", concat(options.brick_edge.value_or(0)));
  add(options.spacing.has_value(), "--spacing", numbers(options.spacing));
  add(options.origin.has_value(), "--origin", numbers(options.origin));
  if (options.cell_data) words.emplace_back("--cell-data");
  add(options.max_error.has_value(), "--max-error", concat(options.max_error.value_or(0)));
  add(!options.time.empty(), "--time", options.time);
  return words;
}

void check_pack(const fs::path& input, const PackOptions& options) {
  require_input(input);
  check_kind(input, options);
  const ForeignKind kind = kind_of(input, options);
  check_options(input, kind, options);
  check_structure(kind, options);
  check_raw(input, options);
  check_numbers(options);
}

PackReport pack(const fs::path& input, const formats::Destination& output, const PackOptions& options,
                const Progress& progress) {
  check_pack(input, options);
  const ForeignKind kind = kind_of(input, options);
  const fs::path scratch = scratch_folder(output, options);
  std::optional<MemoryCap> cap;
  if (options.memory_limit_bytes != 0) cap.emplace(options.memory_limit_bytes, scratch);
  const auto pack_file = options.color                  ? pack_color_file
                         : kind == ForeignKind::volume  ? pack_volume_file
                         : kind == ForeignKind::surface ? pack_surface_file
                                                        : pack_mesh_file;
  if (progress) progress("reading", 0, 0);
  PackReport report = pack_file(input, output, options, progress);
  if (cap && MemoryCap::folder_is_memory(scratch))
    report.notes.push_back("the output's folder is in memory, so --memory saves nothing");
  return report;
}

}  // namespace rhoray::preprocess

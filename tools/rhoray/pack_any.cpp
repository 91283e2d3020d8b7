#include "tools/rhoray/pack_any.h"

#include <algorithm>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/packed_file.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/memory_cap.h"
#include "preprocess/pack_colors.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_surface.h"
#include "preprocess/pack_volume.h"
#include "preprocess/position_fields.h"
#include "tools/rhoray/input_file.h"

namespace rhoray::tools {

namespace {

bool is_volume(const PackOptions& options) {
  return !options.raw.empty() || preprocess::foreign_kind(options.input) == preprocess::ForeignKind::volume;
}

bool is_surface(const PackOptions& options) {
  return options.raw.empty() && preprocess::foreign_kind(options.input) == preprocess::ForeignKind::surface;
}

void check_kind(const PackOptions& options) {
  const std::string name = options.input.string();
  if (formats::PackedFile::looks_packed(options.input))
    throw Error(ErrorCode::invalid, concat(name, ": is already a packed file"),
                concat("show its content: rhoray info ", name));
  switch (preprocess::foreign_kind(options.input)) {
    case preprocess::ForeignKind::volume:
    case preprocess::ForeignKind::mesh:
    case preprocess::ForeignKind::surface:
      return;
    case preprocess::ForeignKind::unknown:
      break;
  }
  const std::string advice = preprocess::advice_on(options.input);
  throw Error(ErrorCode::invalid, concat(unsupported_type(options.input), "; expected a volume, a mesh or a surface"),
              !advice.empty()
                  ? advice
                  : "`rhoray pack --help` lists file types; --raw 256x256x128:uint16:le reads bytes without "
                    "a header");
}

/// Options that cannot be combined with --color.
void check_color_options(const PackOptions& options) {
  const PackOptions defaults;
  if (!is_volume(options))
    throw Error(ErrorCode::usage, concat("--color: only for volumes, but ", options.input.string(), " is a ",
                                         is_surface(options) ? "surface" : "mesh"));
  for (const auto& [given, name] : {std::pair{!options.raw.empty(), "--raw"},
                                    {options.type.has_value(), "--type"},
                                    {options.layout == "sparse", "--layout sparse"},
                                    {options.levels != defaults.levels, "--levels"},
                                    {options.factor != defaults.factor, "--factor"},
                                    {options.fields.size() > 1, "--field with several names"}})
    if (given) throw Error(ErrorCode::usage, concat(name, ": cannot be combined with --color"));
}

/// Refuses options of the other kind of data, which would be ignored silently.
void check_options(const PackOptions& options) {
  struct Row {
    bool given;
    bool for_volumes;
    const char* name;
  };
  const Row rows[] = {
      {!options.layout.empty(), true, "--layout"},    {options.brick_edge.has_value(), true, "--brick-edge"},
      {options.type.has_value(), true, "--type"},     {options.spacing.has_value(), true, "--spacing"},
      {options.origin.has_value(), true, "--origin"}, {!options.structure.empty(), false, "--structure"},
      {options.cells != "auto", false, "--cells"},    {options.leaf_ratio.has_value(), false, "--leaf-ratio"},
      {options.cell_data, false, "--cell-data"},      {options.max_error.has_value(), false, "--max-error"},
      {!options.time.empty(), false, "--time"}};
  const bool volume = is_volume(options), surface = is_surface(options);
  if (options.color) check_color_options(options);
  for (const Row& row : rows)
    if (row.given && surface)
      throw Error(ErrorCode::usage, concat(row.name, ": only for ", row.for_volumes ? "volumes" : "meshes", ", but ",
                                           options.input.string(), " is a surface"));
  if (surface && !options.fields.empty())
    throw Error(ErrorCode::usage, concat("--field: ", options.input.string(), " is a surface, which has no fields"));
  for (const Row& row : rows)
    if (row.given && row.for_volumes != volume)
      throw Error(ErrorCode::usage, concat(row.name, ": only for ", row.for_volumes ? "volumes" : "meshes", ", but ",
                                           options.input.string(), " is a ", volume ? "volume" : "mesh"));
  if (!options.raw.empty() && options.fields.size() > 1)
    throw Error(ErrorCode::usage,
                concat("--field: found ", options.fields.size(), " names; --raw data have one field"));
  if (options.brick_edge && options.layout == "linear")
    throw Error(ErrorCode::usage, "--brick-edge: has no effect with --layout linear");
}

bool has_leaf_lists(const PackOptions& options) {
  return options.structure == "leaves";
}

/// Refuses options of leaf lists, which clusters would ignore silently.
void check_structure(const PackOptions& options) {
  if (is_volume(options) || (!is_surface(options) && has_leaf_lists(options))) return;
  const PackOptions defaults;
  for (const auto& [given, name] : {std::pair{options.cells != defaults.cells, "--cells"},
                                    std::pair{options.leaf_ratio.has_value(), "--leaf-ratio"},
                                    std::pair{options.levels != defaults.levels, "--levels"},
                                    std::pair{options.factor != defaults.factor, "--factor"}})
    if (given) throw Error(ErrorCode::usage, concat(name, ": only for volumes or --structure leaves"));
}

/// Checks before reading that the file has enough raw bytes.
void check_raw(const PackOptions& options) {
  if (options.raw.empty()) return;
  const preprocess::RawVolume raw = preprocess::parse_raw_volume(options.raw);
  const Index3& n = raw.sample_count;
  const auto bytes = checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                                      static_cast<std::uint64_t>(n.z), formats::element_bytes(raw.type)});
  const std::uint64_t there = std::filesystem::file_size(options.input);
  if (!bytes || *bytes > there || raw.skipped_bytes > there - *bytes)
    throw Error(ErrorCode::invalid, concat(options.input.string(), ": found ", there, " bytes; --raw ", options.raw,
                                           " expects ", bytes ? concat(*bytes + raw.skipped_bytes) : "more than 2^64"));
}

/// The folder for large arrays under a memory cap: that of the packed file. Empty without a cap.
std::filesystem::path scratch_folder(const PackOptions& options, const std::filesystem::path& output) {
  if (options.memory_limit_bytes == 0) return {};
  return output.has_parent_path() ? output.parent_path() : std::filesystem::path(".");
}

preprocess::SampleOrder sample_order(const std::string& layout) {
  if (layout == "linear") return preprocess::SampleOrder::linear;
  return layout == "sparse" ? preprocess::SampleOrder::sparse : preprocess::SampleOrder::bricks;
}

/// The requested fields, each as a volume; without names the file's first field.
std::vector<preprocess::NeutralVolume> import_fields(const PackOptions& options,
                                                     preprocess::ImportVolumeOptions import) {
  std::vector<preprocess::NeutralVolume> fields;
  fields.reserve(std::max<std::size_t>(1, options.fields.size()));
  if (options.fields.empty()) fields.push_back(preprocess::import_volume(options.input, import));
  for (const std::string& name : options.fields) {
    import.field = name;
    fields.push_back(preprocess::import_volume(options.input, import));
  }
  return fields;
}

/// Each note once, because fields of one file share most notes.
std::vector<std::string> notes_of(const std::vector<preprocess::NeutralVolume>& fields) {
  std::vector<std::string> notes;
  for (const preprocess::NeutralVolume& field : fields)
    for (const std::string& note : field.notes)
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  return notes;
}

PackResult pack_volume(const PackOptions& options, const std::filesystem::path& output,
                       const preprocess::Progress& progress) {
  preprocess::ImportVolumeOptions import;
  if (!options.raw.empty()) import.raw = preprocess::parse_raw_volume(options.raw);
  import.spacing = options.spacing;
  import.origin = options.origin;
  import.memory_limit_bytes = options.memory_limit_bytes;
  import.scratch_folder = scratch_folder(options, output);
  import.progress = progress;
  if (progress) progress("reading", 0, 0);
  const std::vector<preprocess::NeutralVolume> fields = import_fields(options, import);

  const preprocess::PackVolumeReport report = preprocess::pack_grid(fields, output,
                                                                    {.order = sample_order(options.layout),
                                                                     .brick_edge = options.brick_edge,
                                                                     .macro_factor = options.factor,
                                                                     .macro_level_count = options.levels,
                                                                     .type = options.type,
                                                                     .command = options.command,
                                                                     .source_name = options.input.filename().string(),
                                                                     .replace_existing = options.replace_existing},
                                                                    progress);
  const formats::GridDescription& grid = report.description;
  const Index3& count = grid.layout.sample_count;
  const auto sample_count = static_cast<std::uint64_t>(rhoray::volume(count));
  std::string types;
  std::uint64_t bytes = 0;
  for (const formats::FieldSummary& field : grid.fields) {
    types += concat(types.empty() ? "" : ", ", formats::element_name(field.type));
    bytes += formats::element_bytes(field.type);
  }
  return {.kind = "grid",
          .description = json_of(grid),
          .content = concat(text_of(count), " = ", grouped(sample_count), " samples ", types),
          .notes = notes_of(fields),
          .raw_bytes = sample_count * bytes,
          .file_bytes = report.file_bytes,
          .cell_count = static_cast<std::uint64_t>(rhoray::volume(grid.macro.leaf_count))};
}

PackResult pack_colors(const PackOptions& options, const std::filesystem::path& output,
                       const preprocess::Progress& progress) {
  if (progress) progress("reading", 0, 0);
  const preprocess::NeutralVolume colors =
      preprocess::import_volume(options.input, {.raw = {},
                                                .field = options.fields.empty() ? std::string() : options.fields[0],
                                                .colors = true,
                                                .spacing = options.spacing,
                                                .origin = options.origin,
                                                .memory_limit_bytes = options.memory_limit_bytes,
                                                .scratch_folder = scratch_folder(options, output),
                                                .progress = progress});
  preprocess::PackColorsOptions pack{.is_linear = options.layout == "linear",
                                     .command = options.command,
                                     .source_name = options.input.filename().string(),
                                     .replace_existing = options.replace_existing};
  pack.brick_edge = options.brick_edge.value_or(pack.brick_edge);
  const preprocess::PackColorsReport report = preprocess::pack_colors(colors, output, pack, progress);
  const formats::ColorGridDescription& grid = report.description;
  const auto texel_count = static_cast<std::uint64_t>(rhoray::volume(grid.layout.sample_count));
  return {.kind = formats::ColorGrid::kind,
          .description = json_of(grid),
          .content = concat(text_of(grid.layout.sample_count), " = ", grouped(texel_count), " colours ",
                            grid.has_alpha() ? "RGBA" : "RGB"),
          .notes = colors.notes,
          .raw_bytes = texel_count * static_cast<std::uint64_t>(grid.component_count),
          .file_bytes = report.file_bytes,
          .cell_count = texel_count};
}

/// A mesh that has only cell fields shows these; a mesh without a varying field gets position
/// fields.
void give_fields(preprocess::NeutralMesh& mesh, preprocess::PackMeshOptions& pack) {
  if (!preprocess::has_varying_field(mesh)) return preprocess::add_position_fields(mesh);
  if (!mesh.point_fields.empty() || pack.cells_to_points) return;
  pack.cells_to_points = true;
  mesh.notes.push_back("no point data; cell data were averaged to the points");
}

PackResult pack_mesh(const PackOptions& options, const std::filesystem::path& output,
                     const preprocess::Progress& progress) {
  preprocess::PackMeshOptions pack{
      .fields = options.fields,
      .cells_to_points = options.cell_data,
      .structure = has_leaf_lists(options) ? preprocess::MeshStructure::leaves : preprocess::MeshStructure::clusters,
      .macro_factor = options.factor,
      .macro_level_count = options.levels,
      .command = options.command,
      .source_name = options.input.filename().string(),
      .replace_existing = options.replace_existing};
  pack.leaf_cells_per_tetrahedron = options.leaf_ratio.value_or(pack.leaf_cells_per_tetrahedron);
  if (options.cells != "auto") read_value(options.cells, pack.leaf_cell_count);
  if (progress) progress("reading", 0, 0);
  preprocess::NeutralMesh mesh = preprocess::import_mesh(
      options.input, {.time = options.time,
                      .max_error = options.max_error.value_or(preprocess::ImportMeshOptions{}.max_error),
                      .error_fields = options.fields,
                      .memory_limit_bytes = options.memory_limit_bytes,
                      .scratch_folder = scratch_folder(options, output),
                      .progress = progress});
  give_fields(mesh, pack);
  const preprocess::PackMeshReport report = preprocess::pack_mesh(mesh, output, pack, progress);

  const formats::TetMeshDescription& packed = report.description;
  std::uint64_t point_bytes = 3 * sizeof(double);
  for (const formats::FieldSummary& field : packed.fields) point_bytes += formats::element_bytes(field.type);
  PackResult result{.kind = "tets",
                    .description = json_of(packed),
                    .content = concat(counted(packed.cell_count, "tetrahedron", "tetrahedra"), ", ",
                                      counted(packed.point_count, "point", "points"), ", ",
                                      counted(packed.fields.size(), "field", "fields")),
                    .notes = mesh.notes,
                    .raw_bytes = point_bytes * packed.point_count + 4 * sizeof(std::uint32_t) * packed.cell_count,
                    .file_bytes = report.file_bytes,
                    .cell_count = packed.cell_count};
  result.notes.insert(result.notes.end(), report.notes.begin(), report.notes.end());
  return result;
}

PackResult pack_surface(const PackOptions& options, const std::filesystem::path& output,
                        const preprocess::Progress& progress) {
  if (progress) progress("reading", 0, 0);
  const preprocess::NeutralSurface surface =
      preprocess::import_surface(options.input, {}, {.memory_limit_bytes = options.memory_limit_bytes});
  const preprocess::PackSurfaceReport report =
      preprocess::pack_surface(surface, output,
                               {.command = options.command,
                                .source_name = options.input.filename().string(),
                                .replace_existing = options.replace_existing},
                               progress);
  const formats::SurfaceMeshDescription& packed = report.description;
  PackResult result{.kind = formats::SurfaceMesh::kind,
                    .description = json_of(packed),
                    .content = concat(counted(packed.triangle_count, "triangle", "triangles"), ", ",
                                      counted(packed.point_count, "point", "points")),
                    .notes = surface.notes,
                    .raw_bytes = 3 * formats::element_bytes(packed.point_type) * packed.point_count +
                                 3 * sizeof(std::uint32_t) * packed.triangle_count,
                    .file_bytes = report.file_bytes,
                    .cell_count = packed.triangle_count};
  result.notes.insert(result.notes.end(), report.notes.begin(), report.notes.end());
  return result;
}

}  // namespace

void check_pack(const PackOptions& options) {
  require_input(options.input);
  if (options.raw.empty()) check_kind(options);
  check_options(options);
  check_structure(options);
  check_raw(options);
  if (options.cells != "auto") {
    std::int64_t count = 0;
    read_value(options.cells, count);
    require_within("--cells", static_cast<double>(count), 1, 1e12);
  }
  if (options.leaf_ratio) require_within("--leaf-ratio", *options.leaf_ratio, 1e-6, 1e6);
  require_within("--levels", options.levels, 0, formats::MacroShape::largest_level_count);
  require_within("--factor", static_cast<double>(options.factor), 2, 1024);
}

PackResult pack_any(const PackOptions& options, const std::filesystem::path& output,
                    const preprocess::Progress& progress) {
  std::optional<preprocess::MemoryCap> cap;
  if (options.memory_limit_bytes != 0) cap.emplace(options.memory_limit_bytes, scratch_folder(options, output));
  const auto pack = options.color         ? pack_colors
                    : is_volume(options)  ? pack_volume
                    : is_surface(options) ? pack_surface
                                          : pack_mesh;
  PackResult result = pack(options, output, progress);
  if (cap && preprocess::MemoryCap::folder_is_memory(scratch_folder(options, output)))
    result.notes.push_back("the output's folder is in memory, so --memory saves nothing");
  return result;
}

}  // namespace rhoray::tools

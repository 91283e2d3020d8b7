#include "tools/rhoray/data_choice.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/number_text.h"
#include "formats/base/word_list.h"
#include "formats/shape_field.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/input_file.h"
#include "preprocess/open_vdb.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/version.h"

namespace rhoray::tools {

namespace {

bool varies(const formats::FieldSummary& field) {
  return field.range.lo < field.range.hi;
}

/// The first field, or if it is constant the first field that is not.
render::Dataset load_field_that_varies(const formats::PackedFile& file, formats::Space world) {
  const render::Dataset first = render::Dataset::load(file, {}, world);
  if (varies(first.field())) return first;
  for (const std::string& name : first.field_names()) {
    const render::Dataset other = render::Dataset::load(file, name, world);
    if (varies(other.field())) return other;
  }
  return first;
}

std::uint64_t cache_limit_bytes() {
  const char* const text = std::getenv("RHORAY_CACHE_SIZE");
  if (text == nullptr || *text == '\0') return preprocess::PackCache::default_limit_bytes;
  ByteCount limit;
  try {
    read_value(text, limit);
  } catch (const Error& error) {
    throw Error(error.code(), concat("RHORAY_CACHE_SIZE: ", error.what()), error.hint());
  }
  return limit.bytes;
}

/// Says that a file was packed, and where its packed copy is.
std::string packing_text(const std::filesystem::path& path, const preprocess::OpenedData& opened, double seconds) {
  return concat("packed ", path.string(), " in ", rounded(seconds, 2), " s, ", bytes_text(opened.file.file_bytes()),
                opened.path.empty() ? ", in memory" : ", kept in the cache",
                opened.not_kept.empty() ? "" : concat(" (", opened.not_kept, ")"));
}

/// True for a note on a choice that an option changes: users see it without --verbose.
bool is_choice(const std::string& note) {
  return note.find("; choose another with --") != std::string::npos;
}

/// An empty name is no field.
bool has_fields(const render::Dataset& dataset, const std::vector<std::string>& names) {
  return std::all_of(names.begin(), names.end(),
                     [&](const std::string& name) { return name.empty() || dataset.field(name); });
}

/// @param color  keeps the colours, for a texture
preprocess::OpenedData open(const std::filesystem::path& path, const std::vector<std::string>& fields,
                            const DataAccess& access, bool color = false) {
  preprocess::PackOptions pack = pack_options(access.read);
  pack.color = color;
  const bool is_of_one_grid = preprocess::is_vdb(path);
  if (is_of_one_grid && !fields.empty()) pack.fields = {fields.front()};
  const std::pair key(path, preprocess::option_words(pack));
  if (access.opened)
    if (const auto known = access.opened->find(key); known != access.opened->end()) {
      const DataAccess::OpenedFor& kept = known->second;
      const bool was_for_these = std::all_of(fields.begin(), fields.end(), [&](const std::string& field) {
        return std::find(kept.fields.begin(), kept.fields.end(), field) != kept.fields.end();
      });
      if (is_of_one_grid || was_for_these || has_fields(render::Dataset::load(kept.data.file), fields))
        return kept.data;
    }
  pack.fields = fields;
  const Stopwatch watch;
  const preprocess::OpenedData opened = preprocess::open_data(path, {.pack = pack,
                                                                     .use_cache = access.use_cache,
                                                                     .program = concat(version(), " ", commit()),
                                                                     .cache_limit_bytes = cache_limit_bytes(),
                                                                     .progress = access.progress});
  if (opened.was_packed && access.say) access.say(packing_text(path, opened, watch.seconds()));
  for (const std::string& note : opened.notes)
    if (const auto& print = is_choice(note) ? access.say : access.tell) print(concat("note: ", note));
  if (access.opened) access.opened->insert_or_assign(key, DataAccess::OpenedFor{opened, fields});
  return opened;
}

[[noreturn]] void refuse_surface(const std::filesystem::path& path) {
  throw Error(ErrorCode::unsupported, concat(path.string(), ": holds a surface; expected a grid or a mesh with fields"),
              concat("show it: rhoray render ", path.string()));
}

std::vector<std::string> names_of(const std::string& field, const std::vector<std::string>& others) {
  std::vector<std::string> names;
  if (!field.empty()) names.push_back(field);
  for (const std::string& other : others)
    if (!other.empty() && other != field) names.push_back(other);
  return names;
}

/// The access to data that say themselves how they are read.
DataAccess reading(const render::DataSpec& data, const DataAccess& access) {
  DataAccess changed = access;
  changed.read = data.read;
  return changed;
}

}  // namespace

void require_not_read(const std::filesystem::path& output, const DataAccess& access) {
  if (access.opened)
    for (const auto& [key, opened] : *access.opened) preprocess::require_not_read(output, opened.data.sources);
}

void require_packed(const std::filesystem::path& path) {
  if (formats::PackedFile::looks_packed(path) || path.extension() == ".rho") return;
  const std::filesystem::path packed = std::filesystem::path(path.filename()).replace_extension(".rho");
  throw Error(ErrorCode::unsupported, concat(path.string(), ": is not a packed file"),
              preprocess::foreign_kind(path) == preprocess::ForeignKind::unknown
                  ? std::string("`rhoray formats` lists what can be packed")
                  : concat("pack it first: ", shell_line({"rhoray", "pack", path.string(), "-o", packed.string()})));
}

preprocess::PackOptions pack_options(const render::ReadSpec& read) {
  preprocess::PackOptions pack;
  pack.raw = read.raw;
  pack.spacing = read.spacing;
  pack.origin = read.origin;
  pack.time = read.time;
  return pack;
}

std::vector<Option> read_options(render::ReadSpec& read) {
  return all_options({raw_options(read.raw, read.spacing, read.origin), {time_option(read.time)}});
}

DataAccess access_for(const CommonOptions& common, ProgressDisplay& display, const render::ReadSpec& read) {
  return {.use_cache = !common.no_cache,
          .read = read,
          .progress = display.progress(),
          .say =
              [&common, &display](const std::string& line) {
                display.clear();
                say(common, line);
              },
          .tell = [&common](const std::string& line) { tell(common, line); },
          .opened = std::make_shared<DataAccess::Opened>()};
}

namespace {

/// @param cell_hint  of the refusal of a field of cells
render::Dataset load_with_hint(const std::filesystem::path& path, const std::string& field, const DataAccess& access,
                               const std::vector<std::string>& others, formats::Space world,
                               const std::string& cell_hint) {
  const formats::PackedFile file = open(path, names_of(field, others), access).file;
  if (file.description().kind == "vdb") return render::Dataset::load(file);
  if (field.empty()) return load_field_that_varies(file, world);
  try {
    return render::Dataset::load(file, field, world);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::usage) throw;
    const render::Dataset other = render::Dataset::load(file);
    const std::string hint = other.field(field) ? cell_hint : did_you_mean(field, other.field_names());
    throw Error(error.code(), error.what(), hint.empty() ? error.hint() : hint);
  }
}

}  // namespace

render::Dataset load_shown(const std::filesystem::path& path, const std::string& field, const DataAccess& access,
                           const std::vector<std::string>& others, formats::Space world) {
  return load_with_hint(path, field, access, others, world,
                        concat("it is a field of cells: --color-by ", field, " shows it"));
}

render::Dataset load_dataset(const std::filesystem::path& path, const std::string& field, const DataAccess& access) {
  const render::Dataset dataset = load_with_hint(path, field, access, {}, formats::Space::unknown, cell_field_hint);
  if (dataset.is_surface()) refuse_surface(path);
  return dataset;
}

std::filesystem::path packed_data_path(const std::filesystem::path& path, const std::string& field,
                                       const DataAccess& access) {
  const std::filesystem::path packed = packed_path(path, field, access);
  if (formats::PackedFile::open(packed).description().kind == formats::TriangleMesh::kind) refuse_surface(path);
  return packed;
}

std::filesystem::path packed_path(const std::filesystem::path& path, const std::string& field,
                                  const DataAccess& access) {
  const preprocess::OpenedData opened = open(path, names_of(field, {}), access);
  if (!opened.path.empty()) return opened.path;
  if (opened.file.description().kind == "vdb")
    throw Error(ErrorCode::unsupported, concat(path.string(), ": is an OpenVDB file; expected a packed file"),
                concat("pack it first: ", shell_line({"rhoray", "pack", path.string()})));
  throw Error(ErrorCode::resource,
              concat(path.string(), ": its packed copy could not be kept",
                     opened.not_kept.empty() ? "" : concat(": ", opened.not_kept)),
              concat("pack it first: ", shell_line({"rhoray", "pack", path.string()})));
}

std::optional<Segmentation> segmentation_in(const render::DataSpec& data, const DataAccess& access) {
  const formats::PackedFile file = open(data.file, names_of(data.field, {}), reading(data, access)).file;
  if (file.description().kind != "grid") return std::nullopt;
  const std::string name =
      data.field.empty() ? load_field_that_varies(file, formats::Space::unknown).field().name : data.field;
  formats::BrickGrid grid(file);
  const std::optional<std::size_t> field = grid.find_field(name);
  if (!field) return std::nullopt;  // refused where the data are loaded
  std::optional<std::vector<preprocess::Label>> labels = preprocess::find_labels(grid, *field);
  if (!labels) return std::nullopt;
  return Segmentation{std::move(grid), *field, std::move(*labels)};
}

std::optional<Regions> regions_in(const render::DataSpec& data, const DataAccess& access) {
  const formats::PackedFile file = open(data.file, names_of(data.field, {}), reading(data, access)).file;
  if (file.description().kind != "tets" || !file.has("cell_field.0")) return std::nullopt;
  const formats::TetMesh mesh(file);
  const formats::TetMeshDescription& description = mesh.description();
  const auto regions_of = [&](std::size_t field) -> std::optional<Regions> {
    std::optional<std::vector<preprocess::CellLabel>> labels = preprocess::find_labels(mesh, field);
    if (!labels) return std::nullopt;
    return Regions{description.cell_fields[field].name, std::move(*labels), description.cell_fields[field].label_names};
  };
  std::string name = data.field;
  if (name.empty()) {
    const auto first = std::find_if(description.fields.begin(), description.fields.end(), varies);
    name = first == description.fields.end() ? description.fields.front().name : first->name;
  }
  if (const std::optional<std::size_t> field = mesh.find_cell_field(name)) return regions_of(*field);
  if (!data.field.empty() || name != formats::boundary_distance) return std::nullopt;
  for (std::size_t field = 0; field < description.cell_fields.size(); ++field)
    if (auto regions = regions_of(field)) return regions;
  return std::nullopt;
}

namespace {

render::Dataset load_label(const render::DataSpec& data, formats::Space world, const DataAccess& access) {
  const std::optional<Segmentation> segmentation = segmentation_in(data, access);
  std::vector<std::string> known;
  if (segmentation)
    for (const preprocess::Label& label : segmentation->labels) {
      known.push_back(concat(label.value));
      if (label.value == *data.label)
        return render::Dataset::load(preprocess::pack_indicator(segmentation->grid, segmentation->field, label), {},
                                     world);
    }
  throw Error(ErrorCode::invalid,
              concat(data.file.string(), ": ",
                     segmentation ? concat("holds the labels ", joined(known)) : "is not a segmentation",
                     "; expected label ", *data.label));
}

/// Opens a file of colours, or packs the colours of a file that is not packed.
formats::PackedFile open_colors(const render::DataSpec& data, const DataAccess& access) {
  preprocess::require_input(data.file);
  const preprocess::ForeignKind kind = preprocess::foreign_kind(data.file);
  if (formats::PackedFile::looks_packed(data.file) || data.file.extension() == ".rho" ||
      kind == preprocess::ForeignKind::volume)
    return open(data.file, {}, reading(data, access), true).file;
  throw Error(ErrorCode::unsupported,
              concat(kind == preprocess::ForeignKind::unknown ? preprocess::unsupported_type(data.file)
                                                              : concat(data.file.string(), ": is a ", name_of(kind)),
                     "; expected colours"),
              "a folder of pictures, .nrrd, .mha, .nii, .npy and .vti can hold them");
}

}  // namespace

render::ResolvedScene resolve_layers(const render::SceneSpec& scene_spec, const DataAccess& access) {
  std::map<std::pair<std::filesystem::path, std::string>, render::Dataset> meshes;  // with labels; by file and time
  const auto load = [&](const render::DataSpec& data, const std::vector<std::string>& others, formats::Space world) {
    if (data.label) {
      const auto known = meshes.find({data.file, data.read.time});
      if (known != meshes.end()) return known->second;
      const formats::PackedFile file = open(data.file, names_of(data.field, {}), reading(data, access)).file;
      if (file.description().kind != "tets") return load_label(data, world, access);
      return meshes.emplace(std::pair(data.file, data.read.time), load_field_that_varies(file, world)).first->second;
    }
    return load_shown(data.file, data.field, reading(data, access), others, world);
  };
  const auto open_data = [&](const render::DataSpec& data, formats::Space world) {
    std::vector<std::string> others;
    for (const render::LayerSpec& layer : scene_spec.layers)
      if (layer.data == data.name) others.push_back(layer.color_by);
    if (!access.loaded) return load(data, others, world);
    const std::pair key(data.name, data.field);
    const auto known = access.loaded->find(key);
    if (known != access.loaded->end() && has_fields(known->second, others)) return known->second;
    return access.loaded->insert_or_assign(key, load(data, others, world)).first->second;
  };
  return render::resolve_layers(scene_spec, open_data,
                                [&](const render::DataSpec& data) { return open_colors(data, access); });
}

preprocess::PackCache open_cache() {
  return preprocess::PackCache(preprocess::PackCache::default_folder(), cache_limit_bytes());
}

}  // namespace rhoray::tools

#include "tools/rhoray/data_choice.h"

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "preprocess/open_vdb.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::tools {

namespace {

bool varies(const formats::FieldSummary& field) {
  return field.range.lo < field.range.hi;
}

/// The first field, or if it is constant the first field that is not.
render::Dataset load_field_that_varies(const std::filesystem::path& path) {
  const render::Dataset first = render::Dataset::load(path);
  if (varies(first.field())) return first;
  for (const std::string& name : first.field_names()) {
    const render::Dataset other = render::Dataset::load(path, name);
    if (varies(other.field())) return other;
  }
  return first;
}

}  // namespace

void require_packed(const std::filesystem::path& path) {
  if (formats::PackedFile::looks_packed(path) || path.extension() == ".rho") return;
  const std::filesystem::path packed = std::filesystem::path(path.filename()).replace_extension(".rho");
  throw Error(ErrorCode::unsupported, concat(path.string(), ": is not a packed file"),
              preprocess::foreign_kind(path) == preprocess::ForeignKind::unknown
                  ? std::string("`rhoray formats` lists what can be packed")
                  : concat("pack it first: ", shell_line({"rhoray", "pack", path.string(), "-o", packed.string()})));
}

render::Dataset load_shown(const std::filesystem::path& path, const std::string& field) {
  preprocess::require_input(path);
  if (preprocess::is_vdb(path)) return render::Dataset::load(preprocess::open_vdb(path, field));
  require_packed(path);
  if (field.empty()) return load_field_that_varies(path);
  try {
    return render::Dataset::load(path, field);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::usage) throw;
    const std::string hint = did_you_mean(field, render::Dataset::load(path).field_names());
    throw Error(error.code(), error.what(), hint.empty() ? error.hint() : hint);
  }
}

render::Dataset load_dataset(const std::filesystem::path& path, const std::string& field) {
  const render::Dataset dataset = load_shown(path, field);
  if (dataset.is_surface())
    throw Error(ErrorCode::unsupported,
                concat(path.string(), ": holds a surface; expected a grid or a mesh with fields"),
                concat("show it: rhoray render ", path.string()));
  return dataset;
}

render::ResolvedScene resolve_layers(const render::SceneSpec& scene_spec) {
  return render::resolve_layers(scene_spec,
                                [](const render::DataSpec& data) { return load_shown(data.file, data.field); });
}

}  // namespace rhoray::tools

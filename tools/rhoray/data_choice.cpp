#include "tools/rhoray/data_choice.h"

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/color_grid.h"
#include "formats/shape_field.h"
#include "preprocess/input_file.h"
#include "preprocess/open_vdb.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/option_values.h"

namespace rhoray::tools {

namespace {

/// "0 to 255 HU of field 'density'".
std::string range_text(const formats::FieldSummary& field) {
  return concat(field.range.lo, " to ", field.range.hi, field.unit.empty() ? "" : " ", field.unit, " of field '",
                field.name, "'");
}

}  // namespace

Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field) {
  if (field.range.is_empty()) throw Error(ErrorCode::invalid, concat("field '", field.name, "' holds no finite value"));
  if (text == "auto" && field.name == formats::boundary_distance && field.range.hi > 0)
    return {formats::shape_share_of_distance * field.range.hi, "1/10000 of the largest distance"};
  if (text == "auto") {
    const std::optional<double> threshold = formats::otsu_threshold(field);
    if (!threshold)
      throw Error(ErrorCode::usage,
                  concat("field '", field.name, "' is constant (", field.range.lo, "), so it has no isosurface"));
    return {*threshold, "Otsu's threshold"};
  }
  const bool is_percentile = text.starts_with("p");
  double value = 0;
  try {
    read_value(is_percentile ? text.substr(1) : text, value);
  } catch (const Error&) {
    throw Error(ErrorCode::usage,
                concat("--iso: found '", text, "'; expected a number, a percentile such as p95, or auto"));
  }
  if (is_percentile) {
    if (!(value >= 0 && value <= 100))
      throw Error(ErrorCode::usage, concat("--iso ", text, ": percentiles run from 0 to 100"));
    return {formats::percentile(field, value / 100), concat("percentile ", value)};
  }
  if (!field.range.contains(value))
    throw Error(ErrorCode::usage, concat("isovalue ", value, " is outside the range ", range_text(field)),
                "auto chooses one from the histogram");
  return {value, "given"};
}

bool is_outside(const std::string& isovalue, const formats::FieldSummary& field) {
  try {
    double value = 0;
    read_value(isovalue, value);
    return !field.range.contains(value);
  } catch (const Error&) {
    return false;
  }
}

namespace {

bool varies(const formats::FieldSummary& field) {
  return field.range.lo < field.range.hi;
}

/// The first field, or if it is constant the first field that is not.
render::Volume load_field_that_varies(const std::filesystem::path& path) {
  const render::Volume first = render::Volume::load(path);
  if (varies(first.field())) return first;
  for (const std::string& name : first.field_names()) {
    const render::Volume other = render::Volume::load(path, name);
    if (varies(other.field())) return other;
  }
  return first;
}

}  // namespace

render::Volume load_shown(const std::filesystem::path& path, const std::string& field) {
  preprocess::require_input(path);
  if (preprocess::is_vdb(path)) return render::Volume::load(preprocess::open_vdb(path, field));
  if (!formats::PackedFile::looks_packed(path) && preprocess::foreign_kind(path) != preprocess::ForeignKind::unknown) {
    const std::filesystem::path packed = std::filesystem::path(path.filename()).replace_extension(".rho");
    throw Error(ErrorCode::invalid, concat(path.string(), ": is not a packed file"),
                concat("pack it first: ", shell_line({"rhoray", "pack", path.string(), "-o", packed.string()})));
  }
  if (field.empty()) return load_field_that_varies(path);
  try {
    return render::Volume::load(path, field);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::usage) throw;
    const std::string hint = did_you_mean(field, render::Volume::load(path).field_names());
    throw Error(error.code(), error.what(), hint.empty() ? error.hint() : hint);
  }
}

render::Volume load_volume(const std::filesystem::path& path, const std::string& field) {
  const render::Volume volume = load_shown(path, field);
  if (volume.is_surface())
    throw Error(ErrorCode::invalid, concat(path.string(), ": holds a surface; expected a grid or a mesh with fields"),
                concat("show it: rhoray render ", path.string()));
  return volume;
}

render::Texture load_texture(const std::filesystem::path& path) {
  preprocess::require_input(path);
  const auto refuse = [&](const std::string& found) {
    throw Error(ErrorCode::invalid, concat(path.string(), ": ", found, "; expected a packed file of colours"),
                "rhoray pack --color makes one from a folder of pictures, .nrrd, .mha or .vti");
  };
  if (!formats::PackedFile::looks_packed(path)) refuse("is not a packed file");
  const formats::PackedFile file = formats::PackedFile::open(path);
  const std::string& kind = file.description().kind;
  if (kind != formats::ColorGrid::kind) refuse(concat("holds a ", kind == "tets" ? "mesh" : kind));
  return render::Texture::load(file);
}

}  // namespace rhoray::tools

#include "render/document/material.h"

#include <algorithm>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/word_list.h"
#include "formats/shape_field.h"
#include "render/color_map.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

/// A refusal that names the key of a document's layer, or the option.
Error refusal(const Place& layer, const std::string& key, const std::string& option, const std::string& fact,
              const std::string& hint = {}, ErrorCode error_code = ErrorCode::usage) {
  if (layer.document.empty()) return {error_code, concat(option, ": ", fact), hint};
  return {error_code == ErrorCode::usage ? ErrorCode::invalid : error_code, concat(layer.at(key).text(), ": ", fact),
          hint};
}

/// Returns the kind of the dataset, for messages.
const char* kind_of(const Dataset& dataset) {
  if (dataset.is_mesh()) return "mesh";
  if (!dataset.is_surface()) return "grid";
  return dataset.has_fields() ? "mesh" : "surface";  // a boundary has the mesh's fields
}

Normals choose_normals(const LayerSpec& spec, const Style& style, const Dataset& dataset, const Place& layer) {
  for (const NamedNormals& row : named_normals()) {
    if (spec.normals != row.name) continue;
    if (!(has_flat_normals(dataset) ? row.of_meshes : row.of_grids))
      throw refusal(layer, "normals", "--normals",
                    concat("'", row.name, "' applies only to ", row.of_meshes ? "meshes" : "grids", ", and ",
                           dataset.file().name(), " is a ", kind_of(dataset)),
                    row.of_grids ? "use flat or smooth" : "use exact, the gradient of the trilinear field, or smooth");
    return row.normals;
  }
  return style.has_smooth_normals && !dataset.is_mesh() ? Normals::smooth : Normals::exact;
}

/// The field that colours the surface; refuses one that it cannot be coloured by.
formats::FieldSummary color_field(const LayerSpec& spec, const Dataset& dataset, const Place& layer) {
  const std::vector<std::string> names = dataset.color_names();
  const auto refuse = [&](const std::string& fact, const std::string& hint, ErrorCode error_code) {
    return refusal(layer, "color_by", "--color-by", fact, hint, error_code);
  };
  if (std::find(names.begin(), names.end(), spec.color_by) == names.end()) {
    throw refuse(concat("no field '", spec.color_by, "'; available: ", joined(names, ", ", "'")),
                 did_you_mean(spec.color_by, names), ErrorCode::usage);
  }
  const std::optional<formats::FieldSummary> field = dataset.field(spec.color_by);
  if (!field)
    throw refuse(
        concat("'", spec.color_by, "' is another grid of ", dataset.file().name(),
               ", with other voxels; a surface can be coloured only by its own field, '", dataset.field().name, "'"),
        {}, ErrorCode::unsupported);
  if (field->range.is_empty())
    throw refuse(concat("field '", field->name, "' holds no finite value"), {}, ErrorCode::invalid);
  return *field;
}

bool holds_floats(const formats::FieldSummary& field) {
  return field.type == formats::ElementType::F32 || field.type == formats::ElementType::F64;
}

}  // namespace

ColorScale color_scale(const LayerSpec& spec) {
  return {.is_logarithmic = spec.scale == "log", .levels = spec.levels.value_or(0)};
}

void say_scale(const ColorScale& scale, LayerSpec& spec) {
  if (scale.is_logarithmic) spec.scale = "log";
  if (scale.levels > 0) spec.levels = scale.levels;
}

Interval<double> color_range(const LayerSpec& spec, const formats::FieldSummary& field,
                             const Interval<double>& otherwise, const Place& layer) {
  const Interval<double> range = spec.range.value_or(otherwise);
  if (!color_scale(spec).is_logarithmic || range.lo > 0) return range;
  if (spec.range)
    throw refusal(layer, "range", "--range",
                  concat("found ", range.lo, " to ", range.hi, "; a logarithmic scale needs values above 0"),
                  "start the range above 0, or use the linear scale");
  if (!(range.hi > 0))
    throw refusal(layer, "scale", "--color-scale",
                  concat("field '", field.name, "' has no values above 0, which a logarithmic scale needs"));
  // The smallest value above 0 of a field that also has values below 0 is often noise.
  constexpr double least_share = 1e-4;
  const double least = least_share * range.hi;
  return {holds_floats(field) || range.hi <= 1 ? least : std::max(least, 1.0), range.hi};
}

FieldColors field_colors(const LayerSpec& spec, const formats::FieldSummary& field, const Place& layer) {
  // Integers are codes of an instrument: a zero among them is not the middle of anything.
  const bool has_center = holds_floats(field) && field.range.lo < 0 && field.range.hi > 0;
  FieldColors colors{.field = field.name, .range = field.range, .scale = color_scale(spec)};
  if (spec.colormap.empty() && has_center && !colors.scale.is_logarithmic) {
    colors.map = ColorMap::coolwarm;
    const double end = std::max(-field.range.lo, field.range.hi);
    colors.range = {-end, end};
  }
  colors.range = color_range(spec, field, colors.range, layer);
  for (const NamedColorMap& named : color_maps())
    if (spec.colormap == named.name) colors.map = named.map;
  return colors;
}

Material choose_material(const LayerSpec& spec, const Style& style, const Dataset& dataset, const Place& layer) {
  Material surface;
  if (spec.color) surface.color = spec.color->linear;
  surface.ambient = spec.ambient.value_or(style.ambient);
  surface.specular = spec.specular.value_or(style.specular);
  surface.shininess = spec.shininess.value_or(surface.shininess);
  surface.opacity = spec.opacity.value_or(surface.opacity);
  surface.normals = choose_normals(spec, style, dataset, layer);
  if (!spec.color_by.empty()) {
    surface.color_by = field_colors(spec, color_field(spec, dataset, layer), layer);
    return surface;
  }
  const std::string needs = layer.document.empty() ? "needs --color-by" : "needs \"color_by\"";
  if (!spec.colormap.empty()) throw refusal(layer, "colormap", "--colormap", needs);
  if (!spec.scale.empty()) throw refusal(layer, "scale", "--color-scale", needs);
  if (spec.levels) throw refusal(layer, "levels", "--levels", needs);
  if (spec.range) throw refusal(layer, "range", "--range", "on a surface, " + needs);
  return surface;
}

Material choose_boundary_material(LayerSpec spec, const Style& style, const Dataset& boundary, const Place& layer) {
  const formats::FieldSummary field = boundary.field(boundary.field().name).value_or(boundary.field());
  const bool shows_field = field.range.lo < field.range.hi && field.name != formats::boundary_distance;
  if (spec.color_by.empty() && !spec.color && spec.texture.empty() && shows_field) spec.color_by = field.name;
  return choose_material(spec, style, boundary, layer);
}

}  // namespace rhoray::render

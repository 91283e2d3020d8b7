#include "render/document/slices.h"

#include <optional>
#include <string>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "render/document/material.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

const std::vector<std::string> axis_words{"x", "y", "z"};

std::optional<int> axis_named(const std::string& word) {
  for (std::size_t axis = 0; axis < axis_words.size(); ++axis)
    if (axis_words[axis] == word) return static_cast<int>(axis);
  return std::nullopt;
}

/// Refuses a plane given twice or incompletely.
void check_plane(const LayerSpec& spec, const Place& place) {
  const bool has_axis = !spec.axis.empty(), has_plane = spec.point || spec.normal;
  const auto refuse = [&](const Place& at, const std::string& fact) {
    throw Error(ErrorCode::invalid, concat(at.text(), ": ", fact));
  };
  if (has_axis && has_plane)
    refuse(place.at("axis"), "\"point\" or \"normal\" is also given; expected only one of the two");
  if (!has_axis && spec.position) refuse(place.at("position"), "needs \"axis\"");
  if (!has_axis && !spec.normal) refuse(place, "has no plane; expected \"axis\", or \"point\" and \"normal\"");
}

HalfSpace plane_of(const LayerSpec& spec, const Vec3& middle) {
  if (spec.axis.empty()) return {.point = spec.point.value_or(middle), .normal = *spec.normal};
  const int axis = *axis_named(spec.axis);
  HalfSpace plane{.point = middle, .normal = {0, 0, 0}};
  plane.point[axis] = spec.position.value_or(middle[axis]);
  plane.normal[axis] = 1;
  return plane;
}

/// Returns the world axis that a vector is parallel to, or nothing.
std::optional<int> axis_of(const Vec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 rest = normal;
    rest[axis] = 0;
    if (rest == Vec3(0, 0, 0)) return axis;
  }
  return std::nullopt;
}

std::string vector_text(const Vec3& v) {
  return concat("(", rounded(v.x), ", ", rounded(v.y), ", ", rounded(v.z), ")");
}

}  // namespace

std::vector<Row<LayerSpec>> scale_rows() {
  return {row("scale", &LayerSpec::scale, word_value(scale_words()),
              "\"log\": colours follow the logarithm of the value; the range lies above 0, by default from 1/10000 of "
              "the largest value if the field does not; default \"linear\""),
          row("levels", &LayerSpec::levels, whole_number_within(limits::levels),
              "Number of colours: bands that divide the range evenly on its scale; default continuous colours")};
}

std::vector<Row<LayerSpec>> slice_rows() {
  return {
      row("axis", &LayerSpec::axis, word_value(axis_words), "World axis perpendicular to the plane"),
      row("position", &LayerSpec::position, number(),
          "Position on the axis in world units; default the middle of the data"),
      row("point", &LayerSpec::point, vector_value(),
          "With \"normal\", instead of \"axis\": a point of the plane; default the middle of the data"),
      row("normal", &LayerSpec::normal, direction_value(), "Normal of the plane, of either sign and any length"),
      row("colormap", &LayerSpec::colormap, word_value(colormap_words()),
          "Colour map of the field; default \"viridis\", or \"coolwarm\" with 0 in its middle for floating-point "
          "fields "
          "of both signs"),
      row("range", &LayerSpec::range, interval_value(),
          "Values of the first and last colour; default the field's range"),
      row("threshold", &LayerSpec::threshold, interval_value(),
          "Show only values within this range; default all values"),
      row("lit", &LayerSpec::lit, yes_or_no(), "true: lights shade the slice; default false: the map's own colours"),
      row("opacity", &LayerSpec::opacity, number_within(limits::share), "Opacity; default 1")};
}

void choose_slice(const LayerSpec& spec, const Dataset& dataset, const Place& place, Layer& layer) {
  check_plane(spec, place);
  const formats::FieldSummary& field = dataset.field();
  if (field.range.is_empty())
    throw Error(ErrorCode::invalid, concat(place.document.empty() ? "--slice" : place.text(), ": field '", field.name,
                                           "' holds no finite value"));
  layer.mode = Mode::slice;
  layer.plane = plane_of(spec, dataset.bounds().center());
  if (spec.threshold) layer.threshold = *spec.threshold;
  layer.material.color_by = field_colors(spec, field, place);
  layer.material.specular = 0;
  layer.material.lit = spec.lit.value_or(false);
  layer.material.opacity = spec.opacity.value_or(1);
}

void say_slice(const Layer& layer, LayerSpec& spec) {
  spec.type = LayerType::slice;
  spec.point = layer.plane.point, spec.normal = layer.plane.normal;
  const FieldColors& colors = *layer.material.color_by;
  spec.colormap = word_of(colors.map);
  say_scale(colors.scale, spec);
  if (colors.range.lo < colors.range.hi) spec.range = colors.range;  // else the field's, as without
  if (layer.threshold != Layer{}.threshold) spec.threshold = layer.threshold;
  spec.lit = layer.material.lit;
  spec.opacity = layer.material.opacity;
}

std::string text_of_slice(const HalfSpace& plane) {
  if (const std::optional<int> axis = axis_of(plane.normal))
    return concat(std::string(1, "xyz"[*axis]), " = ", rounded(plane.point[*axis]));
  return concat("through ", vector_text(plane.point), " with normal ", vector_text(plane.normal));
}

std::string text_of_slice_outside(const HalfSpace& plane, const Box3& bounds) {
  const std::string fact = concat("the slice ", text_of_slice(plane), " lies outside the data");
  const std::optional<int> axis = axis_of(plane.normal);
  return axis ? concat(fact, " (", rounded(bounds.min[*axis]), " to ", rounded(bounds.max[*axis]), ")") : fact;
}

}  // namespace rhoray::render

#include "tools/rhoray/scene/slices.h"

#include <optional>
#include <string>

#include "formats/base/text.h"
#include "formats/base/trouble.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/scene/clip.h"
#include "tools/rhoray/scene/looks.h"

namespace rhoray::tools {

namespace {

const std::vector<std::string> axis_words{"x", "y", "z"};

std::optional<int> axis_named(const std::string& word) {
  for (std::size_t axis = 0; axis < axis_words.size(); ++axis)
    if (axis_words[axis] == word) return static_cast<int>(axis);
  return std::nullopt;
}

/// z, z=40, or px,py,pz,nx,ny,nz.
LayerWish read_slice(const std::string& text) {
  LayerWish wish{.type = LayerType::slice};
  const std::size_t equals = text.find('=');
  const std::string expected =
      "an axis and a position such as z=40, an axis alone for the middle of the data, or a point and a normal "
      "px,py,pz,nx,ny,nz";
  const auto refuse = [&] { return Error(Trouble::usage, concat("found '", text, "'; expected ", expected)); };
  try {
    if (axis_named(text.substr(0, equals))) {
      wish.axis = text.substr(0, equals);
      if (equals != std::string::npos) read_value(text.substr(equals + 1), wish.position);
      return wish;
    }
    const render::HalfSpace plane = read_half_space(text);
    wish.point = plane.point, wish.normal = plane.normal;
    return wish;
  } catch (const Error&) {
    throw refuse();
  }
}

/// Refuses what of a wish's plane does not go together.
void check_plane(const LayerWish& wish, const Place& place) {
  const bool has_axis = !wish.axis.empty(), has_plane = wish.point || wish.normal;
  const auto refuse = [&](const Place& at, const std::string& fact) {
    throw Error(Trouble::invalid, concat(at.text(), ": ", fact));
  };
  if (has_axis && has_plane) refuse(place.at("axis"), "\"point\" or \"normal\" is there too; expected one of the two");
  if (!has_axis && wish.position) refuse(place.at("position"), "is of an axis; expected \"axis\" too");
  if (!has_axis && !wish.normal) refuse(place, "has no plane; expected \"axis\", or \"point\" and \"normal\"");
}

render::HalfSpace plane_of(const LayerWish& wish, const Vec3& middle) {
  if (wish.axis.empty()) return {.point = wish.point.value_or(middle), .normal = *wish.normal};
  const int axis = *axis_named(wish.axis);
  render::HalfSpace plane{.point = middle, .normal = {0, 0, 0}};
  plane.point[axis] = wish.position.value_or(middle[axis]);
  plane.normal[axis] = 1;
  return plane;
}

std::string vector_text(const Vec3& v) {
  return concat("(", rounded(v.x), ", ", rounded(v.y), ", ", rounded(v.z), ")");
}

}  // namespace

std::vector<Row<LayerWish>> slice_rows() {
  return {
      row("axis", &LayerWish::axis, word_value(axis_words), "The plane lies across this axis of the world"),
      row("position", &LayerWish::position, number(),
          "Where it crosses the axis, in world units; default the middle of the data"),
      row("point", &LayerWish::point, vector_value(),
          "Instead, with \"normal\": a place in the plane; default the middle of the data"),
      row("normal", &LayerWish::normal, direction_value(), "Across the plane, either way, of any length"),
      row("colormap", &LayerWish::colormap, word_value(colormap_words()), "Colours of the field; default \"viridis\""),
      row("range", &LayerWish::range, interval_value(),
          "Values from the map's first colour to its last; default the field's range"),
      row("threshold", &LayerWish::threshold, interval_value(),
          "Shown only where the field has values from the first to the second; default wherever it has any"),
      row("lit", &LayerWish::lit, yes_or_no(), "true: lights shine on it; default false: the map's own colours"),
      row("opacity", &LayerWish::opacity, number_within(limits::share),
          "Share of the light behind that the slice holds back; default 1")};
}

Option slice_option(std::vector<LayerWish>& slices) {
  return {
      Option::Kind::value, "--slice", "AXIS[=POSITION]...",
      "Show the field on a plane, in colours of --colormap over --range: z=40 lies across z at 40 world units, z in "
      "the middle of the data, px,py,pz,nx,ny,nz through a point across a normal; may be given several times. "
      "With --mode or --iso slices are shown beside that, else by themselves",
      [&slices](const std::string& text) { slices.push_back(read_slice(text)); }};
}

void choose_slice(const LayerWish& wish, const render::Volume& volume, const Place& place, render::Layer& layer) {
  check_plane(wish, place);
  const formats::FieldSummary& field = volume.field();
  if (field.range.is_empty())
    throw Error(Trouble::invalid, concat(place.document.empty() ? "--slice" : place.text(), ": field '", field.name,
                                         "' holds no finite value"));
  layer.mode = render::Mode::slice;
  layer.plane = plane_of(wish, volume.bounds().center());
  if (wish.threshold) layer.threshold = *wish.threshold;
  render::FieldColors colors{.field = field.name, .range = wish.range.value_or(field.range)};
  for (const render::NamedColorMap& named : render::color_maps())
    if (wish.colormap == named.name) colors.map = named.map;
  layer.surface.color_by = colors;
  layer.surface.specular = 0;
  layer.surface.lit = wish.lit.value_or(false);
  layer.surface.opacity = wish.opacity.value_or(1);
}

void say_slice(const render::Layer& layer, LayerWish& wish) {
  wish.type = LayerType::slice;
  wish.point = layer.plane.point, wish.normal = layer.plane.normal;
  const render::FieldColors& colors = *layer.surface.color_by;
  wish.colormap = word_of(colors.map);
  if (colors.range.lo < colors.range.hi) wish.range = colors.range;  // else the field's, as without
  if (layer.threshold != render::Layer{}.threshold) wish.threshold = layer.threshold;
  wish.lit = layer.surface.lit;
  wish.opacity = layer.surface.opacity;
}

std::string text_of_slice(const render::HalfSpace& plane) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 rest = plane.normal;
    rest[axis] = 0;
    if (rest == Vec3(0, 0, 0))
      return concat("across ", axis_words[static_cast<std::size_t>(axis)], " at ", rounded(plane.point[axis]));
  }
  return concat("through ", vector_text(plane.point), " across ", vector_text(plane.normal));
}

}  // namespace rhoray::tools

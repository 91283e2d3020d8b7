#include "tools/rhoray/scene/tables.h"

#include <algorithm>

#include "formats/base/error.h"
#include "tools/rhoray/method_names.h"
#include "tools/rhoray/scene/clip.h"
#include "tools/rhoray/scene/material.h"
#include "tools/rhoray/scene/picture_names.h"
#include "tools/rhoray/scene/slices.h"

namespace rhoray::tools {

namespace {

using Rows = std::vector<Row<LayerSpec>>;

Rows operator+(Rows rows, const Rows& more) {
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

Rows rows_of_data() {
  return {
      row("data", &LayerSpec::data, text_value(), "Name of the data shown; may be left out where there is only one"),
      row("visible", &LayerSpec::visible, yes_or_no(), "false: the layer is left out, its file is not opened"),
      row("clip", &LayerSpec::clip, yes_or_no(), "false: shown whole, whatever the scene's \"clip\" takes away")};
}

Rows rows_of_every_layer() {
  return rows_of_data() + Rows{row("accuracy", &LayerSpec::accuracy, word_value(accuracy_words()),
                                   "How right the layer is drawn; default the scene's accuracy")};
}

Rows rows_of_every_field() {
  return {
      row("method", &LayerSpec::method, method_value(), "One method by name instead of an accuracy, for comparison")};
}

Rows rows_of_isosurfaces() {
  return {
      row("isovalue", &LayerSpec::isovalues, isovalues_value(),
          "Value of the surface; \"auto\" is Otsu's threshold, several values are several layers; default \"auto\""),
      row("color", &LayerSpec::color, color_value(),
          "Default neutral; in scenes of several surfaces each has one of its own"),
      row("normals", &LayerSpec::normals, word_value(normals_words()),
          "What lights it: \"flat\", in a mesh the exact gradient of each cell, the default there; \"smooth\", in a "
          "mesh linear between means at the points; \"exact\", in a grid the gradient of its trilinear field"),
      row("color_by", &LayerSpec::color_by, text_value(),
          "A field of the same file that colours the surface; where it has no data \"color\" stays"),
      row("colormap", &LayerSpec::colormap, word_value(colormap_words()),
          "Colours of \"color_by\"; default \"viridis\""),
      row("range", &LayerSpec::range, interval_value(),
          "Values of \"color_by\" from the map's first colour to its last; default the field's range")};
}

Rows rows_of_triangles() {
  return {row("color", &LayerSpec::color, color_value(),
              "Default neutral; in scenes of several surfaces each has one of its own"),
          row("normals", &LayerSpec::normals, word_value({"flat", "smooth"}),
              "What lights it: \"flat\", the normal of each triangle, the default; \"smooth\", linear between means at "
              "the corners")};
}

Rows rows_of_lit_surfaces() {
  return {
      row("texture", &LayerSpec::texture, text_value(),
          "Name of data packed with --color, whose colours, registered in world axes, cover the surface; "
          "where there are none, \"color\" stays"),
      row("ambient", &LayerSpec::ambient, number_within(limits::share), "Share of light from all sides; default 0.12"),
      row("specular", &LayerSpec::specular, number_within(limits::share),
          "Strength of the highlight; 0 computes none; default 0.25"),
      row("shininess", &LayerSpec::shininess, number_within(limits::shininess),
          "Exponent of the highlight: larger is smaller and sharper; default 40"),
      row("opacity", &LayerSpec::opacity, number_within(limits::share),
          "Share of the light behind that the surface holds back; 0: it is not traced; default 1")};
}

Rows rows_of_projections() {
  return {
      row("range", &LayerSpec::range, interval_value(), "Values shown from black to white; default the field's range")};
}

Row<LightSpec> color_row() {
  return row("color", &LightSpec::color, color_value(), "Default white");
}
Row<LightSpec> intensity_row() {
  return row("intensity", &LightSpec::intensity, number_within(limits::intensity),
             "How strong it is; default 1; 0: it is not traced");
}
Row<LightSpec> shadows_row() {
  return row("shadows", &LightSpec::shadows, yes_or_no(), "true: opaque isosurfaces hold it back; default false");
}
Row<LightSpec> samples_row() {
  return row("samples", &LightSpec::samples, whole_number_within(limits::light_samples),
             "Shadow rays of each hit to points spread over a light that has a size: more are slower and less grainy; "
             "default 16");
}

template <class Object>
bool has_key(const Kind<Object>& kind, const std::string& key) {
  return std::any_of(kind.rows.begin(), kind.rows.end(), [&](const Row<Object>& row) { return row.key == key; });
}

/// Refuses a key that only objects of other types have.
/// @param noun  what the objects are
template <class Object>
void refuse_keys_of_others(const Json& json, const Kind<Object>& kind, std::span<const Kind<Object>> kinds,
                           const char* noun, const Reading& at) {
  for (const auto& [key, value] : json.items())
    for (const Kind<Object>& other : kinds)
      if (!has_key(kind, key) && has_key(other, key))
        throw Error(ErrorCode::invalid, concat(at.place.at(key).text(), ": found in a ", noun, " of type \"", kind.word,
                                               "\"; expected in one of type \"", other.word, '"'));
}

template <class Object>
const Kind<Object>& kind_said(const Json& json, std::span<const Kind<Object>> kinds, const Reading& at) {
  std::vector<std::string> words;
  for (const Kind<Object>& kind : kinds) words.emplace_back(kind.word);
  const ValueKind<std::string> type = word_value(words);
  if (!json.contains("type")) refuse_missing_key("type", type.expected, at);
  const std::string word = type.read(json["type"], at.at("type"));
  return *std::find_if(kinds.begin(), kinds.end(), [&](const Kind<Object>& kind) { return word == kind.word; });
}

template <class Object>
Object read_by_type(const Json& json, std::span<const Kind<Object>> kinds, const char* noun, const Reading& at) {
  if (!json.is_object()) at.place.refuse(json, "an object");
  const Kind<Object>& kind = kind_said(json, kinds, at);
  Json rest = json;
  rest.erase("type");
  refuse_keys_of_others(rest, kind, kinds, noun, at);
  Object object = read_object(rest, at, kind.rows);
  object.type = kind.type;
  return object;
}

template <class Object>
Json schema_of(const Kind<Object>& kind) {
  const Json of_rows = schema_of(kind.rows);
  Json schema{{"title", kind.word}, {"description", kind.help}};
  schema.update(of_rows);
  schema["properties"] = Json{{"type", {{"const", kind.word}}}};
  schema["properties"].update(of_rows["properties"]);
  schema["required"] = Json::array({"type"});
  if (of_rows.contains("required"))
    for (const Json& key : of_rows["required"]) schema["required"].push_back(key);
  return schema;
}

/// A list of objects that say their type.
template <class Object>
ValueKind<std::vector<Object>> list_by_type(std::span<const Kind<Object>> kinds, const char* noun,
                                            const Interval<std::size_t>& counts) {
  const std::string expected = concat("an array of ", counts.lo, " to ", counts.hi, " ", noun, "s");
  Json schemas = Json::array();
  for (const Kind<Object>& kind : kinds) schemas.push_back(schema_of(kind));
  Json schema{{"type", "array"}, {"minItems", counts.lo}, {"maxItems", counts.hi}};
  schema["items"]["oneOf"] = std::move(schemas);
  return {.expected = expected,
          .schema = std::move(schema),
          .read =
              [=](const Json& json, const Reading& at) {
                if (!json.is_array() || json.size() < counts.lo || json.size() > counts.hi)
                  at.place.refuse(json, expected);
                std::vector<Object> list;
                for (std::size_t i = 0; i < json.size(); ++i)
                  list.push_back(read_by_type(json[i], kinds, noun, at.at(i)));
                return list;
              },
          .write =
              [=](const std::vector<Object>& list) {
                Json json = Json::array();
                for (const Object& object : list) {
                  const Kind<Object>& kind = kind_of(object.type, kinds);
                  json.push_back({{"type", kind.word}});
                  json.back().update(write_object(object, kind.rows));
                }
                return json;
              }};
}

/// Files by the names that layers use.
ValueKind<std::vector<DataSpec>> data_value() {
  const std::string expected = "an object of files by name, such as {\"head\": {\"file\": \"head.rho\"}}";
  return {.expected = expected,
          .schema = {{"type", "object"}, {"minProperties", 1}, {"additionalProperties", schema_of(data_rows())}},
          .read =
              [expected](const Json& json, const Reading& at) {
                if (!json.is_object() || json.empty()) at.place.refuse(json, expected);
                std::vector<DataSpec> data;
                for (const auto& [name, value] : json.items()) {
                  data.push_back(read_object(value, at.at(name), data_rows()));
                  data.back().name = name;
                }
                return data;
              },
          .write =
              [](const std::vector<DataSpec>& data) {
                Json json = Json::object();
                for (const DataSpec& each : data) json[each.name] = write_object(each, data_rows());
                return json;
              }};
}

/// What an editor reads to know the schema; of no meaning to us.
Row<SceneSpec> schema_row() {
  const ValueKind<std::string> text = text_value();
  return {.key = "$schema",
          .help = "Where this schema lies, for editors",
          .expected = text.expected,
          .schema = text.schema,
          .read = [read = text.read](const Json& json, const Reading& at, SceneSpec&) { read(json, at); },
          .write = [](const SceneSpec&) { return Json(); }};
}

}  // namespace

std::span<const LayerKind> layer_kinds() {
  static const std::vector<LayerKind> kinds{
      {LayerType::isosurface, "isosurface", "Where the field has one value",
       rows_of_every_layer() + rows_of_every_field() + rows_of_isosurfaces() + rows_of_lit_surfaces()},
      {LayerType::mip, "mip", "The largest value along every ray",
       rows_of_every_layer() + rows_of_every_field() + rows_of_projections()},
      {LayerType::mesh, "mesh", "Triangles of a packed surface, a landmark among the others",
       rows_of_every_layer() + rows_of_triangles() + rows_of_lit_surfaces()},
      {LayerType::slice, "slice", "The field on a plane, in colours; in double precision at every accuracy",
       rows_of_data() + slice_rows()}};
  return kinds;
}

std::span<const LightKind> light_kinds() {
  using Type = render::Light::Kind;
  static const std::vector<LightKind> kinds{
      {Type::head, "head", "At the eye", {color_row(), intensity_row()}},
      {Type::directional,
       "directional",
       "From one direction, as the sun",
       {row("direction", &LightSpec::direction, vector_value(), "Towards it, in world axes"),
        row("azimuth", &LightSpec::azimuth_deg, number(),
            "Instead, with \"elevation\": degrees, as those of a camera that stands where the light comes from; "
            "default 0"),
        row("elevation", &LightSpec::elevation_deg, number_within(limits::elevation_deg), "Likewise; default 0"),
        row("from", &LightSpec::from, word_value({"world", "camera"}),
            "What the angles count from: \"world\", the default, or \"camera\", where 0 is the eye, azimuth goes to "
            "the picture's right and elevation up"),
        color_row(), intensity_row(), shadows_row(),
        row("angular_diameter", &LightSpec::angular_diameter_deg, number_within(limits::angular_diameter_deg),
            "Degrees under which it is seen, for soft edges of shadows (the sun: 0.53); default 0, sharp"),
        samples_row()}},
      {Type::point,
       "point",
       "In a place; it does not grow weaker with distance",
       {required(row("position", &LightSpec::position, vector_value(), "Where it stands, in world units")), color_row(),
        intensity_row(), shadows_row(),
        row("radius", &LightSpec::radius, number_from_zero(),
            "Of the ball that shines, world units, for soft edges of shadows; default 0, sharp"),
        samples_row()}}};
  return kinds;
}

const std::vector<Row<DataSpec>>& data_rows() {
  static const std::vector<Row<DataSpec>> rows{
      required(row("file", &DataSpec::file, file_value(),
                   "Packed file or OpenVDB file; a relative name is one in the document's folder")),
      row("field", &DataSpec::field, text_value(), "Default the first field that is not the same everywhere")};
  return rows;
}

const std::vector<Row<OcclusionSpec>>& occlusion_rows() {
  static const std::vector<Row<OcclusionSpec>> rows{
      row("samples", &OcclusionSpec::samples, whole_number_within(limits::occlusion_samples),
          "Rays of each hit: more are slower and less grainy; default 16"),
      row("radius", &OcclusionSpec::radius, number_above_zero(),
          "How far away surfaces hold light back, world units; default a tenth of the diagonal of what is shown")};
  return rows;
}

const std::vector<Row<FogSpec>>& fog_rows() {
  static const std::vector<Row<FogSpec>> rows{
      row("color", &FogSpec::color, color_value(), "What surfaces fade into; default the background"),
      row("range", &FogSpec::range, interval_value(),
          "Distances from the eye, world units: up to the first nothing fades, from the second on all; default from "
          "the nearest of what is shown on, so that its farthest fades by half")};
  return rows;
}

const std::vector<Row<EffectsSpec>>& effect_rows() {
  static const std::vector<Row<EffectsSpec>> rows{
      row("ambient_occlusion", &EffectsSpec::occlusion, object_value(occlusion_rows()),
          "Where opaque isosurfaces stand near, less of the ambient light arrives"),
      row("fog", &EffectsSpec::fog, object_value(fog_rows()), "Surfaces fade with distance")};
  return rows;
}

const std::vector<Row<KeyframeSpec>>& keyframe_rows() {
  static const std::vector<Row<KeyframeSpec>> rows{
      required(row("time", &KeyframeSpec::time, number(), "Times rise from key to key")),
      row("azimuth", &KeyframeSpec::azimuth_deg, number(),
          "As the camera's; 360 is a turn after 0. Between keys a monotone cubic, as of all numbers"),
      row("elevation", &KeyframeSpec::elevation_deg, number_within(limits::elevation_deg), "As the camera's"),
      row("zoom", &KeyframeSpec::zoom, number_within(limits::zoom), "As the camera's; its logarithm moves"),
      row("fov", &KeyframeSpec::fov_deg, number_within(limits::fov_deg), "As the camera's"),
      row("position", &KeyframeSpec::position, vector_value(),
          "In place of angles: as the camera's; between keys a cubic as of Catmull and Rom"),
      row("target", &KeyframeSpec::target, vector_value(), "Likewise"),
      row("up", &KeyframeSpec::up, vector_value(), "Likewise"),
      row("isovalue", &KeyframeSpec::isovalue, number(), "Of the only isosurface of the scene")};
  return rows;
}

const std::vector<Row<CameraSpec>>& camera_rows() {
  static const std::vector<Row<CameraSpec>> rows{
      row("view", &CameraSpec::view, word_value(view_words()), "Side to look from; default \"iso\", three-quarter"),
      row("azimuth", &CameraSpec::azimuth_deg, number(), "Degrees around the world's z axis; 0 looks along +y"),
      row("elevation", &CameraSpec::elevation_deg, number_within(limits::elevation_deg),
          "Degrees above the horizon; 90 looks straight down"),
      row("zoom", &CameraSpec::zoom, number_within(limits::zoom),
          "1, the default: what is shown just fits; 2: twice as large"),
      row("fov", &CameraSpec::fov_deg, number_within(limits::fov_deg), "Vertical opening angle in degrees; default 30"),
      row("ortho", &CameraSpec::orthographic, yes_or_no(), "true: orthographic projection"),
      row("ortho_height", &CameraSpec::orthographic_height, number_above_zero(),
          "World units that the picture's height shows; implies \"ortho\""),
      row("position", &CameraSpec::position, vector_value(), "Eye, in world units; default fitted to what is shown"),
      row("target", &CameraSpec::target, vector_value(), "Point looked at"),
      row("up", &CameraSpec::up, vector_value(), "Direction that is up in the picture"),
      row("keyframes", &CameraSpec::keyframes, list_of(keyframe_rows(), "key frames"),
          "How the camera moves: an array of at least 2 times, and what is there; -o out_%04d.png names the pictures")};
  return rows;
}

const std::vector<Row<PictureSpec>>& image_rows() {
  static const std::vector<Row<PictureSpec>> rows{
      row("size", &PictureSpec::size, size_value(), "Pixels; default [1280, 720]"),
      row("background", &PictureSpec::background, color_value(), "Default white, and black behind projections alone"),
      row("channels", &PictureSpec::channels, words_value(channel_words()), "Also keep these (EXR only)"),
      row("show", &PictureSpec::show, word_value(show_words()), "A heat map instead of colours; default \"color\""),
      row("hierarchy", &PictureSpec::hierarchy, yes_or_no(),
          "false walks every leaf cell, for comparison; the same picture at double"),
      row("antialias", &PictureSpec::antialias, whole_number_within(limits::pixel_samples),
          "Most samples of a pixel: at edges, where neighbours differ, as many as their differing asks for; default 1, "
          "none but the middle"),
      row("frames", &PictureSpec::frames, whole_number_within(limits::frames),
          "From the first of the camera's \"keyframes\" to the last, at even times; default 25 for each unit of time")};
  return rows;
}

const std::vector<Row<AxesSpec>>& axes_rows() {
  static const std::vector<Row<AxesSpec>> rows{
      row("corner", &AxesSpec::corner, word_value({"left", "right"}), "Which lower corner; default \"left\"")};
  return rows;
}

const std::vector<Row<ColorBarSpec>>& color_bar_rows() {
  static const std::vector<Row<ColorBarSpec>> rows{
      row("title", &ColorBarSpec::title, text_value(),
          "Of every bar; default the field's name and unit, or what a heat map shows"),
      row("position", &ColorBarSpec::position, word_value({"left", "right"}), "Default \"right\"")};
  return rows;
}

const std::vector<Row<AnnotationsSpec>>& annotation_rows() {
  static const std::vector<Row<AnnotationsSpec>> rows{
      switched_row("axes", &AnnotationsSpec::axes, axes_rows(), "Arrows along the world's axes, in a corner"),
      row("box", &AnnotationsSpec::box, yes_or_no(),
          "Around what is shown, with ticks in world units; a view that names no zoom leaves room for them: 0.75"),
      switched_row("colorbar", &AnnotationsSpec::color_bar, color_bar_rows(),
                   "The colours of \"color_by\", of projections or of a heat map, and their values"),
      row("caption", &AnnotationsSpec::caption, text_value(), "Below, in lines of the picture's width")};
  return rows;
}

const std::vector<Row<SceneSpec>>& scene_rows() {
  static const std::vector<Row<SceneSpec>> rows{
      schema_row(),
      required(row("data", &SceneSpec::data, data_value(), "Files and their fields, by names of one's own")),
      required(
          row("layers", &SceneSpec::layers, list_by_type(layer_kinds(), "layer", {1, most_layers}), "What is shown")),
      row("lights", &SceneSpec::lights, list_by_type(light_kinds(), "light", {0, most_lights}),
          "What shines; default one white light at the eye"),
      row("effects", &SceneSpec::effects, object_value(effect_rows()),
          "Of the whole picture; each that is named is on"),
      row("clip", &SceneSpec::clip, object_value(clip_rows()),
          "A region of which only the inside is shown, or only the outside; what is clipped away holds no light back"),
      row("camera", &SceneSpec::camera, object_value(camera_rows()),
          "From where; default a three-quarter view of all layers"),
      row("image", &SceneSpec::image, object_value(image_rows()), "The picture"),
      row("annotations", &SceneSpec::annotations, object_value(annotation_rows()),
          "Drawn over the finished picture; channels of an EXR stay as they are"),
      row("accuracy", &SceneSpec::accuracy, word_value(accuracy_words()), "Of layers that name none")};
  return rows;
}

}  // namespace rhoray::tools

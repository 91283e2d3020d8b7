#include "render/document/tables.h"

#include <algorithm>
#include <limits>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "formats/base/word_list.h"
#include "render/document/clip.h"
#include "render/document/feature_edges.h"
#include "render/document/material.h"
#include "render/document/slices.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

using Rows = std::vector<Row<LayerSpec>>;

Rows operator+(Rows rows, const Rows& more) {
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

Rows rows_of_data() {
  return {row("data", &LayerSpec::data, text_value(), "Name of the data; optional if there is only one"),
          row("visible", &LayerSpec::visible, yes_or_no(), "false: the layer is left out and its file is not opened"),
          row("clip", &LayerSpec::clip, yes_or_no(), "false: the layer is not clipped")};
}

Rows rows_of_every_layer() {
  return rows_of_data() + Rows{row("accuracy", &LayerSpec::accuracy, word_value(accuracy_words()),
                                   "Accuracy of the layer; default the scene's accuracy")};
}

Rows rows_of_every_field() {
  return {
      row("method", &LayerSpec::method, method_value(), "One method by name instead of an accuracy, for comparison")};
}

Rows rows_of_isosurfaces() {
  return {
      row("isovalue", &LayerSpec::isovalues, isovalues_value(),
          concat(
              "Isovalue; \"auto\" is the histogram's ", auto_isovalue_words,
              "; default \"auto\". Several values make several surfaces; by "
              "default they are coloured by viridis over their values (by coolwarm if those below and above 0 enclose "
              "different regions), the innermost is opaque, and outer ones are transparent")),
      row("color", &LayerSpec::color, color_value(),
          "Surface colour; default neutral; several surfaces have different colours by default"),
      row("normals", &LayerSpec::normals, word_value(normals_words()),
          "Surface normals. Meshes: \"flat\", the default, is the exact gradient of each cell; \"smooth\" is "
          "linear between averages at the points. Grids: \"smooth\", the default, is interpolated between central "
          "differences; \"exact\" is the gradient of the trilinear field"),
      row("color_by", &LayerSpec::color_by, text_value(),
          "Field of the same file that colours the surface; where it has no data, \"color\" is used"),
      row("colormap", &LayerSpec::colormap, word_value(colormap_words()),
          "Colour map of \"color_by\"; default \"viridis\", or \"coolwarm\" with 0 in its middle for "
          "floating-point fields of both signs"),
      row("range", &LayerSpec::range, interval_value(),
          "Values of \"color_by\" with the first and last colour; default the field's range")};
}

Rows rows_of_triangles() {
  return {row("color", &LayerSpec::color, color_value(),
              "Surface colour; default neutral; several surfaces have different colours by default"),
          row("normals", &LayerSpec::normals, word_value({"flat", "smooth"}),
              "Surface normals: \"smooth\", the default, is linear between averages at the corners, up to edges of 30 "
              "degrees; \"flat\" is the normal of each triangle"),
          row("feature_edges", &LayerSpec::feature_edges, number_within(limits::feature_edges),
              concat("Lines where the surface turns by more than this angle in degrees; 180: none; default ",
                     feature_edges_words))};
}

Rows rows_of_boundaries() {
  return rows_of_triangles() +
         Rows{row("color_by", &LayerSpec::color_by, text_value(),
                  "Field of the same file that colours the boundary; default the data's field, unless \"color\" is "
                  "given"),
              row("colormap", &LayerSpec::colormap, word_value(colormap_words()),
                  "Colour map of the field; default \"viridis\", or \"coolwarm\" with 0 in its middle for "
                  "floating-point fields of both signs"),
              row("range", &LayerSpec::range, interval_value(),
                  "Values with the first and last colour; default the field's range")};
}

Rows rows_of_lit_surfaces() {
  return {row("texture", &LayerSpec::texture, text_value(),
              "Name of data with colours that cover the surface, placed in world axes; where it has no data, "
              "\"color\" is used"),
          row("ambient", &LayerSpec::ambient, number_within(limits::share), "Ambient light; default 0.12"),
          row("specular", &LayerSpec::specular, number_within(limits::share),
              "Specular strength; 0 computes none; default 0.15"),
          row("shininess", &LayerSpec::shininess, number_within(limits::shininess),
              "Specular exponent; larger values give smaller and sharper highlights; default 40"),
          row("opacity", &LayerSpec::opacity, number_within(limits::share),
              "Opacity; at 0 the surface is not traced; default 1, less for the outer ones of several isovalues")};
}

Rows rows_of_projections() {
  return {
      row("colormap", &LayerSpec::colormap, word_value(colormap_words()), "Colour map of the values; default \"gray\""),
      row("range", &LayerSpec::range, interval_value(),
          "Values with the first and last colour; default from the 1st to the 99.9th percentile of the field")};
}

Row<LightSpec> color_row() {
  return row("color", &LightSpec::color, color_value(), "Colour of the light; default white");
}
Row<LightSpec> intensity_row() {
  return row("intensity", &LightSpec::intensity, number_within(limits::intensity),
             "Intensity; at 0 the light is not traced; default 1");
}
Row<LightSpec> shadows_row() {
  return row("shadows", &LightSpec::shadows, yes_or_no(), "true: opaque isosurfaces cast shadows; default false");
}
Row<LightSpec> samples_row() {
  return row("samples", &LightSpec::samples, whole_number_within(limits::light_samples),
             "Shadow rays per hit for a light that has a size; more rays are slower and less noisy; default 16");
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
  const ValueKind<std::string> type = word_value(names_in(kinds, &Kind<Object>::word));
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
  return {.expected = expected,
          .schema =
              [=] {
                Json schema{{"type", "array"}, {"minItems", counts.lo}, {"maxItems", counts.hi}};
                for (const Kind<Object>& kind : kinds) schema["items"]["oneOf"].push_back(schema_of(kind));
                return schema;
              },
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
          .schema = []() -> Json {
            return {{"type", "object"}, {"minProperties", 1}, {"additionalProperties", schema_of(data_rows())}};
          },
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

/// The key that names the schema for editors; ignored here.
Row<SceneSpec> schema_row() {
  const ValueKind<std::string> text = text_value();
  return {.key = "$schema",
          .help = "Where this schema is, for editors",
          .expected = text.expected,
          .schema = text.schema,
          .read = [read = text.read](const Json& json, const Reading& at, SceneSpec&) { read(json, at); },
          .write = [](const SceneSpec&) { return Json(); }};
}

/// A row about reading, as one of the data.
Row<DataSpec> of_read(const Row<ReadSpec>& row) {
  const auto read = [read = row.read](const Json& json, const Reading& at, DataSpec& out) { read(json, at, out.read); };
  const auto write = [write = row.write](const DataSpec& data) { return write(data.read); };
  return {row.key, row.help, row.expected, row.schema, row.required, read, write};
}

}  // namespace

std::span<const LayerKind> layer_kinds() {
  static const std::vector<LayerKind> kinds{
      {LayerType::isosurface, "isosurface", "Surface where the field has one value",
       rows_of_every_layer() + rows_of_every_field() + rows_of_isosurfaces() + scale_rows() + rows_of_lit_surfaces()},
      {LayerType::mip, "mip", "Maximum intensity projection: the largest value along every ray",
       rows_of_every_layer() + rows_of_every_field() + rows_of_projections() + scale_rows()},
      {LayerType::triangles, "triangles", "Triangles of a packed surface, for example a landmark",
       rows_of_every_layer() + rows_of_triangles() + rows_of_lit_surfaces()},
      {LayerType::boundary, "boundary", "Boundary of a mesh, with exact fields",
       rows_of_every_layer() + rows_of_boundaries() + scale_rows() + rows_of_lit_surfaces()},
      {LayerType::slice, "slice", "The field on a plane, in colours; always in double precision",
       rows_of_data() + slice_rows() + scale_rows()}};
  return kinds;
}

std::span<const LightKind> light_kinds() {
  using Type = Light::Kind;
  static const std::vector<LightKind> kinds{
      {Type::head, "head", "At the camera", {color_row(), intensity_row()}},
      {Type::directional,
       "directional",
       "Parallel light from one direction, such as the sun",
       {row("direction", &LightSpec::direction, vector_value(), "Direction towards the light, in world axes"),
        row("azimuth", &LightSpec::azimuth_deg, number(),
            "With \"elevation\", instead of \"direction\": azimuth of the light in degrees, as for a camera at the "
            "light; default 0"),
        row("elevation", &LightSpec::elevation_deg, number_within(limits::elevation_deg),
            "Elevation of the light in degrees; default 0"),
        row("from", &LightSpec::from, word_value({"world", "camera"}),
            "Reference of the angles: \"world\", the default, or \"camera\"; for \"camera\", 0 is the camera, azimuth "
            "turns to the picture's right and elevation up"),
        color_row(), intensity_row(), shadows_row(),
        row("angular_diameter", &LightSpec::angular_diameter_deg, number_within(limits::angular_diameter_deg),
            "Angular diameter in degrees, for soft shadows (the sun: 0.53); default 0, sharp shadows"),
        samples_row()}},
      {Type::point,
       "point",
       "At a point; its intensity does not fall off with distance",
       {required(row("position", &LightSpec::position, vector_value(), "Position, in world units")), color_row(),
        intensity_row(), shadows_row(),
        row("radius", &LightSpec::radius, number_from_zero(),
            "Radius of the light in world units, for soft shadows; default 0, sharp shadows"),
        samples_row()}}};
  return kinds;
}

const std::vector<Row<DataSpec>>& data_rows() {
  static const std::vector<Row<DataSpec>> rows{
      required(row("file", &DataSpec::file, file_value(),
                   "Any file that is read, packed or not; a relative name starts at the document's folder")),
      row("field", &DataSpec::field, text_value(), "Field to show; default the first that is not constant"),
      row("label", &DataSpec::label,
          whole_number_within({std::numeric_limits<int>::min(), std::numeric_limits<int>::max()}),
          "A label of a segmentation. Of a volume: the data are 1 at its samples and 0 at others, and its surface is "
          "the isosurface at 0.5. Of a mesh: \"field\" is a field of cells, and a layer of type \"boundary\" shows the "
          "boundary of the cells with the label"),
      of_read(row("raw", &ReadSpec::raw, text_value(),
                  "Reads a file without a header, as `rhoray pack --raw`: \"256x256x128:uint16:le\"")),
      of_read(row("spacing", &ReadSpec::spacing, vector_value(), "Replaces the spacing of a file that is not packed")),
      of_read(row("origin", &ReadSpec::origin, vector_value(), "Replaces the origin of a file that is not packed")),
      of_read(row("time", &ReadSpec::time, text_value(),
                  "Time step of a file that is not packed, as `rhoray pack --time`: \"first\", \"last\", \"#3\" "
                  "counted from 0, or the nearest to a time"))};
  return rows;
}

const std::vector<Row<OcclusionSpec>>& occlusion_rows() {
  static const std::vector<Row<OcclusionSpec>> rows{
      row("samples", &OcclusionSpec::samples, whole_number_within(limits::occlusion_samples),
          "Rays per hit; more rays are slower and less noisy; default 16"),
      row("radius", &OcclusionSpec::radius, number_above_zero(),
          "Largest distance of an occluder, in world units; default a tenth of the diagonal of the shown data")};
  return rows;
}

const std::vector<Row<FogSpec>>& fog_rows() {
  static const std::vector<Row<FogSpec>> rows{
      row("color", &FogSpec::color, color_value(), "Fog colour; default the background"),
      row("range", &FogSpec::range, interval_value(),
          "Distances from the camera in world units: fog starts at the first and is complete at the second; by default "
          "it starts at the nearest shown point, and the farthest fades by half")};
  return rows;
}

const std::vector<Row<EffectsSpec>>& effect_rows() {
  static const std::vector<Row<EffectsSpec>> rows{
      row("ambient_occlusion", &EffectsSpec::occlusion, object_value(occlusion_rows()),
          "Ambient occlusion: less ambient light near opaque isosurfaces"),
      row("fog", &EffectsSpec::fog, object_value(fog_rows()), "Fog: surfaces fade with distance")};
  return rows;
}

const std::vector<Row<KeyframeSpec>>& keyframe_rows() {
  static const std::vector<Row<KeyframeSpec>> rows{
      required(row("time", &KeyframeSpec::time, number(), "Time of the key frame; times must increase")),
      row("azimuth", &KeyframeSpec::azimuth_deg, number(),
          "As for the camera; 360 is one turn after 0; between keys all numbers follow a monotone cubic"),
      row("elevation", &KeyframeSpec::elevation_deg, number_within(limits::elevation_deg), "As for the camera"),
      row("zoom", &KeyframeSpec::zoom, number_within(limits::zoom), "As for the camera; its logarithm is interpolated"),
      row("fov", &KeyframeSpec::fov_deg, number_within(limits::fov_deg), "As for the camera"),
      row("ortho_height", &KeyframeSpec::orthographic_height, number_above_zero(),
          "As for the camera, not with \"fov\"; its logarithm is interpolated"),
      row("position", &KeyframeSpec::position, vector_value(),
          "Instead of angles, as for the camera; between keys it follows a Catmull-Rom cubic"),
      row("target", &KeyframeSpec::target, vector_value(), "As for \"position\""),
      row("up", &KeyframeSpec::up, vector_value(), "As for \"position\""),
      row("isovalue", &KeyframeSpec::isovalue, number(), "Isovalue of the scene's only isosurface")};
  return rows;
}

const std::vector<Row<CameraSpec>>& camera_rows() {
  static const std::vector<Row<CameraSpec>> rows{
      row("view", &CameraSpec::view, word_value(view_words()),
          "Side from which the camera looks; default \"iso\", three-quarter"),
      row("up_axis", &CameraSpec::up_axis, word_value(up_axis_words()),
          "Axis of the world that is up; default y if all data are surfaces from .obj or .ply files, else z. "
          "Views and angles count from it"),
      row("azimuth", &CameraSpec::azimuth_deg, number(), "Degrees around the axis that is up; 0 looks from the front"),
      row("elevation", &CameraSpec::elevation_deg, number_within(limits::elevation_deg),
          "Degrees above the horizon; 90 looks straight down"),
      row("zoom", &CameraSpec::zoom, number_within(limits::zoom),
          "1, the default: the shown data fill 90 % of the width or height; 2: twice as large"),
      row("fov", &CameraSpec::fov_deg, number_within(limits::fov_deg), "Vertical field of view in degrees; default 30"),
      row("ortho", &CameraSpec::orthographic, yes_or_no(), "true: orthographic projection"),
      row("ortho_height", &CameraSpec::orthographic_height, number_above_zero(),
          "Height of the image in world units; implies \"ortho\""),
      row("position", &CameraSpec::position, vector_value(),
          "Camera position in world units; default fitted to the shown data"),
      row("target", &CameraSpec::target, vector_value(), "Point the camera looks at, in world units"),
      row("up", &CameraSpec::up, vector_value(), "Up direction of the image"),
      row("keyframes", &CameraSpec::keyframes, list_of(keyframe_rows(), "an array of key frames"),
          "Camera motion: an array of at least 2 key frames; -o out_%04d.png names the pictures")};
  return rows;
}

const std::vector<Row<PictureSpec>>& image_rows() {
  static const std::vector<Row<PictureSpec>> rows{
      row("size", &PictureSpec::size, size_value(),
          "Image size in pixels; default as many as 960 x 720, as wide as what is shown"),
      row("background", &PictureSpec::background, background_value(),
          "Background colour; \"none\": a picture with alpha (not JPEG); default the style's, but black if only "
          "projections are shown"),
      row("channels", &PictureSpec::channels, words_value(channel_words()), "Extra channels (EXR only)"),
      row("show", &PictureSpec::show, word_value(show_words()), "Heat map instead of colours; default \"color\""),
      row("hierarchy", &PictureSpec::hierarchy, yes_or_no(),
          "false: visit every leaf cell, for comparison; the picture is the same at double"),
      row("antialias", &PictureSpec::antialias, whole_number_within(limits::pixel_samples),
          "Maximum samples per pixel; adaptive: more at edges, where neighbours differ; default 8; in heat maps and if "
          "only projections are shown 1, in the centre"),
      row("frames", &PictureSpec::frames, whole_number_within(limits::frames),
          "Number of pictures from the first of the camera's \"keyframes\" to the last, at even times; default 25 per "
          "unit of time")};
  return rows;
}

const std::vector<Row<AxesSpec>>& axes_rows() {
  static const std::vector<Row<AxesSpec>> rows{
      row("corner", &AxesSpec::corner, word_value({"left", "right"}), "Lower corner of the arrows; default \"left\"")};
  return rows;
}

const std::vector<Row<ColorBarSpec>>& color_bar_rows() {
  static const std::vector<Row<ColorBarSpec>> rows{
      row("title", &ColorBarSpec::title, drawn_text_value(),
          "Title of every bar; default the field's name and unit, or the quantity of the heat map"),
      row("position", &ColorBarSpec::position, word_value({"left", "right"}),
          "Side of the picture; default \"right\"")};
  return rows;
}

const std::vector<Row<AnnotationsSpec>>& annotation_rows() {
  static const std::vector<Row<AnnotationsSpec>> rows{
      switched_row(
          "axes", &AnnotationsSpec::axes, axes_rows(),
          "Arrows along the world axes, in a corner; in a patient's body with the letters of their directions"),
      row("box", &AnnotationsSpec::box, yes_or_no(),
          "Box around the shown data, with ticks in world units; the default zoom is then 0.9, which leaves room for "
          "them"),
      switched_row("colorbar", &AnnotationsSpec::color_bar, color_bar_rows(),
                   "Colour bar of \"color_by\", slices, projections or a heat map"),
      row("legend", &AnnotationsSpec::legend, yes_or_no(),
          "Colours and values or labels of the surfaces; default true with labels, and if a layer with several "
          "isovalues names no colour"),
      row("caption", &AnnotationsSpec::caption, drawn_text_value(),
          "Caption below the picture, in lines of the picture's width; if they do not fit, the last one ends in "
          "\"...\"")};
  return rows;
}

const std::vector<Row<SceneSpec>>& scene_rows() {
  static const std::vector<Row<SceneSpec>> rows{
      schema_row(),
      required(row("data", &SceneSpec::data, data_value(), "Files and their fields, by names of your choice")),
      required(
          row("layers", &SceneSpec::layers, list_by_type(layer_kinds(), "layer", {1, most_layers}), "What is shown")),
      row("style", &SceneSpec::style, word_value(style_words()),
          concat("Lights, background, samples, highlight and normals of what says nothing else. ", style_help())),
      row("lights", &SceneSpec::lights, list_by_type(light_kinds(), "light", {0, most_lights}),
          "Lights; default the style's"),
      row("effects", &SceneSpec::effects, object_value(effect_rows()),
          "Effects of the whole picture; each key switches one on"),
      row("clip", &SceneSpec::clip, object_value(clip_rows()),
          "Region of which only the inside or only the outside is shown; what is clipped away casts no shadows"),
      row("camera", &SceneSpec::camera, object_value(camera_rows()),
          "Camera; default a three-quarter view of all layers"),
      row("image", &SceneSpec::image, object_value(image_rows()), "Image size, background, channels and frames"),
      row("annotations", &SceneSpec::annotations, object_value(annotation_rows()),
          "Annotations drawn over the finished picture; the channels of an EXR do not change"),
      row("accuracy", &SceneSpec::accuracy, word_value(accuracy_words()), "Accuracy of layers that set none"),
      row("space", &SceneSpec::space, word_value(space_words()),
          "Space of world coordinates, where files say which is theirs. \"ras\": x to the patient's right, y to the "
          "front, z to the head; \"lps\": x to the left, y to the back, z to the head; default \"ras\"")};
  return rows;
}

}  // namespace rhoray::render

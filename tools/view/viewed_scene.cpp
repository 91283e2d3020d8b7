#include "tools/view/viewed_scene.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/stopping.h"
#include "formats/base/text.h"
#include "render/method_words.h"
#include "render/png.h"
#include "render/render.h"
#include "render/scene_words.h"
#include "render/truth.h"
#include "tools/analysis/pick.h"
#include "tools/pictures/annotations.h"
#include "tools/view/admission.h"

namespace rhoray::tools {

namespace {

[[noreturn]] void refuse(const std::string& fact) {
  throw Error(ErrorCode::invalid, concat("scene: ", fact));
}

/// "#c7bdad", of a linear colour.
std::string css_color(const Vec3& linear) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", render::srgb_byte(static_cast<float>(linear.x)),
                render::srgb_byte(static_cast<float>(linear.y)), render::srgb_byte(static_cast<float>(linear.z)));
  return text.data();
}

Box3 bounds_of(const render::ResolvedScene& plan) {
  Box3 box;
  for (const render::Dataset& dataset : plan.datasets) box.extendBy(dataset.bounds());
  return box;
}

// ---- documents ----

/// The layers of a document as an object by number, which a merge patch can change one by one.
void number_layers(Json& document) {
  Json layers = Json::object();
  for (std::size_t i = 0; i < document["layers"].size(); ++i) layers[concat(i)] = std::move(document["layers"][i]);
  document["layers"] = std::move(layers);
}

/// The reverse. Refuses layers whose numbers are not 0, 1, 2 and so on.
void list_layers(Json& document) {
  Json& by_number = document["layers"];
  Json layers = Json::array();
  for (std::size_t i = 0; i < by_number.size(); ++i) {
    const auto layer = by_number.find(concat(i));
    if (layer == by_number.end()) refuse(concat("\"layers\": there is no layer ", i, " of ", by_number.size()));
    layers.push_back(std::move(*layer));
  }
  by_number = std::move(layers);
}

void require_allowed(const Json& patch, const Json& document) {
  const auto require = [](const Json& object, const std::string& name,
                          std::initializer_list<std::string_view> allowed) {
    if (!object.is_object()) refuse(concat("\"", name, "\": expected an object"));
    for (const auto& [key, value] : object.items())
      if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
        refuse(concat("\"", key, "\": clients cannot change it"));
  };
  require(patch, "scene", {"layers", "style", "lights", "effects", "clip", "annotations", "accuracy", "image", "data"});
  if (patch.contains("layers") && !patch["layers"].is_object()) refuse("\"layers\": expected an object by number");
  if (patch.contains("image")) require(patch["image"], "image", {"background", "show", "antialias"});
  if (!patch.contains("data")) return;
  if (!patch["data"].is_object()) refuse("\"data\": expected an object");
  for (const auto& [name, value] : patch["data"].items()) {
    if (!document["data"].contains(name)) refuse(concat("data '", name, "': there are none with this name"));
    require(value, name, {"field"});
  }
}

/// The most samples that a light or ambient occlusion takes.
int most_samples(const render::SceneSpec& scene_spec) {
  int most = 0;
  for (const render::LightSpec& light : scene_spec.lights.value_or(std::vector<render::LightSpec>{}))
    most = std::max(most, light.samples.value_or(0));
  if (const auto& occlusion = scene_spec.effects.occlusion) most = std::max(most, occlusion->samples.value_or(0));
  return most;
}

// ---- probing ----

/// The camera of a picture of one pixel, whose ray is that of a pixel of the plan's picture.
render::Camera camera_of_pixel(const render::ResolvedScene& plan, const Probe& probe) {
  const render::PictureSize size{plan.frame.width, plan.frame.height};
  const std::vector<std::uint32_t> pixels{static_cast<std::uint32_t>(probe.y) * static_cast<std::uint32_t>(size.width) +
                                          static_cast<std::uint32_t>(probe.x)};
  const render::Dataset& dataset = plan.datasets.front();  // every dataset's rays are the same in the world
  render::Camera camera = plan.scene.camera;
  const render::Ray ray = camera_rays(dataset, camera, size.width, size.height, pixels).front();
  const Affine& world_from_ray = world_from_ray_frame(dataset);
  // The target keeps its distance: a nearer one would round the direction where coordinates are
  // large.
  const double distance = (camera.target - camera.position).length();
  const Vec3 eye = world_from_ray.point(ray.origin);
  if (camera.orthographic) camera.position = eye;
  camera.target = world_from_ray.point(ray.origin + distance * ray.direction);
  camera.vertical_fov_deg = 1, camera.orthographic_height = distance / size.height;
  return camera;
}

}  // namespace

Json json_of_camera(const render::Camera& camera) {
  Json json{{"position", rhoray::json_of(camera.position)},
            {"target", rhoray::json_of(camera.target)},
            {"up", rhoray::json_of(camera.up)}};
  if (camera.orthographic)
    json["ortho_height"] = camera.orthographic_height;
  else
    json["fov"] = camera.vertical_fov_deg;
  return json;
}

Json json_of_check(const render::SelfCheck& found, double ms) {
  const render::CheckedPixels &random = found.random, &edges = found.edges;
  return {{"pixels", random.pixels + edges.pixels},
          {"missed", random.missed + edges.missed},
          {"false_hits", random.false_hits + edges.false_hits},
          {"kept_by_99", std::max(random.kept_by_99, edges.kept_by_99)},
          {"unit", found.unit},
          {"ms", ms}};
}

Json json_of_effects(const EffectTimes& times) {
  Json effects = Json::array();
  for (const EffectTimes::Cost& cost : times.costs()) effects.push_back({{"effect", cost.effect}, {"ms", cost.ms}});
  return {{"ms", times.whole_ms()}, {"effects", effects}};
}

std::string document_to_change(const ViewedScene& viewed) {
  const render::SceneSpec& asked = viewed.scene_spec;
  render::SceneSpec scene_spec = to_spec(viewed.plan);
  scene_spec.style = asked.style;
  scene_spec.lights = asked.lights;
  scene_spec.effects = asked.effects;
  scene_spec.image = {.background = asked.image.background, .antialias = asked.image.antialias};
  scene_spec.image.show = asked.image.show, scene_spec.image.hierarchy = asked.image.hierarchy;
  scene_spec.camera = {};
  for (std::size_t i = 0; i < scene_spec.layers.size(); ++i) {
    if (viewed.plan.origins[i].is_context) continue;  // its look does not come from the style
    render::LayerSpec& layer = scene_spec.layers[i];
    const render::LayerSpec& asked_layer = asked.layers[viewed.plan.origins[i].spec];
    layer.normals = asked_layer.normals;
    layer.ambient = asked_layer.ambient, layer.specular = asked_layer.specular;
    layer.shininess = asked_layer.shininess;
  }
  Json document = Json::parse(scene_text(scene_spec));
  number_layers(document);
  return dump(document);
}

ChangedScene changed_scene(const ViewedScene& viewed, const std::string& document, const std::string& patch) {
  if (patch.empty()) {  // the document has one layer for each of the plan, whatever was asked for
    std::vector<std::size_t> numbers(viewed.plan.scene.layers.size());
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
    return {viewed.scene_spec, viewed.plan, std::move(numbers)};
  }
  Json changed = Json::parse(document);
  const Json changes = Json::parse(patch);
  require_allowed(changes, changed);
  changed.merge_patch(changes);
  if (!changed.contains("layers")) refuse("\"layers\": expected at least one");
  list_layers(changed);
  render::SceneDocument read = render::read_scene(dump(changed), "scene", {});
  if (!read.warnings.empty()) throw Error(ErrorCode::invalid, read.warnings.front());
  if (most_samples(read.scene_spec) > std::max(view_limits::samples, most_samples(viewed.scene_spec)))
    refuse(concat("more than ", view_limits::samples, " samples"));
  ChangedScene scene{std::move(read.scene_spec), {}, {}};
  scene.plan = viewed.resolve(scene.scene_spec);
  for (const render::LayerOrigin& origin : scene.plan.origins) scene.layer_numbers.push_back(origin.spec);
  return scene;
}

render::ResolvedScene with_request(const ViewedScene& viewed, const ChangedScene& scene,
                                   const PictureRequest& request) {
  render::ResolvedScene plan = scene.plan;
  plan.frame.width = request.width, plan.frame.height = request.height;
  if (request.is_moving) plan.frame.antialiasing = 1, plan.annotations = {};
  render::SceneSpec scene_spec = scene.scene_spec;
  scene_spec.image.size = render::PictureSize{request.width, request.height};
  const render::Camera camera = request.camera.value_or(viewed.plan.scene.camera);
  scene_spec.camera = {.position = camera.position, .target = camera.target, .up = camera.up};
  if (camera.orthographic)
    scene_spec.camera.orthographic_height = camera.orthographic_height;
  else
    scene_spec.camera.fov_deg = camera.vertical_fov_deg;
  plan.notes.clear();
  aim_camera(scene_spec, plan);
  return plan;
}

namespace {

Json json_of_probe(render::ResolvedScene plan, const Probe& probe, const std::stop_token& stop) {
  if (probe.x >= plan.frame.width || probe.y >= plan.frame.height)
    throw Error(ErrorCode::invalid, "message: \"probe\": expected a pixel of the picture");
  plan.scene.camera = camera_of_pixel(plan, probe);
  for (render::Layer& layer : plan.scene.layers)
    if (layer.mode == render::Mode::isosurface || layer.mode == render::Mode::mip)
      layer.method = method_of(render::Accuracy::certified);
  plan.frame.width = plan.frame.height = 1;
  plan.frame.antialiasing = 1;
  plan.frame.channels = channels_of_picks(plan.scene);
  render::Framebuffer pixel;
  render::RenderContext memory;
  render::refine(plan.datasets, plan.scene, plan.frame, {.first_spacing = 1, .watch = stop}, pixel, memory);
  end_if_stopped(stop);
  Json json = picked(plan, pixel, {0, 0});
  json["pixel"] = {probe.x, probe.y};
  json["id"] = probe.id;
  return json;
}

}  // namespace

std::string probe_text(const ViewedScene& viewed, const ChangedScene& scene, const PictureRequest& request,
                       const Probe& probe, const std::stop_token& stop) {
  try {
    return dump(Json{{"probe", json_of_probe(with_request(viewed, scene, request), probe, stop)}});
  } catch (const std::exception& error) {
    return refused_probe_text(probe, error.what());
  }
}

std::string refused_probe_text(const Probe& probe, const std::string& why_not) {
  return dump(Json{{"probe", {{"id", probe.id}, {"why_not", why_not}}}});
}

std::string hello_text(const ViewedScene& viewed, const std::string& document) {
  Json data = Json::object();
  for (std::size_t i = 0; i < viewed.plan.datasets.size(); ++i) {
    const render::Dataset& dataset = viewed.plan.datasets[i];
    const std::string name = viewed.plan.data[i].name.empty() ? "data" : viewed.plan.data[i].name;
    if (data.contains(name)) continue;  // a boundary, listed as its mesh
    const char* kind = dataset.is_surface() ? "surface" : dataset.is_mesh() ? "mesh" : "grid";
    data[name] = {{"kind", kind}, {"fields", dataset.field_names()}, {"colors", dataset.color_names()}};
    if (!dataset.is_surface())
      for (const auto& [type, mode] : {std::pair{"isosurface", render::Mode::isosurface}, {"mip", render::Mode::mip}})
        data[name]["methods"][type] = render::methods_to_compare(mode, dataset.is_mesh());
  }
  Json shown = Json::parse(document);
  for (auto& [name, value] : shown["data"].items()) value.erase("file");
  const Box3 bounds = bounds_of(viewed.plan);
  const render::ViewAxes axes = view_axes(viewed.scene_spec, viewed.plan);
  const DirectionLetters letters = letters_of(space_of(viewed.plan));
  return dump(Json{{"hello",
                    {{"protocol", view_protocol},
                     {"program", viewed.program},
                     {"title", viewed.title},
                     {"camera", json_of_camera(viewed.plan.scene.camera)},
                     {"bounds", {json_of(bounds.min), json_of(bounds.max)}},
                     {"up", json_of(axes.up)},
                     {"ahead", json_of(axes.ahead)},
                     {"directions", letters.high.empty() ? Json() : Json{{"low", letters.low}, {"high", letters.high}}},
                     {"length_unit", viewed.plan.datasets.front().length_unit()},
                     {"data", data},
                     {"document", shown},
                     {"words",
                      {{"accuracy", render::accuracy_words()},
                       {"style", render::style_words()},
                       {"colormap", render::colormap_words()},
                       {"scale", render::scale_words()},
                       {"show", render::show_words()},
                       {"keep", {render::keep_inside, render::keep_outside}}}}}}});
}

std::string resolved_text(const ChangedScene& scene, std::uint32_t request) {
  const render::ResolvedScene& plan = scene.plan;
  render::SceneSpec scene_spec = to_spec(plan);
  if (!scene_spec.lights) scene_spec.lights = render::lights_of_style(scene_spec.style);
  scene_spec.camera = {};
  Json document = Json::parse(scene_text(scene_spec));
  for (auto& [name, value] : document["data"].items()) value.erase("file");
  Json fields = Json::array(), legend = Json::array();
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const render::Layer& layer = plan.scene.layers[i];
    const render::Dataset& dataset = plan.datasets[layer.dataset];
    const auto& colors = layer.material.color_by;
    legend.push_back(colors ? Json() : Json(css_color(layer.material.color)));
    std::optional<formats::FieldSummary> field;
    if (layer.mode != render::Mode::triangles)
      field = dataset.field();
    else if (colors)
      field = dataset.field(colors->field);
    fields.push_back(field ? Json{{"name", field->name},
                                  {"unit", field->unit},
                                  {"range", json_of(field->range)},
                                  {"histogram", field->histogram}}
                           : Json());
  }
  return dump(Json{{"resolved",
                    {{"n", request},
                     {"document", document},
                     {"origins", scene.layer_numbers},
                     {"fields", fields},
                     {"legend", legend},
                     {"notes", plan.notes}}}});
}

}  // namespace rhoray::tools

#include "tools/view/viewed_scene.h"

#include <array>
#include <cstdio>

#include "formats/base/json.h"
#include "formats/base/text.h"
#include "render/png.h"
#include "tools/view/admission.h"

namespace rhoray::tools {

namespace {

/// "#c7bdad", of a linear colour.
std::string css_color(const Vec3& linear) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", render::srgb_byte(static_cast<float>(linear.x)),
                render::srgb_byte(static_cast<float>(linear.y)), render::srgb_byte(static_cast<float>(linear.z)));
  return text.data();
}

Json json_of_camera(const render::Camera& camera) {
  Json json{{"position", json_of(camera.position)}, {"target", json_of(camera.target)}, {"up", json_of(camera.up)}};
  if (camera.orthographic)
    json["ortho_height"] = camera.orthographic_height;
  else
    json["fov"] = camera.vertical_fov_deg;
  return json;
}

Json json_of_surface(const ViewedScene& viewed, std::size_t index) {
  const render::Layer& layer = viewed.plan.scene.layers[index];
  const formats::FieldSummary& field = viewed.plan.datasets[layer.dataset].field();
  return {{"layer", index},
          {"isovalue", layer.isovalue},
          {"color", css_color(layer.material.color)},
          {"field", field.name},
          {"unit", field.unit},
          {"range", json_of(field.range)},
          {"histogram", field.histogram}};
}

Box3 bounds_of(const render::ResolvedScene& plan) {
  Box3 box;
  for (const render::Dataset& dataset : plan.datasets) box.extendBy(dataset.bounds());
  return box;
}

}  // namespace

render::ResolvedScene with_wish(const ViewedScene& viewed, const Wish& wish) {
  render::ResolvedScene plan = viewed.plan;
  for (const IsovalueWish& each : wish.isovalues) plan.scene.layers[each.layer].isovalue = each.isovalue;
  plan.frame.width = wish.width, plan.frame.height = wish.height;
  if (wish.is_moving) plan.frame.antialiasing = 1, plan.annotations = {};
  render::SceneSpec scene_spec = viewed.scene_spec;
  scene_spec.image.size = render::PictureSize{wish.width, wish.height};
  const render::Camera camera = wish.camera.value_or(viewed.plan.scene.camera);
  scene_spec.camera = {.position = camera.position, .target = camera.target, .up = camera.up};
  if (camera.orthographic)
    scene_spec.camera.orthographic_height = camera.orthographic_height;
  else
    scene_spec.camera.fov_deg = camera.vertical_fov_deg;
  plan.notes.clear();
  aim_camera(scene_spec, plan);
  return plan;
}

std::string hello_text(const ViewedScene& viewed) {
  Json surfaces = Json::array();
  for (std::size_t i = 0; i < viewed.plan.scene.layers.size(); ++i)
    if (viewed.plan.scene.layers[i].mode == render::Mode::isosurface) surfaces.push_back(json_of_surface(viewed, i));
  const Box3 bounds = bounds_of(viewed.plan);
  return dump(Json{{"hello",
                    {{"protocol", view_protocol},
                     {"program", viewed.program},
                     {"title", viewed.title},
                     {"camera", json_of_camera(viewed.plan.scene.camera)},
                     {"bounds", {json_of(bounds.min), json_of(bounds.max)}},
                     {"background", css_color(viewed.plan.scene.background)},
                     {"surfaces", surfaces}}}});
}

}  // namespace rhoray::tools

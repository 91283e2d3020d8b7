#include <algorithm>

#include "render/document.h"
#include "render/document/clip.h"
#include "render/document/feature_edges.h"
#include "render/document/lights.h"
#include "render/document/material.h"
#include "render/document/slices.h"
#include "render/document/styles.h"
#include "render/method_words.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

std::string name_of_texture(const ResolvedScene& plan, const Texture& texture) {
  for (std::size_t i = 0; i < plan.textures.size(); ++i)
    if (&plan.textures[i].grid() == &texture.grid()) return plan.texture_data[i].name;
  return {};
}

/// A style that has the scene's lights; nothing where none has.
std::optional<std::string> style_of_lights(const ResolvedScene& plan) {
  if (has_light_of(plan.scene, plan.style)) return style_named(plan.style).name;
  for (const Style& style : styles())
    if (has_light_of(plan.scene, style.name)) return style.name;
  return std::nullopt;
}

/// The data of a command line have no name.
std::string name_of(const DataSpec& data) {
  return data.name.empty() ? "data" : data.name;
}

/// Whether a dataset is the boundary of a mesh that stands before it.
bool is_boundary_of_other(const ResolvedScene& plan, std::size_t dataset) {
  return std::any_of(plan.data.begin(), plan.data.begin() + static_cast<std::ptrdiff_t>(dataset),
                     [&](const DataSpec& other) { return other.name == plan.data[dataset].name; });
}

}  // namespace

SceneSpec to_spec(const ResolvedScene& plan) {
  const Camera& camera = plan.scene.camera;
  SceneSpec scene_spec;
  for (std::size_t i = 0; i < plan.data.size(); ++i)
    if (!is_boundary_of_other(plan, i)) scene_spec.data.push_back(plan.data[i]);
  for (DataSpec& data : scene_spec.data) data.name = name_of(data);
  scene_spec.data.insert(scene_spec.data.end(), plan.texture_data.begin(), plan.texture_data.end());
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const Layer& layer = plan.scene.layers[i];
    LayerSpec spec{.data = name_of(plan.data[layer.dataset])};
    if (layer.mode != Mode::slice) {
      const MethodOption method = option_of(layer.method, layer.mode, plan.datasets[layer.dataset].is_mesh());
      (method.option == "--accuracy" ? spec.accuracy : spec.method) = method.word;
    }
    if (layer.mode == Mode::slice) {
      say_slice(layer, spec);
    } else if (layer.mode == Mode::mip) {
      spec.type = LayerType::mip;
      spec.colormap = word_of(layer.map);
      say_scale(layer.scale, spec);
      if (layer.window.lo < layer.window.hi) spec.range = layer.window;  // else that of a constant field, as without
    } else {
      if (layer.mode == Mode::isosurface)
        spec.isovalues = {concat(layer.isovalue)};
      else
        spec.type = plan.datasets[layer.dataset].has_fields() ? LayerType::boundary : LayerType::triangles;
      spec.color = Color{layer.material.color};
      spec.normals = word_of(layer.material.normals, has_flat_normals(plan.datasets[layer.dataset]));
      if (const auto& colors = layer.material.color_by) {
        spec.color_by = colors->field;
        spec.colormap = word_of(colors->map);
        say_scale(colors->scale, spec);
        if (colors->range.lo < colors->range.hi) spec.range = colors->range;  // else the field's, as without
      }
      if (layer.material.texture) spec.texture = name_of_texture(plan, *layer.material.texture);
      spec.ambient = layer.material.ambient;
      spec.specular = layer.material.specular;
      spec.shininess = layer.material.shininess;
      spec.opacity = layer.material.opacity;
      if (const double edges = plan.origins[i].feature_edges_deg;
          edges < no_feature_edges || is_plain_boundary(plan, i))
        spec.feature_edges = edges;
    }
    if (plan.scene.clip) spec.clip = layer.clipped;
    scene_spec.layers.push_back(std::move(spec));
  }
  scene_spec.clip = clip_spec(plan.scene.clip);
  if (const auto style = style_of_lights(plan))
    scene_spec.style = *style;
  else
    scene_spec.lights = light_specs(plan.scene.lights);
  scene_spec.effects = effects_spec(plan.scene);
  scene_spec.camera.position = camera.position;
  scene_spec.camera.target = camera.target;
  scene_spec.camera.up = camera.up;
  if (camera.orthographic)
    scene_spec.camera.orthographic_height = camera.orthographic_height;
  else
    scene_spec.camera.fov_deg = camera.vertical_fov_deg;
  if (plan.space != formats::Space::ras) scene_spec.space = "lps";
  scene_spec.annotations = plan.annotations;
  scene_spec.image.size = PictureSize{plan.frame.width, plan.frame.height};
  scene_spec.image.background = Background{Color{plan.scene.background}};
  if (plan.scene.transparent_background) scene_spec.image.background->color.reset();
  if (plan.frame.channels.any()) scene_spec.image.channels = words_of(plan.frame.channels);
  if (plan.page) scene_spec.image.show = word_of(*plan.page);
  if (!plan.frame.use_hierarchy) scene_spec.image.hierarchy = false;
  scene_spec.image.antialias = plan.frame.antialiasing;
  return scene_spec;
}

}  // namespace rhoray::render

#include "tools/rhoray/scene/to_spec.h"

#include "tools/rhoray/method_names.h"
#include "tools/rhoray/scene/clip.h"
#include "tools/rhoray/scene/document.h"
#include "tools/rhoray/scene/lights.h"
#include "tools/rhoray/scene/material.h"
#include "tools/rhoray/scene/picture_names.h"
#include "tools/rhoray/scene/slices.h"

namespace rhoray::tools {

namespace {

std::string name_of_texture(const ResolvedScene& plan, const render::Texture& texture) {
  for (std::size_t i = 0; i < plan.textures.size(); ++i)
    if (&plan.textures[i].grid() == &texture.grid()) return plan.texture_data[i].name;
  return {};
}

std::string text_of_vector(const Vec3& v) {
  return concat(v.x, ",", v.y, ",", v.z);
}

/// Whether annotations say what no option says.
bool needs_words(const AnnotationsSpec& annotations) {
  const auto& [axes, box, bar, caption] = annotations;
  return (axes && !axes->corner.empty()) || (bar && !(bar->title.empty() && bar->position.empty()));
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += concat(text.empty() ? "" : ",", word);
  return text;
}

}  // namespace

SceneSpec to_spec(const ResolvedScene& plan) {
  const render::Camera& camera = plan.scene.camera;
  SceneSpec scene_spec{.data = plan.data};
  for (std::size_t i = 0; i < scene_spec.data.size(); ++i)
    if (scene_spec.data[i].name.empty()) scene_spec.data[i].name = "data";  // of a command line
  scene_spec.data.insert(scene_spec.data.end(), plan.texture_data.begin(), plan.texture_data.end());
  for (const render::Layer& layer : plan.scene.layers) {
    LayerSpec spec{.data = scene_spec.data[layer.volume].name};
    if (layer.mode != render::Mode::slice) {
      const MethodOption method = option_of(layer.method, layer.mode, plan.volumes[layer.volume].is_mesh());
      (method.option == "--accuracy" ? spec.accuracy : spec.method) = method.word;
    }
    if (layer.mode == render::Mode::slice) {
      say_slice(layer, spec);
    } else if (layer.mode == render::Mode::mip) {
      spec.type = LayerType::mip;
      spec.range = layer.window;
    } else {
      if (layer.mode == render::Mode::isosurface)
        spec.isovalues = {concat(layer.isovalue)};
      else
        spec.type = LayerType::mesh;
      spec.color = Color{layer.surface.color};
      spec.normals = word_of(layer.surface.normals, has_flat_normals(plan.volumes[layer.volume]));
      if (const auto& colors = layer.surface.color_by) {
        spec.color_by = colors->field;
        spec.colormap = word_of(colors->map);
        if (colors->range.lo < colors->range.hi) spec.range = colors->range;  // else the field's, as without
      }
      if (layer.surface.texture) spec.texture = name_of_texture(plan, *layer.surface.texture);
      spec.ambient = layer.surface.ambient;
      spec.specular = layer.surface.specular;
      spec.shininess = layer.surface.shininess;
      spec.opacity = layer.surface.opacity;
    }
    if (plan.scene.clip) spec.clip = layer.clipped;
    scene_spec.layers.push_back(std::move(spec));
  }
  scene_spec.clip = clip_spec(plan.scene.clip);
  scene_spec.lights = light_specs(plan.scene.lights);
  scene_spec.effects = effects_spec(plan.scene);
  scene_spec.camera.position = camera.position;
  scene_spec.camera.target = camera.target;
  scene_spec.camera.up = camera.up;
  if (camera.orthographic)
    scene_spec.camera.orthographic_height = camera.orthographic_height;
  else
    scene_spec.camera.fov_deg = camera.vertical_fov_deg;
  scene_spec.annotations = plan.annotations;
  scene_spec.image.size = PictureSize{plan.frame.width, plan.frame.height};
  scene_spec.image.background = Color{plan.scene.background};
  if (plan.frame.channels.any()) scene_spec.image.channels = words_of(plan.frame.channels);
  if (plan.page) scene_spec.image.show = word_of(*plan.page);
  if (!plan.frame.use_hierarchy) scene_spec.image.hierarchy = false;
  if (plan.frame.antialiasing > 1) scene_spec.image.antialias = plan.frame.antialiasing;
  return scene_spec;
}

std::vector<std::string> reproducing_command(const ResolvedScene& plan, const std::filesystem::path& output) {
  const SceneSpec scene_spec = to_spec(plan);
  std::vector<std::string> words{"rhoray", "render"};
  const AnnotationsSpec& annotations = scene_spec.annotations;
  const bool needs_document = needs_words(annotations) || plan.scene.layers.size() > 1 || scene_spec.lights ||
                              scene_spec.effects.occlusion || scene_spec.effects.fog ||
                              (plan.scene.clip && !plan.scene.layers[0].clipped) ||
                              plan.scene.layers[0].mode == render::Mode::slice;
  if (needs_document) {
    words.insert(words.end(), {dump(scene_json(scene_spec)), "-o", output.string()});
    return words;
  }
  const LayerSpec& layer = scene_spec.layers[0];
  const CameraSpec& camera = scene_spec.camera;
  const PictureSpec& image = scene_spec.image;
  words.insert(words.end(), {scene_spec.data[0].file.string(), "-o", output.string()});
  const auto add = [&](const std::string& name, const std::string& value) { words.insert(words.end(), {name, value}); };
  const bool is_field = plan.scene.layers[0].mode != render::Mode::triangles;
  if (is_field) add("--field", scene_spec.data[0].field);
  if (layer.type == LayerType::mip) {
    add("--mode", "mip");
    add("--range", concat(layer.range->lo, ",", layer.range->hi));
  } else {
    if (is_field) {
      add("--mode", "iso");
      add("--iso", layer.isovalues[0]);
    }
    add("--surface-color", text_of_vector(layer.color->linear));
    add("--normals", layer.normals);
    if (!layer.color_by.empty()) {
      add("--color-by", layer.color_by);
      add("--colormap", layer.colormap);
      if (layer.range) add("--range", concat(layer.range->lo, ",", layer.range->hi));
    }
    if (!layer.texture.empty()) add("--texture", plan.texture_data[0].file.string());
    add("--ambient", concat(*layer.ambient));
    add("--specular", concat(*layer.specular));
    add("--shininess", concat(*layer.shininess));
    add("--opacity", concat(*layer.opacity));
  }
  if (layer.method.empty())
    add("--accuracy", layer.accuracy);
  else
    add("--method", layer.method);
  if (scene_spec.clip)
    for (const std::string& word : clip_words(*scene_spec.clip)) words.push_back(word);
  add("--size", concat(image.size->width, "x", image.size->height));
  add("--camera-position", text_of_vector(*camera.position));
  add("--camera-target", text_of_vector(*camera.target));
  add("--camera-up", text_of_vector(*camera.up));
  if (camera.orthographic_height)
    add("--ortho-height", concat(*camera.orthographic_height));
  else
    add("--fov", concat(*camera.fov_deg));
  add("--background", text_of_vector(image.background->linear));
  if (image.channels) add("--channels", joined(*image.channels));
  if (image.show) add("--show", *image.show);
  if (image.hierarchy) words.push_back("--no-hierarchy");
  if (image.antialias) add("--antialias", concat(*image.antialias));
  if (annotations.axes) words.push_back("--axes");
  if (annotations.box.value_or(false)) words.push_back("--box");
  if (annotations.color_bar) words.push_back("--colorbar");
  if (!annotations.caption.empty()) add("--caption", annotations.caption);
  return words;
}

}  // namespace rhoray::tools

#include "tools/rhoray/scene/spelled_out.h"

#include "tools/rhoray/method_words.h"
#include "tools/rhoray/scene/clip.h"
#include "tools/rhoray/scene/document.h"
#include "tools/rhoray/scene/lights.h"
#include "tools/rhoray/scene/looks.h"
#include "tools/rhoray/scene/picture_words.h"
#include "tools/rhoray/scene/slices.h"

namespace rhoray::tools {

namespace {

std::string name_of_texture(const ScenePlan& plan, const render::Texture& texture) {
  for (std::size_t i = 0; i < plan.textures.size(); ++i)
    if (&plan.textures[i].grid() == &texture.grid()) return plan.texture_data[i].name;
  return {};
}

std::string text_of_vector(const Vec3& v) {
  return concat(v.x, ",", v.y, ",", v.z);
}

/// Whether annotations say what no option says.
bool needs_words(const AnnotationsWish& annotations) {
  const auto& [axes, box, bar, caption] = annotations;
  return (axes && !axes->corner.empty()) || (bar && !(bar->title.empty() && bar->position.empty()));
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += concat(text.empty() ? "" : ",", word);
  return text;
}

}  // namespace

SceneWishes spelled_out(const ScenePlan& plan) {
  const render::Camera& camera = plan.scene.camera;
  SceneWishes wishes{.data = plan.data};
  for (std::size_t i = 0; i < wishes.data.size(); ++i)
    if (wishes.data[i].name.empty()) wishes.data[i].name = "data";  // of a command line
  wishes.data.insert(wishes.data.end(), plan.texture_data.begin(), plan.texture_data.end());
  for (const render::Layer& layer : plan.scene.layers) {
    LayerWish wish{.data = wishes.data[layer.volume].name};
    if (layer.mode != render::Mode::slice) {
      const MethodOption method = option_of(layer.method, layer.mode, plan.volumes[layer.volume].is_mesh());
      (method.option == "--accuracy" ? wish.accuracy : wish.method) = method.word;
    }
    if (layer.mode == render::Mode::slice) {
      say_slice(layer, wish);
    } else if (layer.mode == render::Mode::mip) {
      wish.type = LayerType::mip;
      wish.range = layer.window;
    } else {
      if (layer.mode == render::Mode::isosurface)
        wish.isovalues = {concat(layer.isovalue)};
      else
        wish.type = LayerType::mesh;
      wish.color = Color{layer.surface.color};
      wish.normals = word_of(layer.surface.normals, has_flat_normals(plan.volumes[layer.volume]));
      if (const auto& colors = layer.surface.color_by) {
        wish.color_by = colors->field;
        wish.colormap = word_of(colors->map);
        if (colors->range.lo < colors->range.hi) wish.range = colors->range;  // else the field's, as without
      }
      if (layer.surface.texture) wish.texture = name_of_texture(plan, *layer.surface.texture);
      wish.ambient = layer.surface.ambient;
      wish.specular = layer.surface.specular;
      wish.shininess = layer.surface.shininess;
      wish.opacity = layer.surface.opacity;
    }
    if (plan.scene.clip) wish.clip = layer.clipped;
    wishes.layers.push_back(std::move(wish));
  }
  wishes.clip = clip_wish(plan.scene.clip);
  wishes.lights = light_wishes(plan.scene.lights);
  wishes.effects = effect_wishes(plan.scene);
  wishes.camera.position = camera.position;
  wishes.camera.target = camera.target;
  wishes.camera.up = camera.up;
  if (camera.orthographic)
    wishes.camera.orthographic_height = camera.orthographic_height;
  else
    wishes.camera.fov_deg = camera.vertical_fov_deg;
  wishes.annotations = plan.annotations;
  wishes.image.size = PictureSize{plan.frame.width, plan.frame.height};
  wishes.image.background = Color{plan.scene.background};
  if (plan.frame.channels.any()) wishes.image.channels = words_of(plan.frame.channels);
  if (plan.page) wishes.image.show = word_of(*plan.page);
  if (!plan.frame.use_hierarchy) wishes.image.hierarchy = false;
  if (plan.frame.antialiasing > 1) wishes.image.antialias = plan.frame.antialiasing;
  return wishes;
}

std::vector<std::string> reproducing_command(const ScenePlan& plan, const std::filesystem::path& output) {
  const SceneWishes wishes = spelled_out(plan);
  std::vector<std::string> words{"rhoray", "render"};
  const AnnotationsWish& annotations = wishes.annotations;
  const bool needs_document = needs_words(annotations) || plan.scene.layers.size() > 1 || wishes.lights ||
                              wishes.effects.occlusion || wishes.effects.fog ||
                              (plan.scene.clip && !plan.scene.layers[0].clipped) ||
                              plan.scene.layers[0].mode == render::Mode::slice;
  if (needs_document) {
    words.insert(words.end(), {dump(scene_json(wishes)), "-o", output.string()});
    return words;
  }
  const LayerWish& layer = wishes.layers[0];
  const CameraWish& camera = wishes.camera;
  const ImageWish& image = wishes.image;
  words.insert(words.end(), {wishes.data[0].file.string(), "-o", output.string()});
  const auto add = [&](const std::string& name, const std::string& value) { words.insert(words.end(), {name, value}); };
  const bool is_field = plan.scene.layers[0].mode != render::Mode::triangles;
  if (is_field) add("--field", wishes.data[0].field);
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
  if (wishes.clip)
    for (const std::string& word : clip_words(*wishes.clip)) words.push_back(word);
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

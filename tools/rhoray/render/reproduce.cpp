#include "tools/rhoray/render/reproduce.h"

#include "formats/base/word_list.h"
#include "render/document.h"
#include "render/scene_words.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tools {

namespace {

std::string text_of_vector(const Vec3& v) {
  return concat(v.x, ",", v.y, ",", v.z);
}

std::string words_of(const Vec3& a, const Vec3& b) {
  return concat(a.x, ",", a.y, ",", a.z, ",", b.x, ",", b.y, ",", b.z);
}

/// The options of a clip region.
std::vector<std::string> clip_words(const render::ClipSpec& spec) {
  std::vector<std::string> words;
  if (spec.box) words.insert(words.end(), {"--clip-box", words_of(spec.box->min, spec.box->max)});
  for (const render::HalfSpace& plane : spec.planes)
    words.insert(words.end(), {"--clip-plane", words_of(plane.point, plane.normal)});
  if (spec.keep == render::keep_outside) words.emplace_back("--cut-away");
  return words;
}

/// Whether annotations say what no option says.
bool needs_words(const render::AnnotationsSpec& annotations) {
  const auto& [axes, box, bar, legend, caption] = annotations;
  return (axes && !axes->corner.empty()) || (bar && !(bar->title.empty() && bar->position.empty()));
}

}  // namespace

bool is_of_one_layer(const render::ResolvedScene& plan) {
  return plan.scene.layers.size() == 1 || (plan.scene.layers.size() == 2 && plan.origins[1].is_context);
}

std::vector<std::string> reproducing_command(const render::ResolvedScene& plan, const std::filesystem::path& output) {
  const render::SceneSpec scene_spec = to_spec(plan);
  std::vector<std::string> words{"rhoray", "render"};
  const render::AnnotationsSpec& annotations = scene_spec.annotations;
  const bool needs_document = needs_words(annotations) || !is_of_one_layer(plan) || plan.data[0].label ||
                              scene_spec.lights || scene_spec.effects.occlusion || scene_spec.effects.fog ||
                              (plan.scene.clip && !plan.scene.layers[0].clipped) ||
                              plan.scene.layers[0].mode == render::Mode::slice;
  if (needs_document) {
    words.insert(words.end(), {render::scene_text(scene_spec), "-o", output.string()});
    return words;
  }
  const render::LayerSpec& layer = scene_spec.layers[0];
  const render::CameraSpec& camera = scene_spec.camera;
  const render::PictureSpec& image = scene_spec.image;
  words.insert(words.end(), {scene_spec.data[0].file.string(), "-o", output.string()});
  const auto add = [&](const std::string& name, const std::string& value) { words.insert(words.end(), {name, value}); };
  const auto add_colors = [&] {
    add("--colormap", layer.colormap);
    if (!layer.scale.empty()) add("--color-scale", layer.scale);
    if (layer.levels) add("--levels", concat(*layer.levels));
    if (layer.range) add("--range", concat(layer.range->lo, ",", layer.range->hi));
  };
  const std::vector<std::string> read = preprocess::option_words(pack_options(scene_spec.data[0].read));
  words.insert(words.end(), read.begin(), read.end());
  const bool is_boundary = layer.type == render::LayerType::boundary;
  if (plan.datasets[0].has_fields()) add("--field", scene_spec.data[0].field);
  if (layer.type == render::LayerType::mip) {
    add("--mode", "mip");
    add_colors();
  } else {
    if (is_boundary) add("--mode", "boundary");
    if (layer.type == render::LayerType::isosurface) {
      add("--mode", "iso");
      add("--iso", layer.isovalues[0]);
    }
    if (plan.scene.layers.size() == 2) add("--context", concat(*scene_spec.layers[1].opacity));
    add("--surface-color", text_of_vector(layer.color->linear));
    add("--normals", layer.normals);
    if (!layer.color_by.empty()) {
      add("--color-by", layer.color_by);
      add_colors();
    }
    if (!layer.texture.empty()) add("--texture", plan.texture_data[0].file.string());
    add("--ambient", concat(*layer.ambient));
    add("--specular", concat(*layer.specular));
    add("--shininess", concat(*layer.shininess));
    add("--opacity", concat(*layer.opacity));
    if (layer.feature_edges) add("--feature-edges", concat(*layer.feature_edges));
  }
  add("--style", scene_spec.style);
  if (layer.method.empty())
    add("--accuracy", layer.accuracy);
  else
    add("--method", layer.method);
  if (scene_spec.clip)
    for (const std::string& word : clip_words(*scene_spec.clip)) words.push_back(word);
  if (!scene_spec.space.empty()) add("--space", scene_spec.space);
  add("--size", concat(image.size->width, "x", image.size->height));
  add("--camera-position", text_of_vector(*camera.position));
  add("--camera-target", text_of_vector(*camera.target));
  add("--camera-up", text_of_vector(*camera.up));
  if (camera.orthographic_height)
    add("--ortho-height", concat(*camera.orthographic_height));
  else
    add("--fov", concat(*camera.fov_deg));
  add("--background", image.background->color ? text_of_vector(image.background->color->linear) : "none");
  if (image.channels) add("--channels", joined(*image.channels, ","));
  if (image.show) add("--show", *image.show);
  if (image.hierarchy) words.push_back("--no-hierarchy");
  add("--antialias", concat(*image.antialias));
  if (annotations.axes) words.push_back("--axes");
  if (annotations.box.value_or(false)) words.push_back("--box");
  if (annotations.color_bar) words.push_back("--colorbar");
  if (annotations.legend) add("--legend", *annotations.legend ? "on" : "off");
  if (!annotations.caption.empty()) add("--caption", annotations.caption);
  return words;
}

}  // namespace rhoray::tools

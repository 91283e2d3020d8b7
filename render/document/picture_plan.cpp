#include "render/document/picture_plan.h"

#include <algorithm>
#include <utility>

#include "formats/base/error.h"
#include "render/document/styles.h"
#include "render/document/values.h"
#include "render/method_words.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

/// Whether colours of the picture represent values: of a field, a projection or a heat map.
bool shows_values(const ResolvedScene& plan) {
  return plan.page || std::any_of(plan.scene.layers.begin(), plan.scene.layers.end(), [](const Layer& layer) {
           return layer.mode == Mode::mip || layer.material.color_by;
         });
}

/// Whether the colour of a layer stands for an isovalue or a label.
bool has_own_color(const ResolvedScene& plan, const Layer& layer) {
  const bool is_named = layer.mode == Mode::isosurface || plan.data[layer.dataset].label;
  return is_named && !layer.material.color_by && !layer.material.texture;
}

}  // namespace

void plan_image(const SceneSpec& scene_spec, ResolvedScene& plan) {
  const PictureSpec& image = scene_spec.image;
  const PictureSize size = image.size.value_or(PictureSize{});
  plan.frame.width = size.width;
  plan.frame.height = size.height;
  plan.frame.channels = channel_set(image.channels.value_or(std::vector<std::string>{}));
  plan.frame.use_hierarchy = image.hierarchy.value_or(true);
  plan.page = page_named(image.show.value_or("color"));
  const std::vector<Layer>& layers = plan.scene.layers;
  const bool is_projection =
      std::all_of(layers.begin(), layers.end(), [](const Layer& layer) { return layer.mode == Mode::mip; });
  plan.style = scene_spec.style;
  const Style& style = style_named(plan.style);
  plan.frame.antialiasing = image.antialias.value_or(is_projection || plan.page ? 1 : style.antialiasing);
  if (plan.page && plan.frame.antialiasing > 1) {
    plan.frame.antialiasing = 1;
    plan.notes.push_back("no antialiasing: a heat map shows one ray per pixel");
  }
  const bool shows_error = plan.page && channel_of(*plan.page).error;
  if ((plan.frame.channels.error || shows_error) &&
      !std::all_of(layers.begin(), layers.end(), [](const Layer& layer) { return proves(layer.method); }))
    at_place(root(scene_spec).at("image").at(shows_error ? "show" : "channels"),
             [] { throw Error(ErrorCode::usage, "the channel 'error' needs accuracy certified or exact"); });
  const bool has_color = image.background && image.background->color;
  plan.scene.background = has_color       ? image.background->color->linear
                          : is_projection ? Vec3(0, 0, 0)
                                          : style.background;
  plan.scene.transparent_background = image.background && !has_color;
  if (plan.page && plan.scene.transparent_background)
    at_place(root(scene_spec).at("image").at("background"), [&] {
      throw Error(ErrorCode::usage,
                  concat(scene_spec.document.empty() ? "--background none: " : "", "a heat map fills the picture"));
    });
}

void plan_annotations(const SceneSpec& scene_spec, ResolvedScene& plan) {
  const AnnotationsSpec needed = std::exchange(plan.annotations, scene_spec.annotations);
  const std::vector<Layer>& layers = plan.scene.layers;
  const auto refuse = [&](const char* key, const std::string& fact) {
    at_place(root(scene_spec).at("annotations").at(key), [&] {
      throw Error(ErrorCode::usage, scene_spec.document.empty() ? concat("--", key, ": ", fact) : fact);
    });
  };
  // Documents were checked when they were read.
  const std::size_t characters = character_count(plan.annotations.caption);
  if (characters > limits::drawn_text.hi)
    refuse("caption", concat("found ", characters, " characters; expected at most ", limits::drawn_text.hi));
  if (plan.annotations.color_bar && !shows_values(plan)) refuse("colorbar", "nothing here is coloured by a field");
  const bool can_have_legend = !plan.page && std::any_of(layers.begin(), layers.end(), [&](const Layer& layer) {
    return has_own_color(plan, layer);
  });
  if (plan.annotations.legend.value_or(false) && !can_have_legend)
    refuse("legend", "no isosurface or label here has a colour of its own");
  if (plan.page) return;  // a heat map shows none of these colours
  const auto take = [&](auto AnnotationsSpec::*member, bool has_use) {
    if (plan.annotations.*member || !(needed.*member) || !has_use) return;
    plan.annotations.*member = needed.*member;
    plan.has_default_annotations = true;
  };
  take(&AnnotationsSpec::legend, can_have_legend);
  take(&AnnotationsSpec::color_bar, true);
  take(&AnnotationsSpec::box, true);
}

}  // namespace rhoray::render

#include "tools/rhoray/scene/plan.h"

#include <algorithm>
#include <array>

#include "formats/base/nearest_name.h"
#include "formats/base/trouble.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/method_words.h"
#include "tools/rhoray/scene/annotations.h"
#include "tools/rhoray/scene/clip.h"
#include "tools/rhoray/scene/light_notes.h"
#include "tools/rhoray/scene/lights.h"
#include "tools/rhoray/scene/looks.h"
#include "tools/rhoray/scene/picture_words.h"
#include "tools/rhoray/scene/place.h"
#include "tools/rhoray/scene/slices.h"
#include "tools/rhoray/scene/tables.h"

namespace rhoray::tools {

namespace {

/// Colours of several isosurfaces, in order: Paul Tol's scheme "light" (technical note SRON/EPS/TN/09-002), made to be
/// told apart with any colour vision; they are light enough that shading still shows.
constexpr std::array palette{"#77aadd", "#ee8866", "#eedd88", "#44bb99", "#ffaabb", "#bbcc33", "#99ddff", "#aaaa00"};

Place root(const SceneWishes& wishes) {
  return {wishes.document, {}};
}
Place layer_place(const SceneWishes& wishes, std::size_t layer) {
  return root(wishes).at("layers").at(layer);
}

/// What the act refuses is refused with its place in the document. On the command line the messages name the options.
template <class Act>
auto at_place(const Place& place, const Act& act) {
  try {
    return act();
  } catch (const Error& error) {
    if (place.document.empty()) throw;
    const Trouble trouble = error.trouble() == Trouble::usage ? Trouble::invalid : error.trouble();
    throw Error(trouble, concat(place.text(), ": ", error.what()), error.hint());
  }
}

std::vector<std::string> names_of(const std::vector<DataWish>& data) {
  std::vector<std::string> names;
  for (const DataWish& each : data) names.push_back(each.name);
  return names;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += concat(text.empty() ? "" : ", ", '"', name, '"');
  return text;
}

/// The data that a layer names.
/// @param key  of the layer, where the name stands
const DataWish& data_named(const SceneWishes& wishes, const std::string& name, const Place& key) {
  const std::vector<std::string> names = names_of(wishes.data);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(
        Trouble::invalid,
        concat(key.text(), ": found \"", name, "\"; expected ", names.size() == 1 ? "" : "one of ", listed(names)),
        did_you_mean(name, names));
  return wishes.data[static_cast<std::size_t>(found - names.begin())];
}

const DataWish& data_of(const SceneWishes& wishes, std::size_t index) {
  const LayerWish& layer = wishes.layers[index];
  const std::vector<std::string> names = names_of(wishes.data);
  if (layer.data.empty() && wishes.data.size() == 1) return wishes.data[0];
  if (layer.data.empty())
    throw Error(Trouble::invalid,
                concat(layer_place(wishes, index).text(), ": has no \"data\"; expected one of ", listed(names)));
  return data_named(wishes, layer.data, layer_place(wishes, index).at("data"));
}

/// The index of the data's volume, opened when it is first asked for.
std::size_t volume_of(const SceneWishes& wishes, const DataWish& data, const OpenData& open, ScenePlan& plan) {
  const std::vector<std::string> names = names_of(plan.data);
  const auto found = std::find(names.begin(), names.end(), data.name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const Place place = root(wishes).at("data").at(data.name).at(data.field.empty() ? "file" : "field");
  plan.volumes.push_back(at_place(place, [&] { return open(data); }));
  const render::Volume& volume = plan.volumes.back();
  plan.data.push_back(data);
  plan.data.back().field = volume.field().name;
  for (const std::string& note : volume.notes()) plan.notes.push_back(note);
  if (!volume.is_surface() && data.field.empty() && volume.field().name != volume.field_names().front())
    plan.notes.push_back(concat("field '", volume.field_names().front(), "' is the same everywhere: '",
                                volume.field().name, "' is shown"));
  return plan.volumes.size() - 1;
}

/// The texture of a layer that names one, opened when it is first asked for.
std::optional<render::Texture> texture_of(const SceneWishes& wishes, std::size_t index, ScenePlan& plan) {
  const LayerWish& layer = wishes.layers[index];
  if (layer.texture.empty()) return std::nullopt;
  const Place key = layer_place(wishes, index).at("texture");
  const DataWish& data = data_named(wishes, layer.texture, key);
  at_place(key, [&] {
    const std::string option = wishes.document.empty() ? "--texture: " : "";
    if (!layer.color_by.empty())
      throw Error(Trouble::usage, concat(option, wishes.document.empty() ? "--color-by" : "\"color_by\"",
                                         " is there too; expected one of the two"));
    if (!data.field.empty())
      throw Error(Trouble::usage, concat(data.file.string(), ": field '", data.field, "': colours have no fields"));
  });
  const std::vector<std::string> names = names_of(plan.texture_data);
  const auto found = std::find(names.begin(), names.end(), data.name);
  if (found != names.end()) return plan.textures[static_cast<std::size_t>(found - names.begin())];
  plan.textures.push_back(at_place(key, [&] { return load_texture(data.file); }));
  plan.texture_data.push_back(data);
  return plan.textures.back();
}

/// Tells of textures that lie nowhere near the surface that they are to cover.
void note_textures_elsewhere(ScenePlan& plan) {
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const render::Layer& layer = plan.scene.layers[i];
    if (!layer.surface.texture) continue;
    const render::Volume& volume = plan.volumes[layer.volume];
    const render::Texture& texture = *layer.surface.texture;
    if (texture.contains(volume.bounds())) continue;
    const bool is_near =
        texture.may_overlap(volume.bounds()) &&
        (layer.mode == render::Mode::triangles || texture.may_overlap(volume.isosurface_bounds(layer.isovalue)));
    if (!is_near)
      plan.notes.push_back(concat("the texture ", texture.file().name(), " covers nothing of layer ", i,
                                  ": it lies elsewhere in the world; check spacing and origin of both"));
  }
}

bool is_level_of_triangles(const std::string& accuracy) {
  return accuracy == "float" || accuracy == "double";
}

/// The level asked for, by the layer or the scene; a scene's level that triangles have not is none of theirs.
std::string accuracy_of(const SceneWishes& wishes, const LayerWish& layer) {
  if (!layer.accuracy.empty()) return layer.accuracy;
  return layer.type != LayerType::mesh || is_level_of_triangles(wishes.accuracy) ? wishes.accuracy : "";
}

render::Method choose_method(const SceneWishes& wishes, std::size_t index, render::Mode mode,
                             const render::Volume& volume) {
  const LayerWish& layer = wishes.layers[index];
  const Place place = layer_place(wishes, index).at("method");
  if (!layer.method.empty() && !layer.accuracy.empty())
    throw Error(Trouble::invalid, concat(place.text(), ": \"accuracy\" is there too; expected one of the two"));
  if (!layer.method.empty())
    return at_place(Place{wishes.document, {}}, [&] {
      return wishes.document.empty() ? method_named(layer.method, mode, volume.is_mesh())
                                     : method_named(layer.method, mode, volume.is_mesh(), place.pointer);
    });
  const std::string accuracy = accuracy_of(wishes, layer);
  return accuracy.empty() ? render::default_method(volume, mode) : render::method_of(accuracy_named(accuracy));
}

/// What a layer says of fields is refused where its data are triangles.
void refuse_words_of_fields(const SceneWishes& wishes, const LayerWish& layer, const render::Volume& volume) {
  const LayerWish defaults;
  const std::string accuracy = accuracy_of(wishes, layer);
  for (const auto& [given, option] : {std::pair{layer.isovalues != defaults.isovalues, "--iso"},
                                      {layer.type == LayerType::mip, "--mode"},
                                      {layer.type == LayerType::slice, "--slice"},
                                      {!layer.color_by.empty(), "--color-by"},
                                      {!layer.colormap.empty(), "--colormap"},
                                      {layer.range.has_value(), "--range"},
                                      {!layer.method.empty(), "--method"}})
    if (given)
      throw Error(Trouble::usage,
                  concat(option, ": is of fields, and ", volume.file().name(), " holds triangles, shown as they are"));
  if (!accuracy.empty() && !is_level_of_triangles(accuracy))
    throw Error(Trouble::usage, concat("--accuracy: found '", accuracy, "'; expected float or double of ",
                                       volume.file().name(), ", which holds triangles"));
}

/// Adds the layers of a planned scene one after another.
class LayerPlanner {
 public:
  LayerPlanner(const SceneWishes& wishes, const OpenData& open) : wishes_(wishes), open_(open) {}

  ScenePlan plan() {
    for (std::size_t index = 0; index < wishes_.layers.size(); ++index)
      if (wishes_.layers[index].visible) add(index);
    require_layers();
    note_invisible_surfaces();
    color_several_surfaces();
    note_textures_elsewhere(plan_);
    return std::move(plan_);
  }

 private:
  struct Outside {
    std::size_t wish, isovalue, volume;
  };

  void add(std::size_t index) {
    const LayerWish& wish = wishes_.layers[index];
    render::Layer layer;
    layer.volume = volume_of(wishes_, data_of(wishes_, index), open_, plan_);
    layer.clipped = wish.clip.value_or(true);
    const render::Volume& volume = plan_.volumes[layer.volume];
    if (volume.is_surface()) return add_triangles(index, layer);
    if (wish.type == LayerType::mesh) refuse_fields(index, volume);
    if (wish.type == LayerType::slice) {
      choose_slice(wish, volume, layer_place(wishes_, index), layer);
      return put(index, layer, {});
    }
    layer.mode = wish.type == LayerType::mip ? render::Mode::mip : render::Mode::isosurface;
    layer.method = choose_method(wishes_, index, layer.mode, volume);
    switch (wish.type) {
      case LayerType::isosurface:
        layer.surface = choose_surface(wish, volume, layer_place(wishes_, index));
        layer.surface.texture = texture_of(wishes_, index, plan_);
        return add_isosurfaces(index, layer);
      case LayerType::mip:
        return add_projection(index, layer);
      case LayerType::mesh:
      case LayerType::slice:
        break;
    }
  }

  /// What is to be triangles, and is not.
  [[noreturn]] void refuse_fields(std::size_t index, const render::Volume& volume) const {
    const std::string fact = concat(volume.file().name(), ": is a ", volume.is_mesh() ? "mesh of tetrahedra" : "grid",
                                    "; expected a packed surface of triangles");
    throw Error(Trouble::invalid,
                wishes_.document.empty() ? concat("--mesh: ", fact)
                                         : concat(layer_place(wishes_, index).at("data").text(), ": ", fact),
                "its isosurfaces are layers of type \"isosurface\"");
  }

  void add_triangles(std::size_t index, render::Layer layer) {
    const LayerWish& wish = wishes_.layers[index];
    const render::Volume& volume = plan_.volumes[layer.volume];
    at_place(layer_place(wishes_, index), [&] { refuse_words_of_fields(wishes_, wish, volume); });
    layer.mode = render::Mode::triangles;
    layer.method = choose_method(wishes_, index, layer.mode, volume);
    layer.surface = choose_surface(wish, volume, layer_place(wishes_, index));
    layer.surface.texture = texture_of(wishes_, index, plan_);
    put(index, layer, {});
  }

  void add_isosurfaces(std::size_t index, const render::Layer& layer) {
    const std::vector<std::string>& isovalues = wishes_.layers[index].isovalues;
    const render::Volume& volume = plan_.volumes[layer.volume];
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
      if (is_outside(isovalues[i], volume.field())) {
        outside_.push_back({index, i, layer.volume});
        continue;
      }
      const Isovalue isovalue = chosen(index, i, volume);
      put(index, layer, isovalue.from);
      plan_.scene.layers.back().isovalue = isovalue.value;
    }
  }

  void add_projection(std::size_t index, const render::Layer& layer) {
    const formats::FieldSummary& field = plan_.volumes[layer.volume].field();
    at_place(layer_place(wishes_, index), [&] {
      if (field.range.is_empty())
        throw Error(Trouble::invalid, concat("field '", field.name, "' holds no finite value"));
    });
    put(index, layer, {});
    plan_.scene.layers.back().window = wishes_.layers[index].range.value_or(field.range);
  }

  void put(std::size_t index, const render::Layer& layer, const std::string& isovalue_from) {
    if (plan_.origins.empty()) plan_.scene.layers.clear();
    plan_.scene.layers.push_back(layer);
    plan_.origins.push_back({index, isovalue_from});
    if (plan_.origins.size() > most_layers)
      at_place(root(wishes_).at("layers"),
               [] { throw Error(Trouble::usage, concat("more than ", most_layers, " layers and isovalues")); });
  }

  Place isovalue_place(std::size_t index, std::size_t i) const {
    const Place place = layer_place(wishes_, index).at("isovalue");
    return wishes_.layers[index].isovalues.size() == 1 ? place : place.at(i);
  }

  Isovalue chosen(std::size_t index, std::size_t i, const render::Volume& volume) const {
    const std::string& text = wishes_.layers[index].isovalues[i];
    if (text == "auto" && volume.is_level_set()) return {0, "the surface of the level set"};
    return at_place(isovalue_place(index, i), [&] { return choose_isovalue(text, volume.field()); });
  }

  /// Isovalues that no cell has are left out, but not the last thing that is shown.
  void require_layers() {
    if (plan_.origins.empty() && !outside_.empty())
      chosen(outside_[0].wish, outside_[0].isovalue, plan_.volumes[outside_[0].volume]);
    if (plan_.origins.empty())
      throw Error(Trouble::invalid,
                  concat(root(wishes_).at("layers").text(), ": no layer is visible; expected at least one"));
    for (const Outside& one : outside_) try {
        chosen(one.wish, one.isovalue, plan_.volumes[one.volume]);
      } catch (const Error& refusal) {
        plan_.notes.push_back(concat(refusal.what(), ": left out"));
      }
  }

  void note_invisible_surfaces() {
    for (std::size_t i = 0; i < plan_.scene.layers.size(); ++i) {
      const render::Layer& layer = plan_.scene.layers[i];
      if (layer.mode == render::Mode::mip || layer.surface.opacity > 0) continue;
      const Place place = layer_place(wishes_, plan_.origins[i].wish).at("opacity");
      plan_.notes.push_back(
          concat(wishes_.document.empty() ? "--opacity" : place.text(), ": is 0: the surface is not traced"));
    }
  }

  void color_several_surfaces() {
    std::vector<std::size_t> surfaces;
    for (std::size_t i = 0; i < plan_.scene.layers.size(); ++i)
      if (plan_.scene.layers[i].mode != render::Mode::mip && plan_.scene.layers[i].mode != render::Mode::slice)
        surfaces.push_back(i);
    if (surfaces.size() < 2) return;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if (wishes_.layers[plan_.origins[surfaces[i]].wish].color) continue;
      Color color;
      read_value(palette[i % palette.size()], color);
      plan_.scene.layers[surfaces[i]].surface.color = color.linear;
    }
  }

  const SceneWishes& wishes_;
  const OpenData& open_;
  ScenePlan plan_;
  std::vector<Outside> outside_;
};

bool proves_errors(const render::Layer& layer) {
  return render::proves(layer.method);
}

/// Size, channels and background.
void plan_image(const SceneWishes& wishes, ScenePlan& plan) {
  const ImageWish& image = wishes.image;
  const PictureSize size = image.size.value_or(PictureSize{});
  plan.frame.width = size.width;
  plan.frame.height = size.height;
  plan.frame.channels = channel_set(image.channels.value_or(std::vector<std::string>{}));
  plan.frame.use_hierarchy = image.hierarchy.value_or(true);
  plan.page = page_named(image.show.value_or("color"));
  plan.frame.antialiasing = image.antialias.value_or(1);
  if (plan.page && plan.frame.antialiasing > 1) {
    plan.frame.antialiasing = 1;
    plan.notes.push_back("antialiasing: left out, a heat map shows one ray a pixel");
  }
  const std::vector<render::Layer>& layers = plan.scene.layers;
  const bool shows_error = plan.page && render::channel_of(*plan.page).error;
  if ((plan.frame.channels.error || shows_error) && !std::all_of(layers.begin(), layers.end(), proves_errors))
    at_place(root(wishes).at("image").at(shows_error ? "show" : "channels"), [] {
      throw Error(Trouble::usage, "the channel 'error' needs a method that proves one: certified or exact");
    });
  const bool is_projection = std::all_of(layers.begin(), layers.end(),
                                         [](const render::Layer& layer) { return layer.mode == render::Mode::mip; });
  const double grey = is_projection ? 0 : 1;
  plan.scene.background = image.background ? image.background->linear : Vec3(grey, grey, grey);
}

constexpr double zoom_with_box = 0.75;  // numbers stand around it

}  // namespace

ScenePlan plan_layers(const SceneWishes& wishes, const OpenData& open) {
  ScenePlan plan = LayerPlanner(wishes, open).plan();
  plan_image(wishes, plan);
  const Place clip = root(wishes).at("clip");
  plan.scene.clip = choose_clip(wishes.clip, clip);
  for (const std::string& note : clip_notes(plan, clip)) plan.notes.push_back(note);
  plan.annotations = wishes.annotations;
  if (plan.annotations.color_bar && !shows_values(plan))
    at_place(root(wishes).at("annotations").at("colorbar"), [&] {
      throw Error(Trouble::usage,
                  concat(wishes.document.empty() ? "--colorbar: " : "",
                         "no layer shows values by colours; expected one of a projection, or coloured by a field"));
    });
  return plan;
}

ScenePlan plan_layers(const SceneWishes& wishes) {
  return plan_layers(wishes, [](const DataWish& data) { return load_shown(data.file, data.field); });
}

Box3 shown_box(const ScenePlan& plan) {
  Box3 shown, data;
  for (const render::Layer& layer : plan.scene.layers) {
    const render::Volume& volume = plan.volumes[layer.volume];
    data.extendBy(volume.bounds());
    const Box3 whole =
        layer.mode == render::Mode::isosurface ? volume.isosurface_bounds(layer.isovalue) : bounds_of(layer, plan);
    shown.extendBy(layer.clipped && plan.scene.clip ? what_is_left(*plan.scene.clip, whole) : whole);
  }
  return shown.isEmpty() ? data : shown;
}

void place_camera(const SceneWishes& wishes, const ShownBox& shown, ScenePlan& plan) {
  const CameraWish& wish = wishes.camera;
  const bool is_document = !wishes.document.empty();
  at_place(root(wishes).at("camera"), [&] {
    render::View view = render::named_view(wish.view.value_or("iso"));
    view.azimuth_deg = wish.azimuth_deg.value_or(view.azimuth_deg);
    view.elevation_deg = wish.elevation_deg.value_or(view.elevation_deg);
    view.zoom =
        wish.zoom.value_or(wishes.annotations.box.value_or(false) && !wish.position ? zoom_with_box : view.zoom);
    view.vertical_fov_deg = wish.fov_deg.value_or(view.vertical_fov_deg);
    view.orthographic = wish.orthographic_height ? true : wish.orthographic.value_or(false);

    const double aspect = static_cast<double>(plan.frame.width) / plan.frame.height;
    const bool is_given = wish.position && wish.target && wish.up && (!view.orthographic || wish.orthographic_height);
    render::Camera& camera = plan.scene.camera;
    camera = render::fit_camera(is_given ? plan.volumes[0].bounds() : shown(), view, aspect);
    camera.position = wish.position.value_or(camera.position);
    camera.target = wish.target.value_or(camera.target);
    camera.up = wish.up.value_or(camera.up);
    camera.orthographic_height = wish.orthographic_height.value_or(camera.orthographic_height);
    const Vec3 forward = camera.target - camera.position;
    if (!(forward.cross(camera.up).length() > 0))
      throw Error(Trouble::usage, "the camera has no direction: position, target and up lie on one line",
                  is_document ? "give another \"up\" or \"target\"" : "give another --camera-up or --camera-target");
  });
}

namespace {

void place_lights(const SceneWishes& wishes, const ShownBox& shown, ScenePlan& plan) {
  render::Scene& scene = plan.scene;
  scene.lights = choose_lights(wishes, scene.camera);
  scene.occlusion = choose_occlusion(wishes.effects.occlusion, shown);
  scene.fog = choose_fog(wishes.effects.fog, scene.camera, scene.background, shown);
  for (const std::string& note : light_notes(scene, plan.volumes)) plan.notes.push_back(note);
}

/// Rays of an eye inside data start on the side that the field has there.
void note_camera_inside(ScenePlan& plan) {
  if (plan.scene.camera.orthographic) return;
  for (std::size_t v = 0; v < plan.volumes.size(); ++v)
    if (plan.volumes[v].bounds().intersects(plan.scene.camera.position))
      plan.notes.push_back(concat("the camera stands inside ", plan.data[v].file.string(), ": rays begin in it"));
}

}  // namespace

void aim_camera(const SceneWishes& wishes, ScenePlan& plan) {
  std::optional<Box3> box;
  const ShownBox shown = [&] {
    if (!box) box = shown_box(plan);
    return *box;
  };
  aim_camera(wishes, shown, plan);
}

void aim_camera(const SceneWishes& wishes, const ShownBox& shown, ScenePlan& plan) {
  place_camera(wishes, shown, plan);
  place_lights(wishes, shown, plan);
  note_camera_inside(plan);
  if (plan.annotations.box.value_or(false)) plan.annotated_box = shown();
}

}  // namespace rhoray::tools

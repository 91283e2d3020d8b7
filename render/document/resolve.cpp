#include "render/document/resolve.h"

#include <algorithm>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/regular_file.h"
#include "formats/base/word_list.h"
#include "formats/color_grid.h"
#include "render/document/clip.h"
#include "render/document/lights.h"
#include "render/document/material.h"
#include "render/document/several_surfaces.h"
#include "render/document/slices.h"
#include "render/document/styles.h"
#include "render/document/tables.h"
#include "render/document/values.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_words.h"

namespace rhoray::render {

namespace {

/// Of the boundary around isosurfaces: a neutral grey.
constexpr Vec3 context_color{0.5, 0.5, 0.5};

Place layer_place(const SceneSpec& scene_spec, std::size_t layer) {
  return root(scene_spec).at("layers").at(layer);
}

/// The data that a layer names.
/// @param key  of the layer, where the name stands
const DataSpec& data_named(const SceneSpec& scene_spec, const std::string& name, const Place& key) {
  const std::vector<std::string> names = names_in(scene_spec.data, &DataSpec::name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(ErrorCode::invalid,
                concat(key.text(), ": found \"", name, "\"; expected ", names.size() == 1 ? "" : "one of ",
                       joined(names, ", ", "\"")),
                did_you_mean(name, names));
  return scene_spec.data[static_cast<std::size_t>(found - names.begin())];
}

const DataSpec& data_of(const SceneSpec& scene_spec, std::size_t index) {
  const LayerSpec& layer = scene_spec.layers[index];
  const std::vector<std::string> names = names_in(scene_spec.data, &DataSpec::name);
  if (layer.data.empty() && scene_spec.data.size() == 1) return scene_spec.data[0];
  if (layer.data.empty())
    throw Error(ErrorCode::invalid, concat(layer_place(scene_spec, index).text(), ": has no \"data\"; expected one of ",
                                           joined(names, ", ", "\"")));
  return data_named(scene_spec, layer.data, layer_place(scene_spec, index).at("data"));
}

/// The index of the dataset, opened when it is first asked for.
std::size_t dataset_of(const SceneSpec& scene_spec, const DataSpec& data, const OpenData& open, ResolvedScene& plan) {
  const std::vector<std::string> names = names_in(plan.data, &DataSpec::name);
  const auto found = std::find(names.begin(), names.end(), data.name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const Place place = root(scene_spec).at("data").at(data.name).at(data.field.empty() ? "file" : "field");
  plan.datasets.push_back(at_place(place, [&] { return open(data, plan.space); }));
  const Dataset& dataset = plan.datasets.back();
  plan.data.push_back(data);
  if (!data.label) plan.data.back().field = dataset.field().name;
  for (const std::string& note : dataset.notes()) plan.notes.push_back(note);
  if (!dataset.is_surface() && data.field.empty() && dataset.field().name != dataset.field_names().front())
    plan.notes.push_back(
        concat("field '", dataset.field_names().front(), "' is constant; showing field '", dataset.field().name, "'"));
  return plan.datasets.size() - 1;
}

/// Opens a packed file of colours; refuses others and names the command that packs colours
/// (ErrorCode::invalid).
Texture load_texture(const std::filesystem::path& path, formats::Space world) {
  require_readable(path);
  const auto refuse = [&](const std::string& found) {
    throw Error(ErrorCode::invalid, concat(path.string(), ": ", found, "; expected a packed file of colours"),
                "rhoray pack --color makes one from a folder of pictures, .nrrd, .mha or .vti");
  };
  if (!formats::PackedFile::looks_packed(path)) refuse("is not a packed file");
  const formats::PackedFile file = formats::PackedFile::open(path);
  const std::string& kind = file.description().kind;
  if (kind != formats::ColorGrid::kind) refuse(concat("holds a ", kind == "tets" ? "mesh" : kind));
  return Texture::load(file, world);
}

/// The texture of a layer that names one, opened when it is first asked for.
std::optional<Texture> texture_of(const SceneSpec& scene_spec, std::size_t index, ResolvedScene& plan) {
  const LayerSpec& layer = scene_spec.layers[index];
  if (layer.texture.empty()) return std::nullopt;
  const Place key = layer_place(scene_spec, index).at("texture");
  const DataSpec& data = data_named(scene_spec, layer.texture, key);
  at_place(key, [&] {
    const std::string option = scene_spec.document.empty() ? "--texture: " : "";
    if (!layer.color_by.empty())
      throw Error(ErrorCode::usage, concat(option, scene_spec.document.empty() ? "--color-by" : "\"color_by\"",
                                           " is also given; expected only one of the two"));
    if (!data.field.empty())
      throw Error(ErrorCode::usage,
                  concat(data.file.string(), ": field '", data.field, "': a file of colours has no fields"));
  });
  const std::vector<std::string> names = names_in(plan.texture_data, &DataSpec::name);
  const auto found = std::find(names.begin(), names.end(), data.name);
  if (found != names.end()) return plan.textures[static_cast<std::size_t>(found - names.begin())];
  plan.textures.push_back(at_place(key, [&] { return load_texture(data.file, plan.space); }));
  plan.texture_data.push_back(data);
  return plan.textures.back();
}

/// Notes textures that do not overlap the surface they should cover.
void note_textures_elsewhere(ResolvedScene& plan) {
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const Layer& layer = plan.scene.layers[i];
    if (!layer.material.texture) continue;
    const Dataset& dataset = plan.datasets[layer.dataset];
    const Texture& texture = *layer.material.texture;
    if (texture.contains(dataset.bounds())) continue;
    const bool is_near =
        texture.may_overlap(dataset.bounds()) &&
        (layer.mode == Mode::triangles || texture.may_overlap(dataset.isosurface_bounds(layer.isovalue)));
    if (!is_near)
      plan.notes.push_back(concat("texture ", texture.file().name(), " does not overlap layer ", i,
                                  "; check spacing and origin of both files"));
  }
}

bool is_level_of_triangles(const std::string& accuracy) {
  return accuracy == "float" || accuracy == "double";
}

/// The requested level, of the layer or the scene. A scene's level that does not exist for
/// triangles is ignored for them.
std::string accuracy_of(const SceneSpec& scene_spec, const LayerSpec& layer) {
  if (!layer.accuracy.empty()) return layer.accuracy;
  // On a command line a boundary is the layer that the level was asked for.
  const bool is_of_triangles =
      layer.type == LayerType::triangles || (layer.type == LayerType::boundary && !scene_spec.document.empty());
  return !is_of_triangles || is_level_of_triangles(scene_spec.accuracy) ? scene_spec.accuracy : "";
}

/// What a layer shows whose type is chosen by the kind of data. Triangles are not traced by the
/// methods of isosurfaces.
LayerType type_of(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset) {
  if (layer.type != LayerType::automatic) return layer.type;
  const std::string accuracy = accuracy_of(scene_spec, layer);
  const bool asks_for_isosurface = layer.isovalues != LayerSpec{}.isovalues || !layer.method.empty() ||
                                   layer.context.value_or(0) > 0 ||
                                   (!accuracy.empty() && !is_level_of_triangles(accuracy));
  return dataset.is_mesh() && !asks_for_isosurface ? LayerType::boundary : LayerType::isosurface;
}

Method choose_method(const SceneSpec& scene_spec, std::size_t index, Mode mode, const Dataset& dataset) {
  const LayerSpec& layer = scene_spec.layers[index];
  const Place place = layer_place(scene_spec, index).at("method");
  if (!layer.method.empty() && !layer.accuracy.empty())
    throw Error(ErrorCode::invalid, concat(place.text(), ": \"accuracy\" is also given; expected only one of the two"));
  if (!layer.method.empty())
    return at_place(Place{scene_spec.document, {}}, [&] {
      return scene_spec.document.empty() ? method_named(layer.method, mode, dataset.is_mesh())
                                         : method_named(layer.method, mode, dataset.is_mesh(), place.pointer);
    });
  const std::string accuracy = accuracy_of(scene_spec, layer);
  return accuracy.empty() ? default_method(dataset, mode) : method_of(accuracy_named(accuracy));
}

/// Refuses levels that do not exist for triangles.
void require_level_of_triangles(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset) {
  const std::string accuracy = accuracy_of(scene_spec, layer);
  if (!accuracy.empty() && !is_level_of_triangles(accuracy))
    throw Error(ErrorCode::usage, concat("--accuracy: found '", accuracy, "'; expected float or double for ",
                                         dataset.has_fields() ? "the boundary of " : "", dataset.file().name(),
                                         dataset.has_fields() ? "" : ", which holds triangles"));
}

/// Refuses keys about fields if the layer's data are triangles.
void refuse_words_of_fields(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset) {
  for (const auto& [given, option] : {std::pair{layer.isovalues != LayerSpec{}.isovalues, "--iso"},
                                      {layer.type == LayerType::mip, "--mode"},
                                      {layer.type == LayerType::boundary, "--mode"},
                                      {layer.type == LayerType::slice, "--slice"},
                                      {!layer.color_by.empty(), "--color-by"},
                                      {!layer.colormap.empty(), "--colormap"},
                                      {layer.range.has_value(), "--range"},
                                      {!layer.scale.empty(), "--color-scale"},
                                      {layer.levels.has_value(), "--levels"},
                                      {!layer.method.empty(), "--method"}})
    if (given)
      throw Error(ErrorCode::usage,
                  concat(option, ": needs a field, and ", dataset.file().name(), " holds only triangles"));
  require_level_of_triangles(scene_spec, layer, dataset);
}

/// Refuses keys about isosurfaces if the layer is a boundary.
void refuse_words_of_isosurfaces(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& boundary) {
  for (const auto& [given, option] : {std::pair{layer.isovalues != LayerSpec{}.isovalues, "--iso"},
                                      {!layer.method.empty(), "--method"},
                                      {layer.context.value_or(0) > 0, "--context"}})
    if (given)
      throw Error(ErrorCode::usage, concat(option, ": needs an isosurface; a boundary has none"),
                  "leave it out, or use --mode iso");
  require_level_of_triangles(scene_spec, layer, boundary);
}

/// From the 1st to the 99.9th percentile: the few values beyond, such as those of metal in a CT, would
/// leave little of the scale to all others.
Interval<double> projected_window(const formats::FieldSummary& field) {
  const Interval<double> window{formats::percentile(field, 0.01), formats::percentile(field, 0.999)};
  return window.lo < window.hi ? window : field.range;
}

/// Notes files that do not say in which space they are beside files that do.
void note_unknown_spaces(ResolvedScene& plan) {
  const auto is_known = [](const Dataset& dataset) { return dataset.space() != formats::Space::unknown; };
  if (std::none_of(plan.datasets.begin(), plan.datasets.end(), is_known)) return;
  for (const Dataset& dataset : plan.datasets)
    if (!is_known(dataset))
      plan.notes.push_back(concat(dataset.file().name(),
                                  " does not say in which space it lies (RAS or LPS); it may lie "
                                  "elsewhere than the other files"));
}

/// Whether colours of the picture represent values: of a field, a projection or a heat map.
bool shows_values(const ResolvedScene& plan) {
  return plan.page || std::any_of(plan.scene.layers.begin(), plan.scene.layers.end(), [](const Layer& layer) {
           return layer.mode == Mode::mip || layer.material.color_by;
         });
}

bool has_own_color(const Layer& layer) {
  return layer.mode == Mode::isosurface && !layer.material.color_by && !layer.material.texture;
}

/// Annotations as requested, and where nothing is said those that the layers need. Refuses those that
/// have nothing to show.
void plan_annotations(const SceneSpec& scene_spec, ResolvedScene& plan) {
  const AnnotationsSpec needed = std::exchange(plan.annotations, scene_spec.annotations);
  const std::vector<Layer>& layers = plan.scene.layers;
  const auto refuse = [&](const char* key, const std::string& fact) {
    at_place(root(scene_spec).at("annotations").at(key), [&] {
      throw Error(ErrorCode::usage, scene_spec.document.empty() ? concat("--", key, ": ", fact) : fact);
    });
  };
  if (plan.annotations.color_bar && !shows_values(plan)) refuse("colorbar", "nothing here is coloured by a field");
  const bool can_have_legend = !plan.page && std::any_of(layers.begin(), layers.end(), has_own_color);
  if (plan.annotations.legend.value_or(false) && !can_have_legend)
    refuse("legend", "no isosurface here has a colour of its own");
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

/// Adds the layers of a planned scene one after another.
class LayerPlanner {
 public:
  LayerPlanner(const SceneSpec& scene_spec, const OpenData& open) : scene_spec_(scene_spec), open_(open) {
    if (scene_spec.space == "lps") plan_.space = formats::Space::lps;
  }

  ResolvedScene plan() {
    for (std::size_t index = 0; index < scene_spec_.layers.size(); ++index)
      if (scene_spec_.layers[index].visible) add(index);
    require_layers();
    note_invisible_surfaces();
    color_several_surfaces();
    show_several_isovalues();
    explain_labels();
    note_textures_elsewhere(plan_);
    note_unknown_spaces(plan_);
    return std::move(plan_);
  }

 private:
  struct Outside {
    std::size_t spec, isovalue, dataset;
  };

  void add(std::size_t index) {
    const LayerSpec& spec = scene_spec_.layers[index];
    Layer layer;
    layer.dataset = dataset_of(scene_spec_, data_of(scene_spec_, index), open_, plan_);
    layer.clipped = spec.clip.value_or(true);
    const Dataset& dataset = plan_.datasets[layer.dataset];
    require_context(index, dataset);
    if (dataset.is_surface()) return add_triangles(index, layer);
    const LayerType type = type_of(scene_spec_, spec, dataset);
    if (type == LayerType::triangles) refuse_fields(index, dataset);
    if (type == LayerType::boundary) return add_boundary(index, layer);
    if (type == LayerType::slice) {
      choose_slice(spec, dataset, layer_place(scene_spec_, index), layer);
      return put(index, layer, {});
    }
    layer.mode = type == LayerType::mip ? Mode::mip : Mode::isosurface;
    layer.method = choose_method(scene_spec_, index, layer.mode, dataset);
    if (type == LayerType::mip) return add_projection(index, layer);
    layer.material = choose_material(spec, style_named(scene_spec_.style), dataset, layer_place(scene_spec_, index));
    layer.material.texture = texture_of(scene_spec_, index, plan_);
    const std::size_t mesh = layer.dataset;
    add_isosurfaces(index, layer);
    add_context(index, mesh);
  }

  /// Refuses data that should be triangles and are not.
  [[noreturn]] void refuse_fields(std::size_t index, const Dataset& dataset) const {
    const std::string fact = concat(dataset.file().name(), ": is a ", dataset.is_mesh() ? "mesh of tetrahedra" : "grid",
                                    "; expected a packed surface of triangles");
    throw Error(ErrorCode::invalid,
                scene_spec_.document.empty() ? concat("--landmark: ", fact)
                                             : concat(layer_place(scene_spec_, index).at("data").text(), ": ", fact),
                "show its isosurfaces with a layer of type \"isosurface\"");
  }

  void add_triangles(std::size_t index, Layer layer) {
    const LayerSpec& spec = scene_spec_.layers[index];
    const Dataset& dataset = plan_.datasets[layer.dataset];
    at_place(layer_place(scene_spec_, index), [&] { refuse_words_of_fields(scene_spec_, spec, dataset); });
    layer.mode = Mode::triangles;
    layer.method = choose_method(scene_spec_, index, layer.mode, dataset);
    layer.material = choose_material(spec, style_named(scene_spec_.style), dataset, layer_place(scene_spec_, index));
    layer.material.texture = texture_of(scene_spec_, index, plan_);
    put(index, layer, {});
  }

  /// The index of the boundary of a mesh, made when it is first asked for. It stands behind the mesh
  /// and has the same data.
  std::size_t boundary_of(std::size_t mesh) {
    for (std::size_t i = mesh + 1; i < plan_.datasets.size(); ++i)
      if (plan_.datasets[i].is_surface() && plan_.data[i].name == plan_.data[mesh].name) return i;
    plan_.datasets.push_back(plan_.datasets[mesh].boundary());
    plan_.data.push_back(DataSpec(plan_.data[mesh]));
    return plan_.datasets.size() - 1;
  }

  /// Refuses a grid that should be a mesh.
  [[noreturn]] void refuse_grid(std::size_t index, const Dataset& grid) const {
    const std::string fact = concat(grid.file().name(), " is a grid, which has no boundary; expected a mesh");
    if (scene_spec_.document.empty()) throw Error(ErrorCode::usage, concat("--mode boundary: ", fact));
    throw Error(ErrorCode::invalid, concat(layer_place(scene_spec_, index).at("data").text(), ": ", fact));
  }

  void add_boundary(std::size_t index, Layer layer) {
    const LayerSpec& spec = scene_spec_.layers[index];
    const Place place = layer_place(scene_spec_, index);
    if (!plan_.datasets[layer.dataset].is_mesh()) refuse_grid(index, plan_.datasets[layer.dataset]);
    layer.dataset = boundary_of(layer.dataset);
    const Dataset& dataset = plan_.datasets[layer.dataset];
    at_place(place, [&] { refuse_words_of_isosurfaces(scene_spec_, spec, dataset); });
    layer.mode = Mode::triangles;
    layer.method = choose_method(scene_spec_, index, layer.mode, dataset);
    layer.material = choose_boundary_material(spec, style_named(scene_spec_.style), dataset, place);
    layer.material.texture = texture_of(scene_spec_, index, plan_);
    put(index, layer, {});
    if (spec.type != LayerType::automatic || !layer.material.color_by) return;
    plan_.annotations.color_bar = ColorBarSpec{};
    plan_.annotations.box = true;
  }

  /// Refuses a context of data that have no boundary.
  void require_context(std::size_t index, const Dataset& dataset) const {
    if (!(scene_spec_.layers[index].context.value_or(0) > 0) || dataset.is_mesh()) return;
    throw Error(ErrorCode::usage, concat("--context: needs a mesh, and ", dataset.file().name(), " is a ",
                                         dataset.is_surface() ? "surface" : "grid"));
  }

  /// The boundary of a mesh around its isosurfaces, where it is asked for or the type was chosen.
  void add_context(std::size_t index, std::size_t mesh) {
    constexpr double default_opacity = 0.12;
    const LayerSpec& spec = scene_spec_.layers[index];
    const std::string accuracy = accuracy_of(scene_spec_, spec);
    // A method or a level of isosurfaces is asked for to be examined: nothing is added then.
    const bool is_default = spec.type == LayerType::automatic && plan_.datasets[mesh].is_mesh() &&
                            spec.isovalues != LayerSpec{}.isovalues && spec.method.empty() &&
                            (accuracy.empty() || is_level_of_triangles(accuracy));
    const double opacity = spec.context.value_or(is_default ? default_opacity : 0);
    const bool has_isosurface = !plan_.origins.empty() && plan_.origins.back().spec == index;
    if (!(opacity > 0) || !has_isosurface) return;
    Layer layer{.dataset = boundary_of(mesh), .mode = Mode::triangles};
    layer.clipped = spec.clip.value_or(true);
    const Dataset& dataset = plan_.datasets[layer.dataset];
    layer.method = default_method(dataset, layer.mode);
    LayerSpec plain;
    plain.color = Color{context_color};
    plain.opacity = opacity;
    plain.specular = 0;
    layer.material = choose_material(plain, style_named(scene_spec_.style), dataset, layer_place(scene_spec_, index));
    put(index, layer, {});
    plan_.origins.back().is_context = true;
  }

  void add_isosurfaces(std::size_t index, const Layer& layer) {
    const std::vector<std::string>& isovalues = scene_spec_.layers[index].isovalues;
    const Dataset& dataset = plan_.datasets[layer.dataset];
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
      if (is_outside(isovalues[i], dataset.field())) {
        outside_.push_back({index, i, layer.dataset});
        continue;
      }
      const Isovalue isovalue = chosen(index, i, dataset);
      put(index, layer, isovalue.from);
      plan_.scene.layers.back().isovalue = isovalue.value;
    }
  }

  void add_projection(std::size_t index, const Layer& layer) {
    const formats::FieldSummary& field = plan_.datasets[layer.dataset].field();
    at_place(layer_place(scene_spec_, index), [&] {
      if (field.range.is_empty())
        throw Error(ErrorCode::invalid, concat("field '", field.name, "' holds no finite value"));
    });
    put(index, layer, {});
    const LayerSpec& spec = scene_spec_.layers[index];
    Layer& projection = plan_.scene.layers.back();
    for (const NamedColorMap& named : color_maps())
      if (spec.colormap == named.name) projection.map = named.map;
    projection.scale = color_scale(spec);
    projection.window = color_range(spec, field, projected_window(field), layer_place(scene_spec_, index));
  }

  void put(std::size_t index, const Layer& layer, const std::string& isovalue_from) {
    if (plan_.origins.empty()) plan_.scene.layers.clear();
    plan_.scene.layers.push_back(layer);
    plan_.origins.push_back({index, isovalue_from});
    if (plan_.origins.size() > most_layers)
      at_place(root(scene_spec_).at("layers"),
               [] { throw Error(ErrorCode::usage, concat("more than ", most_layers, " layers and isovalues")); });
  }

  Place isovalue_place(std::size_t index, std::size_t i) const {
    const Place place = layer_place(scene_spec_, index).at("isovalue");
    return scene_spec_.layers[index].isovalues.size() == 1 ? place : place.at(i);
  }

  Isovalue chosen(std::size_t index, std::size_t i, const Dataset& dataset) const {
    const std::string& text = scene_spec_.layers[index].isovalues[i];
    if (text == "auto" && dataset.is_level_set()) return {0, "the surface of the level set"};
    return at_place(isovalue_place(index, i), [&] { return choose_isovalue(text, dataset.field()); });
  }

  /// Isovalues outside the range are left out, unless nothing else is shown.
  void require_layers() {
    if (plan_.origins.empty() && !outside_.empty())
      chosen(outside_[0].spec, outside_[0].isovalue, plan_.datasets[outside_[0].dataset]);
    if (plan_.origins.empty())
      throw Error(ErrorCode::invalid,
                  concat(root(scene_spec_).at("layers").text(), ": no layer is visible; expected at least one"));
    for (const Outside& one : outside_) try {
        chosen(one.spec, one.isovalue, plan_.datasets[one.dataset]);
      } catch (const Error& refusal) {
        plan_.notes.push_back(concat(refusal.what(), "; the layer is left out"));
      }
  }

  void note_invisible_surfaces() {
    for (std::size_t i = 0; i < plan_.scene.layers.size(); ++i) {
      const Layer& layer = plan_.scene.layers[i];
      if (layer.mode == Mode::mip || layer.material.opacity > 0) continue;
      const Place place = layer_place(scene_spec_, plan_.origins[i].spec).at("opacity");
      plan_.notes.push_back(
          concat(scene_spec_.document.empty() ? "--opacity" : place.text(), " is 0; the surface is not traced"));
    }
  }

  void color_several_surfaces() {
    std::vector<std::size_t> surfaces;
    for (std::size_t i = 0; i < plan_.scene.layers.size(); ++i)
      if (plan_.scene.layers[i].mode != Mode::mip && plan_.scene.layers[i].mode != Mode::slice &&
          !plan_.origins[i].is_context)
        surfaces.push_back(i);
    if (surfaces.size() < 2) return;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if (scene_spec_.layers[plan_.origins[surfaces[i]].spec].color) continue;
      plan_.scene.layers[surfaces[i]].material.color = color_of_surface(i, surfaces.size());
    }
  }

  /// Colours of labels mean something only with a legend.
  void explain_labels() {
    for (const Layer& layer : plan_.scene.layers)
      if (plan_.data[layer.dataset].label) plan_.annotations.legend = true;
  }

  void show_several_isovalues() {
    for (std::size_t index = 0; index < scene_spec_.layers.size(); ++index) {
      if (scene_spec_.layers[index].isovalues.size() < 2) continue;
      std::vector<Layer*> surfaces;
      for (std::size_t i = 0; i < plan_.origins.size(); ++i)
        if (plan_.origins[i].spec == index && plan_.scene.layers[i].mode == Mode::isosurface)
          surfaces.push_back(&plan_.scene.layers[i]);
      if (surfaces.empty()) continue;
      show_several(scene_spec_.layers[index], plan_.datasets[surfaces[0]->dataset], surfaces);
      if (are_colored_by_isovalue(scene_spec_.layers[index], surfaces.size())) plan_.annotations.legend = true;
    }
  }

  const SceneSpec& scene_spec_;
  const OpenData& open_;
  ResolvedScene plan_;
  std::vector<Outside> outside_;
};

/// Size, channels and background.
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

}  // namespace

ResolvedScene resolve_layers(const SceneSpec& scene_spec, const OpenData& open) {
  ResolvedScene plan = LayerPlanner(scene_spec, open).plan();
  plan_image(scene_spec, plan);
  const Place clip = root(scene_spec).at("clip");
  plan.scene.clip = choose_clip(scene_spec.clip, clip);
  for (const std::string& note : clip_notes(plan, clip)) plan.notes.push_back(note);
  plan_annotations(scene_spec, plan);
  return plan;
}

}  // namespace rhoray::render

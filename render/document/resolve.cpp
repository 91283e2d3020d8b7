#include "render/document/resolve.h"

#include <algorithm>
#include <set>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "render/document/clip.h"
#include "render/document/feature_edges.h"
#include "render/document/layer_data.h"
#include "render/document/layer_type.h"
#include "render/document/material.h"
#include "render/document/picture_plan.h"
#include "render/document/several_surfaces.h"
#include "render/document/slices.h"
#include "render/document/styles.h"
#include "render/document/values.h"
#include "render/isovalue.h"

namespace rhoray::render {

namespace {

/// The colour of a boundary around isosurfaces: a neutral grey.
constexpr Vec3 context_color{0.5, 0.5, 0.5};

/// From the 1st to the 99.9th percentile: the few values beyond, such as those of metal in a CT,
/// would leave little of the scale to all others.
Interval<double> projected_window(const formats::FieldSummary& field) {
  const Interval<double> window{formats::percentile(field, 0.01), formats::percentile(field, 0.999)};
  return window.lo < window.hi ? window : field.range;
}

/// Adds the layers of a planned scene one after another.
class LayerPlanner {
 public:
  LayerPlanner(const SceneSpec& scene_spec, const OpenData& open, const OpenColors& open_colors, const Watch& watch)
      : scene_spec_(scene_spec), open_(open), open_colors_(open_colors), watch_(watch) {
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
    layer.dataset = dataset_of(scene_spec_, index, open_, plan_);
    layer.clipped = spec.clip.value_or(true);
    const Dataset& dataset = plan_.datasets[layer.dataset];
    require_context(index, dataset);
    if (dataset.is_surface()) return add_triangles(index, layer);
    const LayerType type = type_of(scene_spec_, spec, dataset);
    if (type == LayerType::triangles) refuse_fields(index, dataset);
    if (type == LayerType::boundary) return add_boundary(index, layer);
    if (dataset.is_mesh() && plan_.data[layer.dataset].label) refuse_label(index, dataset);
    if (spec.feature_edges)
      throw Error(ErrorCode::usage,
                  concat(given_as(scene_spec_, "--feature-edges", "feature_edges"),
                         ": needs triangles or the boundary of a mesh"),
                  !dataset.is_mesh()             ? ""
                  : scene_spec_.document.empty() ? "leave it out, or add --mode boundary"
                                                 : "leave it out, or use type \"boundary\"");
    if (type == LayerType::slice) {
      choose_slice(spec, dataset, layer_place(scene_spec_, index), layer);
      return put(index, layer, {});
    }
    layer.mode = type == LayerType::mip ? Mode::mip : Mode::isosurface;
    layer.method = choose_method(scene_spec_, index, layer.mode, dataset);
    if (type == LayerType::mip) return add_projection(index, layer);
    layer.material = choose_material(spec, style_named(scene_spec_.style), dataset, layer_place(scene_spec_, index));
    layer.material.texture = texture_of(scene_spec_, index, open_colors_, plan_);
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
    layer.material.texture = texture_of(scene_spec_, index, open_colors_, plan_);
    put(index, layer, {});
  }

  /// Refuses to show a label of a mesh by anything but its boundary.
  [[noreturn]] void refuse_label(std::size_t index, const Dataset& mesh) const {
    const std::string fact = concat(mesh.file().name(), ": a label of a mesh has a boundary only");
    throw Error(ErrorCode::invalid, concat(layer_place(scene_spec_, index).at("type").text(), ": ", fact),
                "show it with a layer of type \"boundary\"");
  }

  /// Returns the index of a mesh's boundary among the datasets. Adds it, behind the mesh and with
  /// the same data, if it is not there yet.
  std::size_t boundary_of(std::size_t mesh) {
    for (std::size_t i = mesh + 1; i < plan_.datasets.size(); ++i)
      if (plan_.datasets[i].is_surface() && plan_.data[i].name == plan_.data[mesh].name) return i;
    plan_.datasets.push_back(plan_.datasets[mesh].boundary(watch_));
    plan_.data.push_back(DataSpec(plan_.data[mesh]));
    return plan_.datasets.size() - 1;
  }

  /// The labels whose surfaces show the faces that they share with a layer's label: a transparent
  /// layer leaves these to a more opaque one, or of equal ones to the first.
  std::vector<int> labels_instead(std::size_t index) const {
    std::vector<int> labels;
    const LayerSpec& own = scene_spec_.layers[index];
    const DataSpec& data = data_of(scene_spec_, index);
    const double opacity = own.opacity.value_or(1);
    if (opacity >= 1) return labels;
    for (std::size_t i = 0; i < scene_spec_.layers.size(); ++i) {
      const LayerSpec& layer = scene_spec_.layers[i];
      const double other_opacity = layer.opacity.value_or(1);
      const bool is_first = other_opacity > opacity || (other_opacity == opacity && i < index);
      if (!is_first || !layer.visible || layer.type != own.type || layer.clip.value_or(true) != own.clip.value_or(true))
        continue;
      const DataSpec& other = data_of(scene_spec_, i);
      if (other.label && other.label != data.label && other.file == data.file && other.field == data.field)
        labels.push_back(*other.label);
    }
    return labels;
  }

  /// Adds the boundary of a mesh's label to the datasets and returns its index.
  std::size_t boundary_of_label(std::size_t index, std::size_t mesh) {
    const DataSpec data = plan_.data[mesh];
    plan_.datasets.push_back(at_place(root(scene_spec_).at("data").at(data.name).at("label"), [&] {
      return plan_.datasets[mesh].boundary(data.field, *data.label, labels_instead(index), watch_);
    }));
    plan_.data.push_back(data);
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
    layer.dataset =
        plan_.data[layer.dataset].label ? boundary_of_label(index, layer.dataset) : boundary_of(layer.dataset);
    const Dataset& dataset = plan_.datasets[layer.dataset];
    at_place(place, [&] { refuse_words_of_isosurfaces(scene_spec_, spec, dataset); });
    layer.mode = Mode::triangles;
    layer.method = choose_method(scene_spec_, index, layer.mode, dataset);
    const Style& style = style_named(scene_spec_.style);
    layer.material = plan_.data[layer.dataset].label ? choose_material(spec, style, dataset, place)
                                                     : choose_boundary_material(spec, style, dataset, place);
    layer.material.texture = texture_of(scene_spec_, index, open_colors_, plan_);
    put(index, layer, {});
    if (spec.type != LayerType::automatic || !layer.material.color_by) return;
    plan_.annotations.color_bar = ColorBarSpec{};
    plan_.annotations.box = true;
  }

  /// Refuses a context of data that have no boundary.
  void require_context(std::size_t index, const Dataset& dataset) const {
    if (!(scene_spec_.layers[index].context.value_or(0) > 0) || dataset.is_mesh()) return;
    throw Error(ErrorCode::usage, concat(given_as(scene_spec_, "--context", "context"), ": needs a mesh, and ",
                                         dataset.file().name(), " is a ", dataset.is_surface() ? "surface" : "grid"));
  }

  /// Adds the boundary of a mesh around its isosurfaces, if the layer asks for it or is automatic.
  void add_context(std::size_t index, std::size_t mesh) {
    constexpr double default_opacity = 0.12;
    const LayerSpec& spec = scene_spec_.layers[index];
    const std::string accuracy = accuracy_of(scene_spec_, spec);
    // Users who choose a method or an accuracy examine the isosurface: no boundary hides it.
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

  /// An isovalue that equals an earlier one is left out: two surfaces at one place would be blended
  /// twice.
  void add_isosurfaces(std::size_t index, const Layer& layer) {
    const std::vector<std::string>& isovalues = scene_spec_.layers[index].isovalues;
    if (isovalues.size() > most_layers) refuse_many_layers();
    const Dataset& dataset = plan_.datasets[layer.dataset];
    std::set<double> taken;
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
      if (is_outside(isovalues[i], dataset.field())) {
        outside_.push_back({index, i, layer.dataset});
        continue;
      }
      const Isovalue isovalue = chosen(index, i, dataset);
      if (!taken.insert(isovalue.value).second) {
        note_equal_isovalue(index, i, isovalue);
        continue;
      }
      put(index, layer, isovalue);
      plan_.scene.layers.back().isovalue = isovalue.value;
    }
  }

  void note_equal_isovalue(std::size_t index, std::size_t i, const Isovalue& isovalue) {
    const std::string where = scene_spec_.document.empty() ? "--iso" : isovalue_place(index, i).text();
    plan_.notes.push_back(concat(where, ": isovalue ", isovalue.value, " (", isovalue.from,
                                 ") equals an earlier one; the layer is left out"));
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
    if (!spec.range) note_coarse_range(projection.window, field);
  }

  /// Where a few values are far away, nearly all lie in one bin of the histogram.
  void note_coarse_range(const Interval<double>& range, const formats::FieldSummary& field) {
    const double error = formats::percentile_error(field), width = range.hi - range.lo;
    if (!(width > 0 && width < 2 * error) || range == field.range) return;
    plan_.notes.push_back(concat("field '", field.name, "': most values lie in one bin of the histogram; the range ",
                                 rounded_within(width, range.lo), " to ", rounded_within(width, range.hi),
                                 " is known to within ", rounded(error, 2), " only; ",
                                 scene_spec_.document.empty() ? "--range" : "\"range\"", " sets another"));
  }

  void put(std::size_t index, const Layer& layer, const Isovalue& isovalue) {
    if (plan_.origins.empty()) plan_.scene.layers.clear();
    plan_.scene.layers.push_back(layer);
    plan_.origins.push_back({.spec = index,
                             .isovalue_from = isovalue.from,
                             .is_context = false,
                             .isovalue_alternatives = isovalue.alternatives});
    if (plan_.origins.size() > most_layers) refuse_many_layers();
  }

  [[noreturn]] void refuse_many_layers() const {
    const Place place = root(scene_spec_).at("layers");
    throw Error(scene_spec_.document.empty() ? ErrorCode::usage : ErrorCode::invalid,
                concat(scene_spec_.document.empty() ? "" : place.text() + ": ", "more than ", most_layers,
                       " layers and isovalues"));
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

  /// Adds a legend for labels, whose colours mean nothing without it.
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
  const OpenColors& open_colors_;
  const Watch& watch_;
  ResolvedScene plan_;
  std::vector<Outside> outside_;
};

}  // namespace

ResolvedScene resolve_layers(const SceneSpec& scene_spec, const OpenData& open, const OpenColors& open_colors,
                             const Watch& watch) {
  ResolvedScene plan = LayerPlanner(scene_spec, open, open_colors, watch).plan();
  plan_image(scene_spec, plan);
  const Place clip = root(scene_spec).at("clip");
  plan.scene.clip = choose_clip(scene_spec.clip, clip);
  for (const std::string& note : clip_notes(plan, clip)) plan.notes.push_back(note);
  plan_annotations(scene_spec, plan);
  plan_feature_edges(scene_spec, plan);
  return plan;
}

}  // namespace rhoray::render

#include "tools/library/conversions.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "formats/base/nearest_name.h"
#include "formats/base/word_list.h"
#include "render/color_map.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"
#include "tools/library/scene_checks.h"

namespace rhoray::v0_1::inside {

namespace {

template <class... Alternatives>
struct Overloaded : Alternatives... {
  using Alternatives::operator()...;
};
template <class... Alternatives>
Overloaded(Alternatives...) -> Overloaded<Alternatives...>;

/// Adds a scene's datasets, each once.
class Datasets {
 public:
  explicit Datasets(render::ResolvedScene& resolved) : resolved_(resolved) {}

  /// @return  its index
  std::size_t index_of(const Dataset& data, const std::string& field, const rhoray::Watch& watch) {
    const Dataset::Implementation& handle = data.implementation();
    const render::Dataset dataset = handle.of(field, watch);
    const std::string name = dataset.is_surface() ? "" : dataset.field().name;
    for (std::size_t i = 0; i < known_.size(); ++i)
      if (known_[i].id == handle.id() && known_[i].field == name) return i;
    known_.push_back({handle.id(), name});
    resolved_.datasets.push_back(dataset);
    const auto& part = handle.part();
    resolved_.data.push_back({.name = concat("data", known_.size()),
                              .file = dataset.file().name(),
                              .field = part ? part->field : name,
                              .label = part ? std::optional(part->label) : std::nullopt});
    return known_.size() - 1;
  }

 private:
  struct Known {
    std::uint64_t id;
    std::string field;
  };
  render::ResolvedScene& resolved_;
  std::vector<Known> known_;
};

render::ColorMap color_map_named(const std::string& name) {
  std::vector<std::string> names;
  for (const render::NamedColorMap& known : render::color_maps()) {
    if (known.name == name) return known.map;
    names.emplace_back(known.name);
  }
  throw v0_1::Error(v0_1::ErrorCode::usage, concat("colour map '", name, "'; expected ", joined(names)),
                    did_you_mean(name, names));
}

std::string name_of(render::ColorMap map) {
  for (const render::NamedColorMap& known : render::color_maps())
    if (known.map == map) return std::string(known.name);
  return {};
}

render::ColorScale scale_of(const ColorScale& colors) {
  return {.is_logarithmic = colors.is_logarithmic, .levels = colors.levels};
}

ColorScale colors_of(render::ColorMap map, const render::ColorScale& scale, const rhoray::Interval<double>& range) {
  ColorScale colors{.colormap = name_of(map), .is_logarithmic = scale.is_logarithmic, .levels = scale.levels};
  if (!range.is_empty()) colors.range = outside_of(range);
  return colors;
}

render::FieldColors field_colors(const std::string& field, const ColorScale& colors, const render::Dataset& dataset) {
  render::FieldColors out{.field = field, .map = color_map_named(colors.colormap), .scale = scale_of(colors)};
  if (colors.range)
    out.range = inside_of(*colors.range);
  else if (const auto summary = dataset.field(field))
    out.range = summary->range;
  return out;
}

render::HalfSpace converted(const HalfSpace& half) {
  return {.point = inside_of(half.point), .normal = inside_of(half.normal)};
}
HalfSpace converted(const render::HalfSpace& half) {
  return {.point = outside_of(half.point), .normal = outside_of(half.normal)};
}

render::Normals normals_of(const Material& material, const render::Dataset& dataset) {
  if (material.normals) return static_cast<render::Normals>(*material.normals);
  return dataset.is_mesh() ? render::Normals::exact : render::Normals::smooth;
}

render::Material converted(const Material& material, const render::Dataset& dataset) {
  render::Material out{.color = inside_of(material.color),
                       .normals = normals_of(material, dataset),
                       .ambient = material.ambient,
                       .specular = material.specular,
                       .shininess = material.shininess,
                       .opacity = material.opacity};
  if (material.color_by) out.color_by = field_colors(material.color_by->field, material.color_by->colors, dataset);
  if (material.texture) out.texture = material.texture->implementation().of;
  return out;
}

Material converted(const render::Material& material) {
  Material out{.color = outside_of(material.color),
               .normals = static_cast<Normals>(material.normals),
               .ambient = material.ambient,
               .specular = material.specular,
               .shininess = material.shininess,
               .opacity = material.opacity};
  if (const auto& colors = material.color_by)
    out.color_by = FieldColors{.field = colors->field, .colors = colors_of(colors->map, colors->scale, colors->range)};
  if (material.texture) out.texture = Texture(std::make_shared<const Texture::Implementation>(*material.texture));
  return out;
}

void show(const Slice& slice, const render::Dataset& dataset, render::Layer& layer) {
  layer.mode = render::Mode::slice;
  layer.plane = converted(slice.plane);
  render::Material plain;
  plain.specular = 0, plain.opacity = layer.material.opacity;
  layer.material = plain;
  layer.material.color_by = field_colors(dataset.field().name, slice.colors, dataset);
  layer.material.lit = slice.is_lit;
  if (slice.threshold) layer.threshold = inside_of(*slice.threshold);
}

render::Layer converted(const Layer& layer, std::size_t index, const render::Dataset& dataset) {
  render::Layer out{.dataset = index, .material = converted(layer.material, dataset), .clipped = layer.is_clipped};
  std::visit(Overloaded{[&](const Isosurface& surface) { out.isovalue = surface.isovalue; },
                        [&](const MaximumProjection& projection) {
                          out.mode = render::Mode::mip;
                          out.map = color_map_named(projection.colors.colormap);
                          out.scale = scale_of(projection.colors);
                          const auto& range = projection.colors.range;
                          out.window = range ? inside_of(*range) : dataset.field().range;
                        },
                        [&](const Slice& slice) { show(slice, dataset, out); },
                        [&](const Triangles&) { out.mode = render::Mode::triangles; }},
             layer.show);
  out.method = layer.method ? inside_of(*layer.method) : render::default_method(dataset, out.mode);
  return out;
}

Layer converted(const render::Layer& layer, const Dataset& data) {
  Layer out{.data = data,
            .show = Isosurface{layer.isovalue},
            .material = converted(layer.material),
            .is_clipped = layer.clipped};
  if (layer.mode == render::Mode::triangles) out.show = Triangles{};
  if (layer.mode == render::Mode::mip) out.show = MaximumProjection{colors_of(layer.map, layer.scale, layer.window)};
  if (layer.mode == render::Mode::slice) {
    Slice slice{.plane = converted(layer.plane), .is_lit = layer.material.lit};
    if (out.material.color_by) slice.colors = out.material.color_by->colors;
    out.material.color_by.reset();
    if (std::isfinite(layer.threshold.lo) || std::isfinite(layer.threshold.hi))
      slice.threshold = outside_of(layer.threshold);
    out.show = slice;
  }
  out.method = outside_of(layer.method);
  return out;
}

render::Light converted(const Light& light) {
  return {.kind = static_cast<render::Light::Kind>(light.kind),
          .place = light.kind == Light::Kind::head ? rhoray::Vec3(0, 0, 0) : inside_of(light.place),
          .color = inside_of(light.color),
          .casts_shadows = light.casts_shadows,
          .size = light.size,
          .samples = light.samples};
}

Light converted(const render::Light& light) {
  return {.kind = static_cast<Light::Kind>(light.kind),
          .place = outside_of(light.place),
          .color = outside_of(light.color),
          .casts_shadows = light.casts_shadows,
          .size = light.size,
          .samples = light.samples};
}

/// Everything of a scene but its layers and its camera.
void convert_effects(const Scene& scene, render::Scene& out) {
  out.lights.clear();
  for (const Light& light : scene.lights) out.lights.push_back(converted(light));
  out.occlusion = {.samples = scene.occlusion.samples, .radius = scene.occlusion.radius};
  if (scene.fog) out.fog = render::Fog{.color = inside_of(scene.fog->color), .range = inside_of(scene.fog->range)};
  if (scene.clip) {
    out.clip.emplace();
    if (scene.clip->box) out.clip->box = inside_of(*scene.clip->box);
    for (const HalfSpace& plane : scene.clip->planes) out.clip->planes.push_back(converted(plane));
    out.clip->cuts_away = scene.clip->is_inverted;
  }
  out.transparent_background = !scene.background;
  if (scene.background) out.background = inside_of(*scene.background);
}

/// The same channels in the other type.
template <class To, class From>
To channels_of(const From& channels) {
  return {.depth = channels.depth,
          .normal = channels.normal,
          .cell = channels.cell,
          .value = channels.value,
          .error = channels.error,
          .cost = channels.cost};
}

}  // namespace

render::Camera inside_of(const Camera& camera) {
  return {.position = inside_of(camera.position),
          .target = inside_of(camera.target),
          .up = inside_of(camera.up),
          .vertical_fov_deg = camera.vertical_fov_deg,
          .orthographic = camera.orthographic_height.has_value(),
          .orthographic_height = camera.orthographic_height.value_or(1)};
}

Camera outside_of(const render::Camera& camera) {
  Camera out{.position = outside_of(camera.position),
             .target = outside_of(camera.target),
             .up = outside_of(camera.up),
             .vertical_fov_deg = camera.vertical_fov_deg};
  if (camera.orthographic) out.orthographic_height = camera.orthographic_height;
  return out;
}

render::Method inside_of(const Method& method) {
  using Algorithm = render::Method::Algorithm;
  if (const auto accuracy = method.accuracy()) {
    require_enumerator("Accuracy", *accuracy, Accuracy::exact);
    return render::method_of(static_cast<render::Accuracy>(*accuracy));
  }
  if (method.step_cells() > 0)
    return {.algorithm = Algorithm::sampled, .step = method.step_cells(), .bisect = method.bisects()};
  return {.algorithm = Algorithm::paper};
}

Method outside_of(const render::Method& method) {
  for (const Accuracy accuracy :
       {Accuracy::preview, Accuracy::float32, Accuracy::float64, Accuracy::certified, Accuracy::exact})
    if (method == inside_of(accuracy)) return accuracy;
  if (method == inside_of(Method::paper())) return Method::paper();
  if (method.algorithm == render::Method::Algorithm::sampled) return Method::sampled(method.step, method.bisect);
  throw rhoray::Error(rhoray::ErrorCode::unsupported, "a method of the layer is in the program only",
                      "give the layer an accuracy level");
}

render::ChannelSet inside_of(const ChannelSet& channels) {
  return channels_of<render::ChannelSet>(channels);
}

ChannelSet outside_of(const render::ChannelSet& channels) {
  return channels_of<ChannelSet>(channels);
}

render::ResolvedScene resolved(const Scene& scene, const RenderOptions& options, const rhoray::Watch& watch) {
  for (const int side : {options.size.width, options.size.height})
    if (side < 1 || side > longest_side)
      refuse("RenderOptions::size: found ", options.size.width, " x ", options.size.height,
             " pixels; expected sides from 1 to ", longest_side);
  if (scene.layers.empty()) refuse("Scene::layers: found none; expected at least one");
  check(scene);
  render::ResolvedScene out;
  out.scene.layers.clear();
  Datasets datasets(out);
  for (std::size_t i = 0; i < scene.layers.size(); ++i) {
    const Layer& layer = scene.layers[i];
    try {
      const std::size_t index = datasets.index_of(layer.data, layer.field, watch);
      out.scene.layers.push_back(converted(layer, index, out.datasets[index]));
    } catch (const v0_1::Error& error) {
      throw v0_1::Error(error.code(), concat("layer ", i, ": ", error.what()), error.hint());
    } catch (const rhoray::Error& error) {
      if (error.code() == rhoray::ErrorCode::interrupted) throw;
      throw rhoray::Error(error.code(), concat("layer ", i, ": ", error.what()), error.hint());
    }
  }
  out.origins.resize(out.scene.layers.size());
  convert_effects(scene, out.scene);
  if (scene.camera) out.scene.camera = inside_of(*scene.camera);
  const auto is_lps = [](const render::Dataset& dataset) { return dataset.space() == formats::Space::lps; };
  if (std::any_of(out.datasets.begin(), out.datasets.end(), is_lps)) out.space = formats::Space::lps;
  out.frame = {.width = options.size.width,
               .height = options.size.height,
               .channels = inside_of(options.channels),
               .antialiasing = options.max_samples};
  if (const auto& window = options.window)
    out.frame.window = {.x = window->x, .y = window->y, .width = window->width, .height = window->height};
  return out;
}

render::ResolvedScene resolved_with_camera(const Scene& scene, const RenderOptions& options,
                                           const rhoray::Watch& watch) {
  if (!scene.camera)
    throw v0_1::Error(v0_1::ErrorCode::usage, "Scene::camera: not set",
                      "set it: scene.camera = fit_camera(scene, size)");
  return resolved(scene, options, watch);
}

namespace {

/// A handle of the data that a document names, of their boundary, or of the same file in another
/// space.
Dataset handle_in_scene(const render::Dataset& dataset, const render::DataSpec& spec, const Dataset& opened) {
  const render::Dataset& first = opened.implementation().first();
  if (dataset.is_surface() == first.is_surface() && dataset.space() == first.space()) return opened;
  const bool is_part = spec.label && dataset.is_surface();
  return handle_of(dataset, {.is_in_memory = opened.implementation().is_in_memory(),
                             .part = is_part ? std::optional(MeshPart{spec.field, *spec.label}) : std::nullopt});
}

}  // namespace

Scene outside_of(const render::ResolvedScene& resolved, const OpenedData& opened) {
  const render::Scene& scene = resolved.scene;
  Scene out;
  std::vector<Dataset> handles;
  for (std::size_t i = 0; i < resolved.datasets.size(); ++i)
    handles.push_back(handle_in_scene(resolved.datasets[i], resolved.data[i], opened.at(resolved.data[i].name)));
  for (const render::Layer& layer : scene.layers) {
    out.layers.push_back(converted(layer, handles[layer.dataset]));
    if (!resolved.datasets[layer.dataset].is_surface())
      out.layers.back().field = resolved.datasets[layer.dataset].field().name;
  }
  out.camera = outside_of(scene.camera);
  out.lights.clear();
  for (const render::Light& light : scene.lights) out.lights.push_back(converted(light));
  out.occlusion = {.samples = scene.occlusion.samples, .radius = scene.occlusion.radius};
  if (scene.fog) out.fog = Fog{.color = outside_of(scene.fog->color), .range = outside_of(scene.fog->range)};
  if (scene.clip) {
    out.clip.emplace();
    if (scene.clip->box) out.clip->box = outside_of(*scene.clip->box);
    for (const render::HalfSpace& plane : scene.clip->planes) out.clip->planes.push_back(converted(plane));
    out.clip->is_inverted = scene.clip->cuts_away;
  }
  out.background = outside_of(scene.background);
  if (scene.transparent_background) out.background.reset();
  return out;
}

RenderOptions options_of(const render::ResolvedScene& resolved) {
  return {.size = {resolved.frame.width, resolved.frame.height},
          .channels = outside_of(resolved.frame.channels),
          .max_samples = resolved.frame.antialiasing};
}

Statistics outside_of(const render::FrameStatistics& statistics) {
  return {.rays = statistics.rays,
          .rays_ruled_out = statistics.rays_ruled_out,
          .shadow_rays = statistics.shadow_rays,
          .occlusion_rays = statistics.occlusion_rays,
          .edge_pixels = statistics.edge_pixels,
          .hits = statistics.hits,
          .macrocells_visited = statistics.macrocells_visited,
          .cells_visited = statistics.cells_visited,
          .rays_exact = statistics.rays_exact,
          .largest_error = statistics.largest_error,
          .preparation_s = statistics.preparation_s,
          .range_proof_s = statistics.range_proof.wall_s,
          .wall_s = statistics.wall_s};
}

ProbeHit outside_of(const render::ProbeHit& hit) {
  const auto proven = [](double error) { return std::isnan(error) ? std::nullopt : std::optional(error); };
  return {.layer = hit.layer,
          .depth = hit.depth,
          .position = outside_of(hit.position),
          .error = proven(hit.error),
          .cell = hit.cell,
          .value = hit.value,
          .value_error = proven(hit.value_error),
          .unit = hit.unit};
}

render::Machine inside_of(Machine machine, std::string_view name) {
  for (const render::Machine known : render::all_machines)
    if (static_cast<int>(known) == static_cast<int>(machine)) return known;
  refuse(name, ": found ", static_cast<int>(machine), "; expected scalar, baseline, avx2 or avx512");
}

render::Machine machine_of(const std::optional<Machine>& machine, std::string_view name) {
  if (!machine) return render::best_machine();
  const render::Machine chosen = inside_of(*machine, name);
  if (render::has_machine(chosen)) return chosen;
  throw v0_1::Error(v0_1::ErrorCode::unsupported, concat(name, ": ", name_of(chosen), "; this processor has ",
                                                         name_of(render::best_machine()), " at most"));
}

}  // namespace rhoray::v0_1::inside

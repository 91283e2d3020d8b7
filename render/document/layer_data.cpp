#include "render/document/layer_data.h"

#include <algorithm>
#include <filesystem>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/regular_file.h"
#include "formats/base/word_list.h"
#include "formats/color_grid.h"
#include "render/document/values.h"

namespace rhoray::render {

namespace {

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

/// Opens the texture; refuses data that are no colours (ErrorCode::unsupported).
Texture load_texture(const DataSpec& data, const OpenColors& open_colors, formats::Space world) {
  const formats::PackedFile file = open_colors(data);
  const std::string& kind = file.description().kind;
  if (kind != formats::ColorGrid::kind)
    throw Error(
        ErrorCode::unsupported,
        concat(data.file.string(), ": holds a ", kind == "tets" ? "mesh" : kind, "; expected colours"),
        "a folder of pictures, .nrrd, .mha, .nii, .npy and .vti can hold them; `rhoray pack --color` packs them");
  return Texture::load(file, world);
}

}  // namespace

formats::PackedFile open_packed_colors(const DataSpec& data) {
  require_readable(data.file);
  if (!formats::PackedFile::looks_packed(data.file))
    throw Error(ErrorCode::unsupported, concat(data.file.string(), ": is not a packed file; expected one with colours"),
                "`rhoray pack --color` makes one");
  return formats::PackedFile::open(data.file);
}

std::string given_as(const SceneSpec& scene_spec, std::string_view option, std::string_view key) {
  return scene_spec.document.empty() ? std::string(option) : concat('"', key, '"');
}

Place layer_place(const SceneSpec& scene_spec, std::size_t layer) {
  return root(scene_spec).at("layers").at(layer);
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

std::size_t dataset_of(const SceneSpec& scene_spec, std::size_t layer, const OpenData& open, ResolvedScene& plan) {
  const DataSpec& data = data_of(scene_spec, layer);
  const std::vector<std::string> names = names_in(plan.data, &DataSpec::name);
  const auto found = std::find(names.begin(), names.end(), data.name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const Place place = root(scene_spec).at("data").at(data.name).at(data.field.empty() ? "file" : "field");
  plan.datasets.push_back(at_place(place, [&] { return open(data, plan.space); }));
  const Dataset& dataset = plan.datasets.back();
  plan.data.push_back(data);
  if (!data.label || (dataset.is_mesh() && data.field.empty())) plan.data.back().field = dataset.field().name;
  for (const std::string& note : dataset.notes()) plan.notes.push_back(note);
  if (!dataset.is_surface() && data.field.empty() && dataset.field().name != dataset.field_names().front())
    plan.notes.push_back(
        concat("field '", dataset.field_names().front(), "' is constant; showing field '", dataset.field().name, "'"));
  return plan.datasets.size() - 1;
}

std::optional<Texture> texture_of(const SceneSpec& scene_spec, std::size_t index, const OpenColors& open_colors,
                                  ResolvedScene& plan) {
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
  plan.textures.push_back(at_place(key, [&] { return load_texture(data, open_colors, plan.space); }));
  plan.texture_data.push_back(data);
  return plan.textures.back();
}

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

void note_unknown_spaces(ResolvedScene& plan) {
  const auto is_known = [](const Dataset& dataset) { return dataset.space() != formats::Space::unknown; };
  if (std::none_of(plan.datasets.begin(), plan.datasets.end(), is_known)) return;
  for (const Dataset& dataset : plan.datasets)
    if (!is_known(dataset))
      plan.notes.push_back(concat(dataset.file().name(),
                                  " does not say in which space it lies (RAS or LPS); it may lie "
                                  "elsewhere than the other files"));
}

}  // namespace rhoray::render

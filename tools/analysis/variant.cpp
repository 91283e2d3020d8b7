#include "tools/analysis/variant.h"

#include <algorithm>

#include "formats/base/text.h"
#include "render/method_words.h"
#include "render/scene_spec.h"

namespace rhoray::tools {

namespace {

/// Scenes that a row applies to.
enum Applies : unsigned { grids = 1, meshes = 2, surfaces = 4, projections = 8, all_of_them = 15 };

/// A method on the original data.
struct MethodRow {
  const char* group;
  const char* word;  ///< for --accuracy in the group of levels, else for --method
  unsigned applies;
  bool has_picture = false;
};

constexpr MethodRow method_rows[] = {{group_levels, "preview", grids | surfaces, true},
                                     {group_levels, "float", grids | meshes | surfaces, true},
                                     {group_levels, "double", all_of_them},
                                     {group_levels, "certified", all_of_them},
                                     {group_levels, "exact", all_of_them},
                                     {group_published, "paper:float", grids | meshes | surfaces, true},
                                     {group_published, "paper:double", grids | meshes | surfaces},
                                     {group_published, "slack:1e-12:double", meshes | surfaces},
                                     {group_published, "face:double", grids | meshes | projections, true}};

/// Samples along the ray, by their step in cells. The one of a whole cell may be shown.
struct SampledRow {
  const char *group, *refinement;
  unsigned applies;
  bool has_picture;
};
constexpr SampledRow sampled_rows[] = {{group_linear, "linear", grids | meshes | surfaces, true},
                                       {group_bisect, "bisect", grids | meshes | surfaces, false},
                                       {group_samples, "linear", grids | meshes | projections, true}};
constexpr double steps[] = {2, 1, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625};

/// Other forms of the data, by their size, rendered with their default method.
struct DataRow {
  const char* group;
  DataForm::Kind kind;
  std::vector<int> sizes;
  unsigned applies;
  int shown_size;  ///< the one that is shown; 0: none
};

const std::vector<DataRow>& data_rows() {
  static const std::vector<DataRow> rows{
      {group_bits, DataForm::Kind::quantized, {8, 16}, all_of_them, 8},
      {group_grids, DataForm::Kind::resampled, {32, 64, 128, 256}, meshes | surfaces | projections, 64},
      {group_vdb, DataForm::Kind::resampled_vdb, {32, 64, 128, 256}, meshes | surfaces | projections, 0}};
  return rows;
}

/// An effect, by its number of samples.
struct EffectRow {
  const char* group;
  SampledEffect effect;
  std::vector<int> counts;
  int most;  ///< number that the others are compared with
  const char *one, *several;
};

const std::vector<EffectRow>& effect_rows() {
  static const std::vector<EffectRow> rows{
      {group_occlusion, SampledEffect::occlusion, {1, 4, 16, 64, 256}, 1024, "ray a hit", "rays a hit"},
      {group_shadows, SampledEffect::soft_shadows, {1, 4, 16, 64, 256}, 1024, "ray to a light", "rays to a light"},
      {group_edges,
       SampledEffect::edges,
       {1, 2, 4, 8, 16},
       render::limits::pixel_samples.hi,
       "sample a pixel",
       "samples a pixel"}};
  return rows;
}

constexpr int shrinks[] = {2, 4};

bool applies(unsigned row, bool is_mesh, bool is_projection) {
  return (row & (is_mesh ? meshes : grids)) != 0 && (row & (is_projection ? projections : surfaces)) != 0;
}

bool calls_for(SampledEffect effect, const render::Scene& scene, int antialiasing) {
  const bool is_surface = scene.layers[0].mode == render::Mode::isosurface;
  switch (effect) {
    case SampledEffect::occlusion:
      return is_surface && scene.occlusion.radius > 0;
    case SampledEffect::soft_shadows:
      return is_surface && std::any_of(scene.lights.begin(), scene.lights.end(), is_soft);
    case SampledEffect::edges:
      return antialiasing > 1;
    case SampledEffect::none:
      break;
  }
  return false;
}

}  // namespace

std::string text_of(const DataForm& form) {
  switch (form.kind) {
    case DataForm::Kind::quantized:
      return concat(form.size, " bits");
    case DataForm::Kind::resampled:
      return concat("grid ", form.size);
    case DataForm::Kind::resampled_vdb:
      return concat("OpenVDB ", form.size);
    case DataForm::Kind::original:
      break;
  }
  return "original";
}

int most_samples(SampledEffect effect) {
  for (const EffectRow& row : effect_rows())
    if (row.effect == effect) return row.most;
  return 0;
}

bool is_soft(const render::Light& light) {
  return light.casts_shadows && light.size > 0;
}

std::vector<Variant> variants_of(const render::Scene& scene, const render::Dataset& dataset, int antialiasing) {
  const render::Layer& layer = scene.layers[0];
  const bool is_mesh = dataset.is_mesh(), is_projection = layer.mode == render::Mode::mip;
  std::vector<Variant> all;
  const auto add_method = [&](const char* group, const std::string& word, bool has_picture) {
    all.push_back({.group = group,
                   .name = word,
                   .method = group == group_levels ? render::method_of(render::accuracy_named(word))
                                                   : render::method_named(word, layer.mode, is_mesh),
                   .has_picture = has_picture});
  };
  for (const MethodRow& row : method_rows)
    if (applies(row.applies, is_mesh, is_projection)) add_method(row.group, row.word, row.has_picture);
  for (const SampledRow& row : sampled_rows)
    if (applies(row.applies, is_mesh, is_projection))
      for (const double step : steps)
        add_method(row.group, concat("sampled:", step, "+", row.refinement), row.has_picture && step == 1);
  for (const DataRow& row : data_rows())
    if (applies(row.applies, is_mesh, is_projection))
      for (const int size : row.sizes) {
        const DataForm form{row.kind, size};
        all.push_back({.group = row.group, .name = text_of(form), .data = form, .has_picture = size == row.shown_size});
      }
  if (!is_projection) {
    const bool is_smooth = layer.material.normals == render::Normals::smooth;
    all.push_back({.group = group_normals,
                   .name = !is_smooth ? "smooth normals"
                           : is_mesh  ? "flat normals"
                                      : "exact normals",
                   .normals = is_smooth ? render::Normals::exact : render::Normals::smooth,
                   .has_picture = true});
  }
  for (const EffectRow& row : effect_rows())
    if (calls_for(row.effect, scene, antialiasing))
      for (const int count : row.counts)
        all.push_back({.group = row.group,
                       .name = concat(count, " ", count == 1 ? row.one : row.several),
                       .effect = row.effect,
                       .samples = count,
                       .has_picture = count == row.counts.front()});
  for (const int shrink : shrinks)
    all.push_back(
        {.group = group_size, .name = concat("1/", shrink, " of the size"), .shrink = shrink, .has_picture = true});
  return all;
}

}  // namespace rhoray::tools

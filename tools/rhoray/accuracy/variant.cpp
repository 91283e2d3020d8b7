#include "tools/rhoray/accuracy/variant.h"

#include <algorithm>

#include "formats/base/text.h"
#include "tools/rhoray/method_words.h"

namespace rhoray::tools {

namespace {

/// What a row applies to.
enum Applies : unsigned { grids = 1, meshes = 2, surfaces = 4, projections = 8 };

/// A method on the data as they are.
struct MethodRow {
  const char* group;
  const char* word;  ///< of --accuracy in the group of levels, else of --method
  unsigned applies;
  bool has_picture = false;
};

constexpr MethodRow method_rows[] = {{group_levels, "preview", grids | surfaces, true},
                                     {group_levels, "float", grids | meshes | surfaces, true},
                                     {group_levels, "double", grids | meshes | surfaces | projections},
                                     {group_levels, "certified", grids | meshes | surfaces | projections},
                                     {group_levels, "exact", grids | meshes | surfaces | projections},
                                     {group_published, "paper:float", grids | meshes | surfaces, true},
                                     {group_published, "paper:double", grids | meshes | surfaces},
                                     {group_published, "slack:1e-12:double", meshes | surfaces},
                                     {group_published, "face:double", grids | meshes | projections, true},
                                     {group_linear, "sampled:2+linear", grids | meshes | surfaces},
                                     {group_linear, "sampled:1+linear", grids | meshes | surfaces, true},
                                     {group_linear, "sampled:0.5+linear", grids | meshes | surfaces},
                                     {group_linear, "sampled:0.25+linear", grids | meshes | surfaces},
                                     {group_linear, "sampled:0.125+linear", grids | meshes | surfaces},
                                     {group_linear, "sampled:0.0625+linear", grids | meshes | surfaces},
                                     {group_linear, "sampled:0.03125+linear", grids | meshes | surfaces},
                                     {group_linear, "sampled:0.015625+linear", grids | meshes | surfaces},
                                     {group_bisect, "sampled:2+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:1+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:0.5+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:0.25+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:0.125+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:0.0625+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:0.03125+bisect", grids | meshes | surfaces},
                                     {group_bisect, "sampled:0.015625+bisect", grids | meshes | surfaces},
                                     {group_samples, "sampled:2+linear", grids | meshes | projections},
                                     {group_samples, "sampled:1+linear", grids | meshes | projections, true},
                                     {group_samples, "sampled:0.5+linear", grids | meshes | projections},
                                     {group_samples, "sampled:0.25+linear", grids | meshes | projections},
                                     {group_samples, "sampled:0.125+linear", grids | meshes | projections},
                                     {group_samples, "sampled:0.0625+linear", grids | meshes | projections},
                                     {group_samples, "sampled:0.03125+linear", grids | meshes | projections},
                                     {group_samples, "sampled:0.015625+linear", grids | meshes | projections}};

/// Another form of the data, by the method that is its default.
struct DataRow {
  const char* group;
  DataForm form;
  unsigned applies;
  bool has_picture = false;
};

constexpr DataRow data_rows[] = {{group_bits, {DataForm::Kind::quantized, 8}, grids | surfaces | projections, true},
                                 {group_bits, {DataForm::Kind::quantized, 16}, grids | surfaces | projections},
                                 {group_grids, {DataForm::Kind::resampled, 32}, meshes | surfaces | projections},
                                 {group_grids, {DataForm::Kind::resampled, 64}, meshes | surfaces | projections, true},
                                 {group_grids, {DataForm::Kind::resampled, 128}, meshes | surfaces | projections},
                                 {group_grids, {DataForm::Kind::resampled, 256}, meshes | surfaces | projections},
                                 {group_vdb, {DataForm::Kind::resampled_vdb, 64}, meshes | surfaces | projections},
                                 {group_vdb, {DataForm::Kind::resampled_vdb, 128}, meshes | surfaces | projections}};

constexpr int occlusion_counts[] = {1, 4, 16, 64, 256};
constexpr int shrinks[] = {2, 4};

bool applies(unsigned row, bool is_mesh, bool is_projection) {
  return (row & (is_mesh ? meshes : grids)) != 0 && (row & (is_projection ? projections : surfaces)) != 0;
}

render::Method method_of_row(const MethodRow& row, render::Mode mode, bool is_mesh) {
  if (row.group == group_levels) return render::method_of(accuracy_named(row.word));
  return method_named(row.word, mode, is_mesh);
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

std::vector<Variant> variants_of(const render::Scene& scene, const render::Volume& volume) {
  const render::Layer& layer = scene.layers[0];
  const bool is_mesh = volume.is_mesh(), is_projection = layer.mode == render::Mode::mip;
  std::vector<Variant> all;
  for (const MethodRow& row : method_rows)
    if (applies(row.applies, is_mesh, is_projection))
      all.push_back({.group = row.group,
                     .name = row.word,
                     .method = method_of_row(row, layer.mode, is_mesh),
                     .has_picture = row.has_picture});
  for (const DataRow& row : data_rows)
    if (applies(row.applies, is_mesh, is_projection))
      all.push_back({.group = row.group, .name = text_of(row.form), .data = row.form, .has_picture = row.has_picture});
  if (is_mesh && !is_projection && layer.surface.normals != render::Normals::smooth)
    all.push_back({.group = group_normals, .name = "smooth normals", .normals = render::Normals::smooth});
  if (scene.occlusion.radius > 0 && !is_projection)
    for (const int count : occlusion_counts)
      all.push_back({.group = group_occlusion, .name = concat(count, " rays a hit"), .occlusion_samples = count});
  for (const int shrink : shrinks)
    all.push_back({.group = group_size, .name = concat("1/", shrink, " of the size"), .shrink = shrink});
  return all;
}

}  // namespace rhoray::tools

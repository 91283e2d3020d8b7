#include "tools/rhoray/bench/tables.h"

#include <algorithm>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/read_value.h"
#include "render/document.h"
#include "tools/rhoray/bench/parts.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tools {

namespace {

/// The requested scene with every choice, and its files.
struct Asked {
  render::SceneSpec scene_spec;
  render::ResolvedScene plan;

  const render::Dataset& volume(const std::string& data) const {
    for (std::size_t i = 0; i < plan.data.size(); ++i)
      if (scene_spec.data[i].name == data) return plan.datasets[i];
    throw Error(ErrorCode::internal, concat("no data \"", data, '"'));
  }
};

using LightType = render::Light::Kind;

constexpr const char* plain = "plain";
constexpr const char* lit = "one light beside the eye";
constexpr const char* hard_shadows = "hard shadows";
constexpr const char* textured = "texture";
constexpr const char* textured_in_shadows = "texture, hard shadows";
constexpr const char* one_surface = "one opaque surface";

/// From the upper left of the camera.
render::LightSpec key_light() {
  return {.type = LightType::directional, .azimuth_deg = -40, .elevation_deg = 40, .from = "camera"};
}

bool is_surface(const render::LayerSpec& layer) {
  return layer.type == render::LayerType::isosurface || layer.type == render::LayerType::triangles;
}

bool has_surface(const Asked& asked) {
  return std::any_of(asked.scene_spec.layers.begin(), asked.scene_spec.layers.end(), is_surface);
}

/// Changes surfaces; false where no layer could be changed.
template <class Change>
bool change_surfaces(render::SceneSpec& scene, const Change& change) {
  bool any = false;
  for (render::LayerSpec& layer : scene.layers)
    if (is_surface(layer)) any |= change(layer);
  return any;
}

bool light_it(render::SceneSpec& scene, const render::LightSpec& light) {
  scene.lights = {light};
  return true;
}

/// Everything is present but invisible: a light and a surface switched off, and one layer left out.
bool add_what_is_off(render::SceneSpec& scene, const Asked&) {
  render::LightSpec none = key_light();
  none.intensity = 0, none.shadows = true, none.angular_diameter_deg = 5;
  scene.lights = {{.type = LightType::head}, none};
  render::LayerSpec clear = scene.layers[0], hidden = scene.layers[0];
  clear.opacity = 0, hidden.visible = false;
  scene.layers.insert(scene.layers.end(), {clear, hidden});
  return true;
}

bool shed_key_light(render::SceneSpec& scene, const Asked&) {
  return light_it(scene, key_light());
}
bool cast_hard_shadows(render::SceneSpec& scene, const Asked&) {
  render::LightSpec light = key_light();
  light.shadows = true;
  return light_it(scene, light);
}
bool cast_soft_shadows(render::SceneSpec& scene, const Asked&) {
  render::LightSpec light = key_light();
  light.shadows = true, light.angular_diameter_deg = 5;
  return light_it(scene, light);
}
bool occlude(render::SceneSpec& scene, const Asked& asked) {
  scene.effects.occlusion = asked.scene_spec.effects.occlusion.value_or(render::OcclusionSpec{});
  return true;
}
bool shine(render::SceneSpec& scene, const Asked&) {
  return change_surfaces(scene, [](render::LayerSpec& layer) {
    layer.specular = 0.25;
    return true;
  });
}
bool smooth(render::SceneSpec& scene, const Asked&) {
  return change_surfaces(scene, [](render::LayerSpec& layer) {
    layer.normals = "smooth";
    return true;
  });
}
bool color_by_field(render::SceneSpec& scene, const Asked& asked) {
  return change_surfaces(scene, [&](render::LayerSpec& layer) {
    if (layer.type != render::LayerType::isosurface) return false;
    layer.color_by = asked.volume(layer.data).field().name;
    return true;
  });
}
/// Plain scenes have the layers that were asked for, in order, without slices.
bool cover(render::SceneSpec& scene, const Asked& asked) {
  bool any = false;
  std::size_t place = 0;
  for (const render::LayerSpec& layer : asked.scene_spec.layers) {
    if (layer.type == render::LayerType::slice) continue;
    scene.layers[place++].texture = layer.texture;
    any |= !layer.texture.empty();
  }
  return any;
}
bool cover_and_cast_hard_shadows(render::SceneSpec& scene, const Asked& asked) {
  return cover(scene, asked) && cast_hard_shadows(scene, asked);
}
bool clip_it(render::SceneSpec& scene, const Asked& asked) {
  scene.clip = asked.scene_spec.clip;
  return scene.clip.has_value();
}
bool add_slices(render::SceneSpec& scene, const Asked& asked) {
  const std::size_t before = scene.layers.size();
  for (const render::LayerSpec& layer : asked.scene_spec.layers)
    if (layer.type == render::LayerType::slice) scene.layers.push_back(layer);
  return scene.layers.size() > before;
}
bool antialias(render::SceneSpec& scene, const Asked&) {
  scene.image.antialias = 16;
  return true;
}
bool raise_fog(render::SceneSpec& scene, const Asked& asked) {
  scene.effects.fog = asked.scene_spec.effects.fog.value_or(render::FogSpec{});
  return true;
}
bool clear_all(render::SceneSpec& scene, const Asked&) {
  return change_surfaces(scene, [](render::LayerSpec& layer) {
    layer.opacity = 0.5;
    return true;
  });
}

/// The first isosurface alone.
bool keep_one_surface(render::SceneSpec& scene, const Asked&) {
  const auto first = std::find_if(scene.layers.begin(), scene.layers.end(), [](const render::LayerSpec& layer) {
    return layer.type == render::LayerType::isosurface;
  });
  if (first == scene.layers.end()) return false;
  scene.layers = {render::LayerSpec(*first)};
  return true;
}

/// The surface and a second one of the same field, inside it by 2 % of the field's range, or
/// outside where the range ends.
bool show_two_transparent(render::SceneSpec& scene, const Asked& asked) {
  if (!keep_one_surface(scene, asked)) return false;
  render::LayerSpec& surface = scene.layers[0];
  surface.opacity = 0.5;
  double isovalue = 0;
  read_value(surface.isovalues[0], isovalue);
  const Interval<double> range = asked.volume(surface.data).field().range;
  const double step = 0.02 * (range.hi - range.lo);
  render::LayerSpec other = surface;
  other.isovalues = {concat(isovalue + step < range.hi ? isovalue + step : isovalue - step)};
  scene.layers.push_back(other);
  return true;
}

bool show_all(render::SceneSpec& scene, const Asked& asked) {
  scene = asked.scene_spec;
  return true;
}

/// A picture with one effect more than another one.
struct EffectRow {
  const char* name;
  const char* over;                                                       ///< the row that it is compared with
  bool (*switch_on)(render::SceneSpec& plain_scene, const Asked& asked);  ///< false: the scene has nothing of it
  double light_turns_by = 0;  ///< about the camera's upward axis, radians from frame to frame
};

constexpr EffectRow effect_rows_measured[] = {{plain, plain, [](render::SceneSpec&, const Asked&) { return true; }},
                                              {"all effects off", plain, add_what_is_off},
                                              {lit, plain, shed_key_light},
                                              {hard_shadows, lit, cast_hard_shadows},
                                              {"hard shadows, a light that moves", lit, cast_hard_shadows, 0.003},
                                              {"soft shadows, 16 rays", lit, cast_soft_shadows},
                                              {"ambient occlusion", plain, occlude},
                                              {"specular", plain, shine},
                                              {"smooth normals", plain, smooth},
                                              {"colour by a field", plain, color_by_field},
                                              {textured, plain, cover},
                                              {textured_in_shadows, lit, cover_and_cast_hard_shadows},
                                              {"clip region", plain, clip_it},
                                              {"slices", plain, add_slices},
                                              {"antialiasing, 16 samples", plain, antialias},
                                              {"fog", plain, raise_fog},
                                              {"transparent surfaces", plain, clear_all},
                                              {one_surface, plain, keep_one_surface},
                                              {"two transparent surfaces", one_surface, show_two_transparent},
                                              {"the scene as it is", plain, show_all}};

/// Its layers with a matte material under a light at the camera; slices are left out.
render::SceneSpec plain_scene(const render::SceneSpec& asked) {
  render::SceneSpec scene{.data = asked.data, .style = "fast"};
  scene.camera = asked.camera;
  scene.image.size = asked.image.size, scene.image.background = asked.image.background;
  for (const render::LayerSpec& layer : asked.layers) {
    if (layer.type == render::LayerType::slice) continue;
    render::LayerSpec matte{.type = layer.type, .data = layer.data, .isovalues = layer.isovalues};
    if (layer.type == render::LayerType::mip) matte.range = layer.range;
    matte.color = layer.color;
    matte.opacity = 1;
    matte.accuracy = layer.accuracy, matte.method = layer.method;
    matte.specular = 0;
    scene.layers.push_back(matte);
  }
  return scene;
}

/// A row's picture and its cost, round after round.
struct TimedEffect {
  const EffectRow* row;
  std::size_t over = 0;  ///< index of the row that it is compared with
  render::ResolvedScene plan;
  render::Framebuffer picture{};
  render::RenderContext memory{};
  render::FrameStatistics statistics{};
  std::vector<double> over_cpu_s{}, cpu_s{}, wall_s{};  ///< over_cpu_s: of the picture it is compared with, just before

  /// One frame; its CPU time.
  double trace() {
    if (row->light_turns_by != 0) turn_light();
    const double before = usage_so_far().cpu_s;
    statistics = render::render(plan.datasets, plan.scene, plan.frame, picture, memory);
    return usage_so_far().cpu_s - before;
  }

 private:
  void turn_light() {
    const Vec3 axis = plan.scene.camera.up.normalized();
    Vec3& light = plan.scene.lights[0].place;
    light = light * std::cos(row->light_turns_by) + axis.cross(light) * std::sin(row->light_turns_by) +
            axis * (axis.dot(light) * (1 - std::cos(row->light_turns_by)));
  }
};

/// A row's frame just after a frame of the picture it is compared with. That picture is drawn
/// twice: the first frame finds the caches as the previous row left them (after ambient occlusion
/// the torso's plain picture takes 2.6 % longer) and is not timed.
/// @return  wall time of the row's frame
double measure_after(TimedEffect& over, TimedEffect& measured) {
  over.trace();
  measured.over_cpu_s.push_back(over.trace());
  measured.cpu_s.push_back(measured.trace());
  measured.wall_s.push_back(measured.statistics.wall_s);
  return measured.wall_s.back();
}

render::SceneSpec spec_of(const BenchOptions& options) {
  render::SceneSpec scene_spec;
  if (!options.read.raw.empty() || !render::is_scene_document(options.input)) {
    scene_spec = {.data = std::vector<render::DataSpec>(1), .layers = std::vector<render::LayerSpec>(1)};
    scene_spec.data[0].file = options.input, scene_spec.data[0].field = options.field;
    scene_spec.data[0].read = options.read;
    render::LayerSpec& layer = scene_spec.layers[0];
    layer.isovalues = options.isovalues;
    layer.normals = options.normals, layer.color_by = options.color_by;
    if (options.mip) scene_spec.layers.push_back({.type = render::LayerType::mip});
    scene_spec.camera.view = options.view;
  } else {
    const std::vector<std::string> read = preprocess::option_words(pack_options(options.read));
    for (const auto& [is_given, name] : {std::pair{!read.empty(), read.empty() ? "" : read.front().c_str()},
                                         {options.isovalues != BenchOptions{}.isovalues, "--iso"},
                                         {!options.field.empty(), "--field"},
                                         {!options.normals.empty(), "--normals"},
                                         {!options.color_by.empty(), "--color-by"},
                                         {options.mip, "--mip"}})
      if (is_given)
        throw Error(ErrorCode::usage, concat(name, ": not allowed with the scene ", options.input.string(),
                                             "; its layers define what is shown"));
    scene_spec = render::read_scene(options.input).scene_spec;
  }
  if (!options.accuracy.empty()) {
    scene_spec.accuracy = options.accuracy;
    for (render::LayerSpec& layer : scene_spec.layers) layer.accuracy.clear(), layer.method.clear();
  }
  scene_spec.image.size = options.size;
  scene_spec.image.channels = std::nullopt, scene_spec.image.show = std::nullopt;
  return scene_spec;
}

Asked asked_of(const BenchOptions& options) {
  const render::SceneSpec scene_spec = spec_of(options);
  Asked asked;
  asked.plan = resolve_layers(scene_spec);
  aim_camera(scene_spec, asked.plan);
  asked.scene_spec = to_spec(asked.plan);
  return asked;
}

/// Plans a scene with the files that are open already.
render::ResolvedScene planned(const render::SceneSpec& scene_spec, const Asked& asked, unsigned threads) {
  render::ResolvedScene plan =
      resolve_layers(scene_spec, [&](const render::DataSpec& data, formats::Space) { return asked.volume(data.name); });
  aim_camera(scene_spec, plan);
  plan.frame.threads = threads;
  return plan;
}

std::vector<TimedEffect> rows_of(const Asked& asked, unsigned threads) {
  std::vector<TimedEffect> rows;
  for (const EffectRow& row : effect_rows_measured) {
    render::SceneSpec scene = plain_scene(asked.scene_spec);
    if (!row.switch_on(scene, asked)) continue;
    rows.push_back({.row = &row, .plan = planned(scene, asked, threads)});
    rows.back().over = static_cast<std::size_t>(
        std::find_if(rows.begin(), rows.end(), [&](const TimedEffect& m) { return m.row->name == row.over; }) -
        rows.begin());
  }
  return rows;
}

std::vector<double> ratios(const std::vector<double>& of, const std::vector<double>& over) {
  std::vector<double> list;
  for (std::size_t i = 0; i < of.size(); ++i) list.push_back(of[i] / over[i]);
  return list;
}

std::vector<double> milliseconds(std::vector<double> seconds) {
  for (double& s : seconds) s *= 1e3;
  return seconds;
}

Json context_of(const BenchOptions& options, const Asked& asked) {
  Json json = bench_context(options);
  json["size"] = {options.size.width, options.size.height};
  json["scene"] = scene_json(asked.scene_spec);
  return json;
}

Table effects_table(const std::vector<TimedEffect>& rows, const Json& context) {
  Table table{"effects", "Cost of each effect: CPU time compared with the same picture without it", context, {}};
  for (const TimedEffect& measured : rows) {
    const render::FrameStatistics& counts = measured.statistics;
    Json row{{"effect", measured.row->name}, {"over", measured.row->over}};
    add_spread(row, "ratio", spread_of(ratios(measured.cpu_s, measured.over_cpu_s)));
    add_spread(row, "cpu_ms", spread_of(milliseconds(measured.cpu_s)));
    row["fps"] = 1 / spread_of(measured.wall_s).median;
    row["rays"] = counts.rays;
    row["ruled_out"] = counts.rays_ruled_out;
    row["hits"] = counts.hits;
    row["shadow_rays"] = counts.shadow_rays;
    row["occlusion_rays"] = counts.occlusion_rays;
    row["clear_crossings"] = counts.clear_crossings;
    row["clear_per_hit"] =
        counts.hits > 0 ? static_cast<double>(counts.clear_crossings) / static_cast<double>(counts.hits) : 0;
    row["rays_through"] = counts.rays_through;
    row["highlights"] = counts.highlights_shaded;
    row["normals_smoothed"] = counts.normals_smoothed;
    row["colors_looked_up"] = counts.colors_looked_up;
    row["texture_lookups"] = counts.texture_lookups;
    row["slice_lookups"] = counts.slice_lookups;
    row["rays_clipped"] = counts.rays_clipped;
    row["edge_samples"] = counts.edge_samples;
    row["cells_visited"] = counts.cells_visited;
    row["cells_solved"] = counts.cells_solved;
    row["machine"] = counts.machine;
    row["picture"] = picture_hash(measured.picture);
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Parker et al. 1999, Table 4: the Visible Male on 64 processors.
struct PaperFrames {
  const char* shows;
  double fps;
  const char* row;  ///< of ours
};
constexpr PaperFrames paper_frames[] = {{"no shadows, no texture", 15.9, lit},
                                        {"shadows, no texture", 8.7, hard_shadows},
                                        {"no shadows, texture", 12.6, "texture"},
                                        {"shadows, texture", 7.5, "texture, hard shadows"}};

Table paper_table_4(const std::vector<TimedEffect>& rows, const Json& context) {
  Table table{"table_4", "The paper's Table 4: frames per second of CPU time with shadows and texture", context, {}};
  const auto fps_of = [&](const char* name) -> std::optional<double> {
    for (const TimedEffect& row : rows)
      if (row.row->name == std::string_view(name)) return 1 / spread_of(row.cpu_s).median;
    return std::nullopt;
  };
  for (const PaperFrames& paper : paper_frames) {
    const std::optional<double> fps = fps_of(paper.row), first = fps_of(paper_frames[0].row);
    table.rows.push_back({{"shows", paper.shows},
                          {"paper_fps", paper.fps},
                          {"paper_time", paper_frames[0].fps / paper.fps},
                          {"fps", fps ? Json(*fps) : Json()},
                          {"time", fps && first ? Json(*first / *fps) : Json()}});
  }
  return table;
}

/// Shares of a frame's CPU time, in percent.
Json shares(const char* who, const std::string& shows, double traversal, double intersection, double shading,
            const std::string& fps) {
  return {{"who", who},
          {"shows", shows},
          {"traversal_percent", traversal},
          {"intersection_percent", intersection},
          {"shading_percent", shading},
          {"fps", fps}};
}

Table paper_table_1(std::vector<TimedEffect>& rows, int repeat, const Json& context) {
  Table table{"table_1", "The paper's Table 1: where the time goes, and frames per second", context, {}};
  constexpr const char* authors = "Parker et al. 1999, 64 processors";
  table.rows.push_back(shares(authors, "skin of the Visible Woman", 55, 22, 23, "7-15"));
  table.rows.push_back(shares(authors, "bone of the Visible Woman", 66, 21, 13, "6-15"));
  for (TimedEffect& measured : rows) {
    render::FrameStatistics::Phases sum;
    measured.plan.frame.time_phases = true;
    std::vector<double> wall_s;
    for (int round = 0; round < repeat; ++round) {
      measured.trace();
      wall_s.push_back(measured.statistics.wall_s);
      const render::FrameStatistics::Phases& phases = measured.statistics.phases;
      sum.traversal += phases.traversal, sum.intersection += phases.intersection, sum.shading += phases.shading;
    }
    const double all = sum.traversal + sum.intersection + sum.shading;
    table.rows.push_back(shares("rhoray", measured.row->name, 100 * sum.traversal / all, 100 * sum.intersection / all,
                                100 * sum.shading / all, rounded(1 / spread_of(wall_s).median)));
  }
  return table;
}

}  // namespace

std::vector<Table> effects_tables(const BenchOptions& options, const Step& step) {
  const Asked asked = asked_of(options);
  if (!has_surface(asked))
    throw Error(ErrorCode::invalid, concat(options.input.string(), ": shows no surface; table 'effects' needs one"));
  std::vector<TimedEffect> rows = rows_of(asked, options.threads);
  interleaved(rows.size(), options.repeat, [&](std::size_t row) {
    step(rows[row].row->name);
    return measure_after(rows[rows[row].over], rows[row]);
  });
  for (TimedEffect& row : rows)  // what was not timed
    for (std::vector<double>* seconds : {&row.over_cpu_s, &row.cpu_s, &row.wall_s}) seconds->erase(seconds->begin());
  const Json context = context_of(options, asked);
  std::vector<Table> tables{effects_table(rows, context), paper_table_4(rows, context)};
  step("phases");
  tables.push_back(paper_table_1(rows, options.repeat, context));
  return tables;
}

}  // namespace rhoray::tools

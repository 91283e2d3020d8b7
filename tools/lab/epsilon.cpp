// Two distances that other renderers let their users choose: how far off the surface a shadow ray
// starts, and how far apart the field is sampled along a ray. Measures the errors of each, from far
// too small to far too large distances. Compares them with rays that know on which side they start,
// and with roots that are solved for.

#include "tools/lab/epsilon.h"

#include <cmath>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/read_value.h"
#include "preprocess/input_file.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_spec.h"
#include "tools/lab/figures.h"
#include "tools/lab/judged_view.h"
#include "tools/lab/shadow_starts.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::study {

namespace {

constexpr const char* shadow_table = "epsilon_shadows";
constexpr const char* step_table = "epsilon_steps";

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field, view = "front";
  std::vector<std::string> isovalues{"auto"};
  Vec3 light{0.4, -0.6, 0.7};
  render::PictureSize size{512, 512};
  double judge_seconds = 60;
  std::uint64_t seed = 1;
};

constexpr double epsilons[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1};
constexpr double steps[] = {2, 1, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625};

std::string precision_of(const StartSettings& setting) {
  return setting.is_rounded || setting.method.precision == render::Method::Precision::float32 ? "float" : "double";
}

std::vector<StartSettings> start_settings() {
  const render::Method single = render::method_of(render::Accuracy::float32);
  std::vector<StartSettings> settings{{.start = Start::knows_side, .method = single}, {.start = Start::knows_side}};
  for (const Start start : {Start::along_ray, Start::along_normal})
    for (const bool is_single : {true, false})
      for (const double epsilon : epsilons)
        settings.push_back({.start = start,
                            .epsilon_cells = epsilon,
                            .method = is_single ? single : render::Method{},
                            .is_rounded = is_single});
  return settings;
}

std::vector<Json> shadow_rows(const ShadowStarts& starts, double isovalue) {
  std::vector<Json> rows;
  for (const StartSettings& setting : start_settings()) {
    const StartCounts counts = starts.count(setting);
    const auto ppm = [&](std::uint64_t count) {
      return counts.rays == 0 ? Json(nullptr)
                              : Json(1e6 * static_cast<double>(count) / static_cast<double>(counts.rays));
    };
    const bool is_moved = setting.start != Start::knows_side;
    rows.push_back({{"isovalue", isovalue},
                    {"start", name_of(setting.start)},
                    {"hits", precision_of(setting)},
                    {"epsilon_cells", is_moved ? Json(setting.epsilon_cells) : Json(nullptr)},
                    {"rays", counts.rays},
                    {"dark", counts.dark},
                    {"acne", counts.acne},
                    {"leaks", counts.leaks},
                    {"acne_ppm", ppm(counts.acne)},
                    {"leaks_ppm", ppm(counts.leaks)},
                    {"wrong_ppm", ppm(counts.acne + counts.leaks)},
                    {"undecided", starts.undecided()}});
  }
  return rows;
}

/// Sampling at a step, and methods that solve for the root.
std::vector<std::string> method_words() {
  std::vector<std::string> words{"float", "double"};
  for (const char* refinement : {"linear", "bisect"})
    for (const double step : steps) words.push_back(concat("sampled:", step, "+", refinement));
  return words;
}

std::vector<Json> step_rows(const ExactView& view, const render::Dataset& dataset, double isovalue) {
  std::vector<Json> rows;
  for (const std::string& word : method_words()) {
    const bool is_sampled = word.starts_with("sampled");
    const render::Method method = is_sampled ? render::method_named(word, render::Mode::isosurface, dataset.is_mesh())
                                             : render::method_of(render::accuracy_named(word));
    Json row{{"isovalue", isovalue},
             {"method", word},
             {"step_cells", is_sampled ? Json(method.step) : Json(nullptr)},
             {"refinement", !is_sampled     ? "solved"
                            : method.bisect ? "bisection"
                                            : "linear"}};
    row.update(view.ray_errors({.dataset = dataset, .isovalue = isovalue, .method = method}));
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<Figure> figures_of(const tools::Table& shadows, const tools::Table& sampled) {
  const Json first = shadows.rows[0]["isovalue"];
  Figure starts{.name = shadow_table,
                .x = {"epsilon: where the ray starts, cells off the hit"},
                .y = {.label = "wrong of a million shadow rays", .least = 0.3},
                .curves = {}};
  for (const Start start : {Start::along_ray, Start::along_normal})
    for (const char* hits : {"float", "double"}) {
      Curve curve{concat(name_of(start), ", ", hits, " hits"), {}, hits == std::string("double")};
      for (const Json& row : shadows.rows)
        if (row["isovalue"] == first && row["start"] == name_of(start) && row["hits"] == hits &&
            row["wrong_ppm"].is_number())
          curve.points.push_back({row["epsilon_cells"], row["wrong_ppm"], {}});
      starts.curves.push_back(std::move(curve));
    }
  for (const Json& row : shadows.rows)
    if (row["isovalue"] == first && row["start"] == name_of(Start::knows_side) && row["wrong_ppm"].is_number())
      starts.curves.push_back({concat("knows its side, ", std::string(row["hits"])),
                               {{epsilons[0], row["wrong_ppm"], {}}, {1, row["wrong_ppm"], {}}}});
  Figure misses{.name = step_table,
                .x = {"distance of samples, cells"},
                .y = {.label = "missed, false or another sheet, of a million pixels", .least = 0.3},
                .curves = {}};
  std::vector<Json> isovalues;
  for (const Json& row : sampled.rows)
    if (isovalues.empty() || isovalues.back() != row["isovalue"]) isovalues.push_back(row["isovalue"]);
  for (const Json& isovalue : isovalues)
    for (const char* refinement : {"linear", "solved"}) {
      const bool is_solved = refinement == std::string("solved");
      Curve curve{concat(is_solved ? "solved, isovalue " : "sampled, isovalue ", rounded(isovalue, 6)), {}, is_solved};
      for (const Json& row : sampled.rows) {
        if (row["isovalue"] != isovalue || row["refinement"] != refinement) continue;
        const double wrong = row["wrong_ppm"];
        if (!is_solved)
          curve.points.push_back({row["step_cells"], wrong, {}});
        else if (row["method"] == "double")
          for (const double step : {steps[0], steps[std::size(steps) - 1]}) curve.points.push_back({step, wrong, {}});
      }
      misses.curves.push_back(std::move(curve));
    }
  return {starts, misses};
}

int run(const Settings& settings) {
  require_publishable(settings.common, {shadow_table, step_table});
  require_publishable_figures(settings.common, {shadow_table, step_table});
  require_within("--judge-seconds", settings.judge_seconds, 0, 1e6);
  if (!(settings.light.length() > 0)) throw Error(ErrorCode::usage, "--light: found 0,0,0; expected a direction");
  preprocess::require_input(settings.input);
  const render::Dataset dataset = tools::load_dataset(settings.input, settings.field);
  tools::Table shadows{shadow_table, "Rays to a light by how far off the surface they start", {}, {}};
  tools::Table sampled{step_table, "An isosurface by how far apart the field is sampled", {}, {}};
  shadows.context = sampled.context = context_with({{"input", settings.input.filename().string()},
                                                    {"field", dataset.field().name},
                                                    {"view", settings.view},
                                                    {"light", tools::json_of(settings.light)},
                                                    {"size", {settings.size.width, settings.size.height}},
                                                    {"machine", render::name_of(render::chosen_machine())},
                                                    {"seed", settings.seed}});
  {
    tools::ProgressDisplay display(settings.common);
    for (const std::string& text : settings.isovalues) {
      const double isovalue = render::choose_isovalue(text, dataset.field()).value;
      display.show(concat("isovalue ", isovalue, ", the exact answer"));
      const ExactView view(dataset,
                           {.isovalue = isovalue,
                            .camera = tools::study_camera(tools::study_view_named(settings.view), dataset, isovalue,
                                                          double{1} * settings.size.width / settings.size.height),
                            .size = settings.size,
                            .judge_seconds = settings.judge_seconds,
                            .seed = settings.seed});
      display.show(concat("isovalue ", isovalue, ", shadow rays"));
      for (Json& row : shadow_rows(ShadowStarts(dataset, isovalue, view.truth(), settings.light), isovalue))
        shadows.rows.push_back(std::move(row));
      display.show(concat("isovalue ", isovalue, ", samples"));
      for (Json& row : step_rows(view, dataset, isovalue)) sampled.rows.push_back(std::move(row));
    }
  }
  publish(shadows, settings.common);
  publish(sampled, settings.common);
  publish(figures_of(shadows, sampled), settings.common);
  return 0;
}

}  // namespace

tools::Subcommand epsilon() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "epsilon",
      .summary = "What is missed by distances chosen by hand: starts of shadow rays, steps of samples",
      .examples = {"rhoray-study epsilon smooth.rho --iso 600.5,2200.5 -o results",
                   "rhoray-study epsilon torso.rho --iso p75 --view close-up"},
      .sections = {{.heading = "Notes",
                    .entries = {{"",
                                 "Everything is counted against the exact answer. A million is the most that can be "
                                 "wrong of a million."}}}},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid or mesh", settings->input)},
           tools::output_options(settings->common,
                                 "FOLDER for epsilon_shadows and epsilon_steps, .csv, .json and .svg"),
           {tools::value_option("--iso", "V[,V]", "Isovalues, as in render; default auto", settings->isovalues),
            tools::value_option("--field", "NAME", "Field; default the first", settings->field),
            tools::value_option("--light", "X,Y,Z", "Direction towards the light; default 0.4,-0.6,0.7",
                                settings->light),
            tools::value_option("--view", "NAME", "front, from-feet, close-up or inside; default front",
                                settings->view),
            tools::value_option("--size", "WxH", "Pixels; default 512x512", settings->size),
            tools::value_option("--judge-seconds", "S",
                                "Pixels are judged in random order until this time is over; default 60",
                                settings->judge_seconds),
            tools::value_option("--seed", "N", "Of that order; default 1", settings->seed),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

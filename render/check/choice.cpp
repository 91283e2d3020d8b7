#include <algorithm>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/number_text.h"
#include "formats/base/stopping.h"
#include "render/accuracy.h"
#include "render/method_words.h"
#include "render/render.h"
#include "render/scene_spec.h"
#include "render/truth.h"

namespace rhoray::render {

namespace {

constexpr double small_pixels = 20'000;
constexpr double judge_seconds = 3;
constexpr int times = 3;

struct CandidateRow {
  const char* word;
  bool is_level;
  bool of_surfaces, of_projections;
};
constexpr CandidateRow candidate_rows[] = {{"preview", true, true, false},
                                           {"float", true, true, false},
                                           {"double", true, true, true},
                                           {"certified", true, true, true},
                                           {"exact", true, true, true},
                                           {"sampled:1+linear", false, true, true},
                                           {"sampled:0.5+linear", false, true, true},
                                           {"sampled:0.25+linear", false, true, true}};

PictureSize small_size(const ResolvedScene& resolved) {
  const double pixels = static_cast<double>(resolved.frame.width) * resolved.frame.height;
  const double shrink = std::max(1.0, std::sqrt(pixels / small_pixels));
  const auto side = [&](int whole) { return std::max(1, static_cast<int>(std::lround(whole / shrink))); };
  return {side(resolved.frame.width), side(resolved.frame.height)};
}

/// One layer of a resolved, alone.
struct Alone {
  const Dataset& dataset;
  Scene scene;
  PictureSize size;
  unsigned threads;
  std::optional<Machine> machine;

  Layer& layer() { return scene.layers[0]; }
  bool is_projection() const { return scene.layers[0].mode == Mode::mip; }
  /// Unit of an error.
  double unit() const {
    const Interval<double> range = dataset.field().range;
    return is_projection() && range.hi > range.lo ? range.hi - range.lo : 1;
  }
};

double traced_ms(Alone& alone, const std::stop_token& stop) {
  Framebuffer picture;
  RenderContext memory;
  const FrameOptions frame{
      .width = alone.size.width, .height = alone.size.height, .threads = alone.threads, .machine = alone.machine};
  std::vector<double> ms;
  for (int time = 0; time <= times; ++time) {
    const FrameStatistics statistics =
        refine(alone.dataset, alone.scene, frame, {.first_spacing = 1, .watch = stop}, picture, memory);
    end_if_stopped(stop);
    const double taken = 1e3 * (statistics.wall_s - statistics.preparation_s);
    // The first fills caches; a slow one is timed once.
    if (time > 0 || taken > 500) ms.push_back(taken);
    if (taken > 500) break;
  }
  std::sort(ms.begin(), ms.end());
  return (ms[(ms.size() - 1) / 2] + ms[ms.size() / 2]) / 2;
}

/// True for a method that proves that its error is below max_error.
bool is_proven(const Method& method, double max_error, bool is_projection, bool is_mesh) {
  if (method.algorithm == Method::Algorithm::exact) return max_error >= 1e-9;
  return method.algorithm == Method::Algorithm::certified && !is_projection && !is_mesh && max_error >= 1e-3;
}

Candidate tried(Alone& alone, const Method& method, const Truth& truth, const Goal& goal, const std::stop_token& stop) {
  alone.layer().method = method;
  Candidate candidate{.method = method, .word = option_of(method, alone.layer().mode, alone.dataset.is_mesh()).word};
  const bool is_exact = method.algorithm == Method::Algorithm::exact;
  const std::vector<Hit> hits = is_exact ? truth.hits
                                         : trace_rays({.dataset = alone.dataset,
                                                       .mode = alone.layer().mode,
                                                       .isovalue = alone.layer().isovalue,
                                                       .method = method,
                                                       .clip = clip_of(alone.scene, alone.layer()),
                                                       .threads = alone.threads,
                                                       .watch = stop,
                                                       .machine = alone.machine},
                                                      truth.rays);
  const ErrorCounts errors = count_errors(errors_against(truth, alone.layer().mode, hits));
  candidate.error = errors.kept_by(0.99) / alone.unit();
  candidate.foreseen_ms = traced_ms(alone, stop);
  if (goal.max_error) {
    const std::uint64_t seen = errors.true_hits + errors.false_hits;
    const std::uint64_t beyond = errors.beyond(*goal.max_error * alone.unit());
    candidate.keeps_error = is_proven(method, *goal.max_error, alone.is_projection(), alone.dataset.is_mesh()) ||
                            share_of(beyond, seen, false).high <= 0.01;
  }
  return candidate;
}

std::string time_text(double ms) {
  return ms < 1000 ? concat(rounded(ms, 2), " ms") : concat(rounded(ms / 1000, ms < 1e5 ? 2 : 4), " s");
}

std::string error_text(const Alone& alone, double error) {
  const std::string number = std::isfinite(error) ? rounded(error, 2) : std::string("no limit");
  return concat(number, alone.is_projection() ? " of the field's range" : " cells");
}

Choice chosen_of(const std::vector<Candidate>& candidates, const Goal& goal, const Alone& alone) {
  const auto in_time = [&](const Candidate& c) { return !goal.budget_ms || c.foreseen_ms <= *goal.budget_ms; };
  const auto cheaper = [](const Candidate& a, const Candidate& b) { return a.foreseen_ms < b.foreseen_ms; };
  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.error != b.error ? a.error < b.error : a.foreseen_ms < b.foreseen_ms;
  };
  std::vector<Candidate> left;
  for (const Candidate& c : candidates)
    if (c.keeps_error && (goal.max_error || in_time(c))) left.push_back(c);
  Choice choice;
  choice.candidates = candidates;
  std::string why;
  if (left.empty()) {
    choice.meets_goal = false;
    const bool is_error = goal.max_error.has_value();
    choice.chosen = is_error ? *std::min_element(candidates.begin(), candidates.end(), better)
                             : *std::min_element(candidates.begin(), candidates.end(), cheaper);
    why = is_error ? "no method is known to keep the error limit; this is the most accurate"
                   : "no method keeps the time limit; this is the fastest";
  } else if (goal.max_error) {
    choice.chosen = *std::min_element(left.begin(), left.end(), cheaper);
    choice.meets_goal = in_time(choice.chosen);
    why = choice.meets_goal
              ? "the fastest method within the error limit in 99 % of the pixels"
              : "the fastest method within the error limit in 99 % of the pixels, but above the time limit";
  } else {
    choice.chosen = *std::min_element(left.begin(), left.end(), better);
    why = "the most accurate method within the time limit";
  }
  choice.sentence =
      concat("method ", choice.chosen.word, ": ", why, "; predicted ", time_text(choice.chosen.foreseen_ms),
             ", 99 % of the pixels within ", error_text(alone, choice.chosen.error), " (tried ", candidates.size(),
             " methods on ", alone.size.width, " x ", alone.size.height, " pixels)");
  return choice;
}

}  // namespace

Choice choose_method(const ResolvedScene& resolved, std::size_t index, const Goal& goal, unsigned threads,
                     const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  const Layer& layer = resolved.scene.layers[index];
  Alone alone{.dataset = resolved.datasets[layer.dataset],
              .scene = resolved.scene,
              .size = small_size(resolved),
              .threads = threads,
              .machine = resolved.frame.machine};
  alone.scene.layers = {layer};
  alone.layer().dataset = 0;
  const Truth truth = find_truth({.dataset = alone.dataset,
                                  .scene = alone.scene,
                                  .size = alone.size,
                                  .seconds = judge_seconds,
                                  .threads = threads,
                                  .watch = watch});
  const double growth = static_cast<double>(resolved.frame.width) * resolved.frame.height /
                        (static_cast<double>(alone.size.width) * alone.size.height);
  std::vector<CandidateRow> rows;
  std::copy_if(std::begin(candidate_rows), std::end(candidate_rows), std::back_inserter(rows),
               [&](const CandidateRow& row) { return alone.is_projection() ? row.of_projections : row.of_surfaces; });
  std::vector<Candidate> candidates;
  ProgressMeter meter(watch.progress, "trying methods (methods)", rows.size());
  for (const CandidateRow& row : rows) {
    const Method method = row.is_level ? method_of(accuracy_named(row.word))
                                       : method_named(row.word, layer.mode, alone.dataset.is_mesh());
    candidates.push_back(tried(alone, method, truth, goal, watch.stop));
    candidates.back().foreseen_ms *= growth;
    meter.add(1);
  }
  return chosen_of(candidates, goal, alone);
}

std::vector<Choice> choose_methods(ResolvedScene& resolved, const Goal& goal, unsigned threads, const Watch& watch) {
  std::vector<std::size_t> layers;
  for (std::size_t layer = 0; layer < resolved.scene.layers.size(); ++layer)
    if (const Mode mode = resolved.scene.layers[layer].mode; mode == Mode::isosurface || mode == Mode::mip)
      layers.push_back(layer);
  if (layers.empty())
    throw Error(ErrorCode::usage,
                concat(goal.max_error ? "--max-error" : "--budget-ms", ": no layer is an isosurface or a projection"),
                "leave it out, or add an isosurface or a projection");
  Goal of_layer = goal;
  if (goal.budget_ms) of_layer.budget_ms = *goal.budget_ms / static_cast<double>(layers.size());
  std::vector<Choice> choices;
  for (const std::size_t layer : layers) choices.push_back(choose_method(resolved, layer, of_layer, threads, watch));
  for (std::size_t i = 0; i < layers.size(); ++i) resolved.scene.layers[layers[i]].method = choices[i].chosen.method;
  return choices;
}

}  // namespace rhoray::render

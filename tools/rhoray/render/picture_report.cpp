#include "tools/rhoray/render/picture_report.h"

#include <algorithm>
#include <cstdio>

#include "formats/base/number_text.h"
#include "formats/base/word_list.h"
#include "render/document.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_words.h"
#include "tools/analysis/format_statistics.h"
#include "tools/analysis/pick.h"
#include "tools/rhoray/accuracy_options.h"
#include "tools/rhoray/render/reproduce.h"

namespace rhoray::tools {

namespace {

Json camera_json(const render::Camera& camera) {
  Json json{{"position", json_of(camera.position)}, {"target", json_of(camera.target)}, {"up", json_of(camera.up)}};
  if (camera.orthographic)
    json["orthographic_height"] = camera.orthographic_height;
  else
    json["vertical_fov_deg"] = camera.vertical_fov_deg;
  return json;
}

/// The quantity shown by a scene of one layer (is_of_one_layer).
Json shown_json(const render::ResolvedScene& plan) {
  const render::Layer& layer = plan.scene.layers[0];
  const bool iso = layer.mode == render::Mode::isosurface;
  Json json{{"file", plan.data[layer.dataset].file.string()}};
  if (layer.mode == render::Mode::triangles) {
    const bool is_boundary = plan.datasets[layer.dataset].has_fields();
    json["mode"] = is_boundary ? "boundary" : "triangles";
    if (is_boundary) json["field"] = plan.data[layer.dataset].field;
    return json;
  }
  json["field"] = plan.data[layer.dataset].field;
  json["mode"] = iso ? "iso" : layer.mode == render::Mode::slice ? "slice" : "mip";
  if (iso) {
    json["isovalue"] = layer.isovalue;
    json["isovalue_from"] = plan.origins[0].isovalue_from;
  } else {
    json["range"] = json_of(layer.mode == render::Mode::slice ? layer.material.color_by->range : layer.window);
  }
  return json;
}

void report_json(const Drawn& drawn) {
  const render::ResolvedScene& plan = drawn.plan;
  const StageTimes& stations = drawn.stations;
  Json json{{"picture", drawn.output.string()}};
  if (is_of_one_layer(plan)) json.update(shown_json(plan));
  json["method"] = method_text(plan);
  json["size"] = {plan.frame.width, plan.frame.height};
  json["camera"] = camera_json(plan.scene.camera);
  json["scene"] = scene_json(to_spec(plan));
  json["statistics"] = statistics_json(drawn.statistics);
  json["seconds"] = {{"open", stations.open_s},
                     {"prove_ranges", stations.prove_s},
                     {"trace", stations.trace_s},
                     {"wait_for_checks", stations.wait_for_checks_s},
                     {"write", stations.write_s}};
  if (!drawn.picks.empty()) json["picks"] = drawn.picks;
  for (std::size_t i = 1; i < drawn.picks.size(); ++i)
    json["distances"].push_back(picked_distance(drawn.picks[i - 1], drawn.picks[i]));
  if (drawn.self_check) json["verify"] = json_of(*drawn.self_check);
  json["reproduce"] = drawn.reproduce;
  std::puts(dump(json).c_str());
}

Json explanation_json(const render::Explanation& explanation) {
  Json json{{"layers", Json::array()}, {"lights", explanation.lights}, {"left_out", explanation.left_out}};
  json["antialiasing"] = explanation.antialiasing;
  for (std::size_t i = 0; i < explanation.layers.size(); ++i) {
    const render::Explanation::Layer& layer = explanation.layers[i];
    json["layers"].push_back({{"layer", i},
                              {"spec", layer.spec},
                              {"shows", layer.shows},
                              {"isovalue_from", layer.isovalue_from},
                              {"method", layer.method},
                              {"method_because", layer.method_because},
                              {"kernel", layer.kernel},
                              {"effects", Json::array()}});
    for (const render::EffectReason& reason : layer.effects)
      json["layers"].back()["effects"].push_back(
          {{"effect", reason.effect}, {"called_for", reason.called_for}, {"why", reason.why}});
  }
  return json;
}

std::vector<std::string> lines_of(const render::Explanation& explanation) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < explanation.layers.size(); ++i) {
    const render::Explanation::Layer& layer = explanation.layers[i];
    const bool is_chosen = !layer.isovalue_from.empty() && layer.isovalue_from != "given";
    lines.push_back(concat("layer ", i, ": ", layer.shows, is_chosen ? concat(" (", layer.isovalue_from, ")") : ""));
    lines.push_back(concat("  method ", layer.method, " (", layer.method_because, "), ",
                           layer.kernel == "scalar" ? "one ray at a time" : concat("wide ", layer.kernel, " kernel")));
    for (const render::EffectReason& reason : layer.effects)
      lines.push_back(concat(reason.called_for ? "  " : "  no ", reason.effect, ": ", reason.why));
  }
  for (std::size_t i = 0; i < explanation.lights.size(); ++i)
    lines.push_back(concat("light ", i, ": ", explanation.lights[i]));
  lines.push_back(explanation.antialiasing);
  lines.insert(lines.end(), explanation.left_out.begin(), explanation.left_out.end());
  return lines;
}

}  // namespace

std::string method_text(const render::ResolvedScene& plan) {
  std::vector<std::string> words;
  for (const render::Layer& layer : plan.scene.layers) {
    const std::string word = option_of(layer.method, layer.mode, plan.datasets[layer.dataset].is_mesh()).word;
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  return joined(words);
}

void say_choices(const CommonOptions& common, const render::ResolvedScene& plan) {
  for (const std::string& note : plan.notes) say(common, concat("note: ", note));
  for (std::size_t i = 0; i < plan.origins.size(); ++i) {
    const std::string& from = plan.origins[i].isovalue_from;
    const render::Layer& layer = plan.scene.layers[i];
    if (!from.empty() && from != "given")
      say(common, render::isovalue_text({layer.isovalue, from, plan.origins[i].isovalue_alternatives},
                                        plan.datasets[layer.dataset].field()));
  }
}

void report(const RenderCommand& command, const Drawn& drawn) {
  const CommonOptions& common = command.common;
  const render::ResolvedScene& plan = drawn.plan;
  const StageTimes& stations = drawn.stations;
  const double total =
      stations.open_s + stations.prove_s + stations.trace_s + stations.wait_for_checks_s + stations.write_s;
  if (common.json) {
    report_json(drawn);
  } else {
    if (command.statistics)
      std::fputs(concat("  method                ", method_text(plan), "\n  machine               ",
                        drawn.statistics.machine, "\n", statistics_text(drawn.statistics))
                     .c_str(),
                 stdout);
    if (drawn.self_check) std::fputs(text_of(*drawn.self_check).c_str(), stdout);
    for (std::size_t i = 0; i < drawn.picks.size(); ++i) {
      std::puts(picked_text(drawn.picks[i]).c_str());
      if (i > 0) std::puts(picked_distance_text(drawn.picks[i - 1], drawn.picks[i]).c_str());
    }
  }
  say_choices(common, plan);
  for (const render::Choice& choice : drawn.choices) say(common, choice.sentence);
  if (plan.page) {
    const std::string shown = word_of(*plan.page);
    say(common, drawn.heat.is_empty()
                    ? concat("note: there are no values to show for ", shown)
                    : concat(shown, ": ", rounded(drawn.heat.lo), " (dark) to ", rounded(drawn.heat.hi), " (bright)"));
  }
  if (drawn.statistics.hits == 0) say(common, "note: the picture is empty; no ray hit anything");
  if (common.verbose) say(common, concat("stored value ranges checked: ", proof_text(drawn.statistics.range_proof)));
  say(common,
      concat(drawn.output.string(), ": ", method_text(plan), " by ", drawn.statistics.machine, " kernels, traced in ",
             rounded(drawn.statistics.wall_s, 3), " s, ", rounded(total, 3), " s in total"));
  say(common, concat("reproduce: ", drawn.reproduce));
}

void explain(const RenderCommand& command, const render::SceneSpec& scene_spec, const render::ResolvedScene& plan) {
  const render::Explanation explanation = render::explain(scene_spec, plan);
  if (command.common.json)
    std::puts(dump(explanation_json(explanation)).c_str());
  else
    for (const std::string& line : lines_of(explanation)) std::puts(line.c_str());
}

}  // namespace rhoray::tools

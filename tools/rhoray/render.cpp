#include "render/render.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <future>

#include "formats/base/bytes.h"
#include "formats/base/trouble.h"
#include "tools/rhoray/accuracy/choice.h"
#include "tools/rhoray/accuracy/self_check.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/method_words.h"
#include "tools/rhoray/pick.h"
#include "tools/rhoray/pictures.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/scene/annotations.h"
#include "tools/rhoray/scene/document.h"
#include "tools/rhoray/scene/explain.h"
#include "tools/rhoray/scene/picture_options.h"
#include "tools/rhoray/scene/picture_words.h"
#include "tools/rhoray/scene/plan.h"
#include "tools/rhoray/scene/schema.h"
#include "tools/rhoray/subcommands.h"
#include "tools/rhoray/version.h"

namespace rhoray::tools {

namespace {

struct RenderCommand {
  CommonOptions common;
  std::filesystem::path input;
  PictureOptions picture;
  std::vector<PixelPlace> picks;
  bool statistics = false;
  bool no_verify = false;
  bool explain = false;
  bool print_scene = false;
  Goal goal;
  SelfCheckOptions self_check;
};

/// Seconds of the stations on the way to a picture.
struct Stations {
  double open_s = 0;
  double trace_s = 0;
  double wait_for_checks_s = 0;
  double write_s = 0;
};

/// @param antialiases  depths and normals are compared
std::uint64_t framebuffer_bytes(const PictureSize& size, render::ChannelSet channels, bool antialiases) {
  if (antialiases) channels |= {.depth = true, .normal = true};
  const std::uint64_t pixel =
      4 * sizeof(float) + (channels.depth ? sizeof(float) : 0) + (channels.normal ? 3 * sizeof(float) : 0) +
      (channels.cell ? sizeof(std::uint64_t) : 0) + (channels.value ? sizeof(double) : 0) +
      (channels.error ? sizeof(float) : 0) + (antialiases ? 2 : 0) +
      sizeof(std::uint32_t) * (std::uint64_t{channels.roots} + channels.iterations + channels.cost);
  return pixel * static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

void require_memory(const RenderCommand& command, const ScenePlan& plan) {
  const std::uint64_t needed =
      framebuffer_bytes({plan.frame.width, plan.frame.height}, plan.frame.channels, plan.frame.antialiasing > 1);
  const std::uint64_t machine = this_machine().memory_bytes, asked = command.common.memory.bytes;
  const std::uint64_t limit = asked != 0 ? asked : machine;
  if (needed > limit)
    throw Error(Trouble::resource, concat("--size: the picture takes ", bytes_text(needed), " of memory; ",
                                          asked != 0 ? "--memory allows " : "this machine has ", bytes_text(limit)));
}

/// Refuses with the damaged blocks' names.
void refuse_damage(const formats::PackedFile& file, const std::vector<formats::DamagedBlock>& blocks) {
  if (blocks.empty()) return;
  constexpr std::size_t shown_count = 4;
  std::string fact = file.name() + ":";
  for (std::size_t i = 0; i < std::min(shown_count, blocks.size()); ++i)
    fact += concat(i == 0 ? " " : "; ", damage_text(file, blocks[i]));
  if (blocks.size() > shown_count) fact += concat("; and ", blocks.size() - shown_count, " blocks more");
  throw Error(Trouble::invalid, fact,
              concat("no picture was written; `rhoray verify ", file.name(), "` lists all blocks"));
}

Json camera_json(const render::Camera& camera) {
  Json json{{"position", json_of(camera.position)}, {"target", json_of(camera.target)}, {"up", json_of(camera.up)}};
  if (camera.orthographic)
    json["orthographic_height"] = camera.orthographic_height;
  else
    json["vertical_fov_deg"] = camera.vertical_fov_deg;
  return json;
}

Json statistics_json(const render::FrameStatistics& statistics) {
  const render::FrameStatistics::Phases& phases = statistics.phases;
  return {{"rays", statistics.rays},
          {"rays_ruled_out", statistics.rays_ruled_out},
          {"rays_clipped", statistics.rays_clipped},
          {"rays_clipped_away", statistics.rays_clipped_away},
          {"rays_through", statistics.rays_through},
          {"shadow_rays", statistics.shadow_rays},
          {"occlusion_rays", statistics.occlusion_rays},
          {"slice_lookups", statistics.slice_lookups},
          {"edge_pixels", statistics.edge_pixels},
          {"edge_samples", statistics.edge_samples},
          {"hits", statistics.hits},
          {"macrocells_visited", statistics.macrocells_visited},
          {"cells_visited", statistics.cells_visited},
          {"cells_solved", statistics.cells_solved},
          {"samples_taken", statistics.samples_taken},
          {"rays_redone_in_double", statistics.rays_redone},
          {"rays_judged_exactly", statistics.rays_judged},
          {"touches", statistics.touches},
          {"largest_error", statistics.largest_error},
          {"highlights_shaded", statistics.highlights_shaded},
          {"normals_smoothed", statistics.normals_smoothed},
          {"colors_looked_up", statistics.colors_looked_up},
          {"texture_lookups", statistics.texture_lookups},
          {"machine", statistics.machine},
          {"preparation_s", statistics.preparation_s},
          {"wall_s", statistics.wall_s},
          {"phases_cpu_s",
           {{"traversal", phases.traversal}, {"intersection", phases.intersection}, {"shading", phases.shading}}}};
}

std::string statistics_text(const render::FrameStatistics& statistics) {
  const auto count = [](const char* name, std::uint64_t number) {
    return concat("  ", name, std::string(22 - std::string_view(name).size(), ' '), grouped(number), "\n");
  };
  const render::FrameStatistics::Phases& phases = statistics.phases;
  const double all = phases.traversal + phases.intersection + phases.shading;
  const auto phase = [&](const char* name, double seconds) {
    return concat("  ", name, std::string(22 - std::string_view(name).size(), ' '), rounded(seconds, 3), " s of CPU, ",
                  rounded(all > 0 ? 100 * seconds / all : 0, 3), " %\n");
  };
  return count("rays", statistics.rays) + count("ruled out", statistics.rays_ruled_out) +
         count("clipped", statistics.rays_clipped) + count("clipped away", statistics.rays_clipped_away) +
         count("through surfaces", statistics.rays_through) + count("shadow rays", statistics.shadow_rays) +
         count("occlusion rays", statistics.occlusion_rays) + count("slice lookups", statistics.slice_lookups) +
         count("pixels at edges", statistics.edge_pixels) + count("samples at edges", statistics.edge_samples) +
         count("hits", statistics.hits) + count("macrocells visited", statistics.macrocells_visited) +
         count("cells visited", statistics.cells_visited) + count("cells solved", statistics.cells_solved) +
         count("samples taken", statistics.samples_taken) + count("rays redone in double", statistics.rays_redone) +
         count("rays judged exactly", statistics.rays_judged) + count("touches", statistics.touches) +
         (std::isnan(statistics.largest_error)
              ? std::string()
              : concat("  largest error         ", rounded(statistics.largest_error), "\n")) +
         count("highlights shaded", statistics.highlights_shaded) +
         count("normals smoothed", statistics.normals_smoothed) +
         count("colours looked up", statistics.colors_looked_up) +
         count("texture lookups", statistics.texture_lookups) + phase("traversal", phases.traversal) +
         phase("intersection", phases.intersection) + phase("shading", phases.shading) +
         concat("  prepared in          ", rounded(statistics.preparation_s, 3), " s\n") +
         concat("  traced in            ", rounded(statistics.wall_s, 3), " s\n");
}

/// The words of the layers' methods, each once.
std::string method_text(const ScenePlan& plan) {
  std::vector<std::string> words;
  for (const render::Layer& layer : plan.scene.layers) {
    const std::string word = option_of(layer.method, layer.mode, plan.volumes[layer.volume].is_mesh()).word;
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  std::string text;
  for (const std::string& word : words) text += concat(text.empty() ? "" : ", ", word);
  return text;
}

/// What is shown of a scene of one layer.
Json shown_json(const ScenePlan& plan) {
  const render::Layer& layer = plan.scene.layers[0];
  const bool iso = layer.mode == render::Mode::isosurface;
  Json json{{"file", plan.data[layer.volume].file.string()}};
  if (layer.mode == render::Mode::triangles) {
    json["mode"] = "triangles";
    return json;
  }
  json["field"] = plan.data[layer.volume].field;
  json["mode"] = iso ? "iso" : layer.mode == render::Mode::slice ? "slice" : "mip";
  if (iso) {
    json["isovalue"] = layer.isovalue;
    json["isovalue_from"] = plan.origins[0].isovalue_from;
  } else {
    json["range"] = json_of(layer.mode == render::Mode::slice ? layer.surface.color_by->range : layer.window);
  }
  return json;
}

/// Where picks and pictures of what was traced are kept.
struct Drawn {
  std::filesystem::path output;
  ScenePlan plan;
  render::FrameStatistics statistics;
  Stations stations;
  std::vector<Json> picks;
  Interval<double> heat;
  std::string reproduce;
  std::vector<Choice> choices;
  std::optional<SelfCheck> self_check;
};

void report_json(const Drawn& drawn) {
  const ScenePlan& plan = drawn.plan;
  const Stations& stations = drawn.stations;
  Json json{{"picture", drawn.output.string()}};
  if (plan.scene.layers.size() == 1) json.update(shown_json(plan));
  json["method"] = method_text(plan);
  json["size"] = {plan.frame.width, plan.frame.height};
  json["camera"] = camera_json(plan.scene.camera);
  json["scene"] = scene_json(spelled_out(plan));
  json["statistics"] = statistics_json(drawn.statistics);
  json["seconds"] = {{"open", stations.open_s},
                     {"trace", stations.trace_s},
                     {"wait_for_checks", stations.wait_for_checks_s},
                     {"write", stations.write_s}};
  if (!drawn.picks.empty()) json["picks"] = drawn.picks;
  if (drawn.self_check) json["verify"] = json_of(*drawn.self_check);
  json["reproduce"] = drawn.reproduce;
  std::puts(dump(json).c_str());
}

void say_choices(const CommonOptions& common, const ScenePlan& plan) {
  for (const std::string& note : plan.notes) say(common, concat("note: ", note));
  for (std::size_t i = 0; i < plan.origins.size(); ++i) {
    const std::string& from = plan.origins[i].isovalue_from;
    const render::Layer& layer = plan.scene.layers[i];
    if (!from.empty() && from != "given")
      say(common, concat("isovalue ", layer.isovalue, " (", from, " of field '",
                         plan.volumes[layer.volume].field().name, "')"));
  }
}

void report(const RenderCommand& command, const Drawn& drawn) {
  const CommonOptions& common = command.common;
  const ScenePlan& plan = drawn.plan;
  const Stations& stations = drawn.stations;
  const double total = stations.open_s + stations.trace_s + stations.wait_for_checks_s + stations.write_s;
  if (common.json) {
    report_json(drawn);
  } else {
    if (command.statistics)
      std::fputs(concat("  method                ", method_text(plan), "\n  machine               ",
                        drawn.statistics.machine, "\n", statistics_text(drawn.statistics))
                     .c_str(),
                 stdout);
    if (drawn.self_check) std::fputs(text_of(*drawn.self_check).c_str(), stdout);
    for (const Json& pick : drawn.picks) std::puts(picked_text(pick, plan.volumes[0].length_unit()).c_str());
  }
  say_choices(common, plan);
  for (const Choice& choice : drawn.choices) say(common, choice.sentence);
  if (plan.page) {
    const std::string shown = word_of(*plan.page);
    say(common, drawn.heat.is_empty()
                    ? concat("note: nothing to show of ", shown)
                    : concat(shown, ": ", rounded(drawn.heat.lo), " (dark) to ", rounded(drawn.heat.hi), " (bright)"));
  }
  if (drawn.statistics.hits == 0) say(common, "note: the picture is empty: no ray met anything");
  say(common,
      concat(drawn.output.string(), ": ", method_text(plan), " by ", drawn.statistics.machine, " kernels, traced in ",
             rounded(drawn.statistics.wall_s, 3), " s, ", rounded(total, 3), " s in all"));
  say(common, concat("reproduce: ", drawn.reproduce));
}

std::vector<Json> take_picks(const std::vector<PixelPlace>& pixels, const render::Framebuffer& framebuffer) {
  std::vector<Json> picks;
  for (const PixelPlace& pixel : pixels) picks.push_back(picked(framebuffer, pixel));
  return picks;
}

/// What is asked for: a document under the options beside it, or a file and options alone.
SceneWishes wishes_of(const RenderCommand& command) {
  if (!is_scene_document(command.input)) return wishes_of(command.picture, command.input);
  const SceneDocument document = read_scene(command.input);
  for (const std::string& warning : document.warnings) say(command.common, concat("warning: ", warning));
  return with_options(document.wishes, command.picture);
}

std::filesystem::path output_of(const RenderCommand& command, const SceneWishes& wishes) {
  if (!command.common.output.empty()) return command.common.output;
  if (command.input.string() == wishes.document || wishes.document.empty())
    return std::filesystem::path(command.input).replace_extension(".png");
  throw Error(Trouble::usage, "a scene on the command line has no file name; expected -o with the picture's name");
}

/// Of all files of a scene; the first one with damage is refused.
void check_files(const ScenePlan& plan) {
  for (const render::Volume& volume : plan.volumes) refuse_damage(volume.file(), volume.file().damaged_blocks(1));
  for (const render::Texture& texture : plan.textures) refuse_damage(texture.file(), texture.file().damaged_blocks(1));
}

void require_writable(const RenderCommand& command, const std::filesystem::path& output, const ScenePlan& plan) {
  require_writable(command.common, output, command.input);
  for (const auto* data : {&plan.data, &plan.texture_data})
    for (const DataWish& each : *data) require_writable(command.common, output, each.file);
}

bool has_annotations(const ScenePlan& plan) {
  const auto& [axes, box, bar, caption] = plan.annotations;
  return axes || box.value_or(false) || bar || !caption.empty();
}

void draw_annotations(const Drawn& drawn, render::Framebuffer& framebuffer) {
  if (!has_annotations(drawn.plan)) return;
  const std::filesystem::path font = find_font(known_fonts());
  annotate(
      annotations_of(drawn.plan, drawn.heat),
      [&](const std::string& text, int pixels) { return make_text_image(text, pixels, font); }, framebuffer);
}

/// Traces and writes the picture, while the files' checksums are read beside.
void draw(const RenderCommand& command, ProgressDisplay& display, Drawn& drawn) {
  ScenePlan& plan = drawn.plan;
  plan.frame.threads = command.common.threads;
  plan.frame.time_phases = command.statistics;
  // Picks and heat maps need channels that are not kept in the picture.
  const render::ChannelSet kept = plan.frame.channels;
  if (!command.picks.empty()) plan.frame.channels |= {.depth = true, .cell = true, .value = true};
  if (plan.page) plan.frame.channels |= render::channel_of(*plan.page);
  if (plan.annotations.box.value_or(false)) plan.frame.channels |= {.depth = true};
  if (command.self_check.pixels > 0) plan.frame.channels |= channels_to_check(plan);

  // The picture is written only when both are done and well.
  std::future<void> checks;
  if (!command.no_verify) checks = std::async(std::launch::async, [&plan] { check_files(plan); });
  display.show("tracing");
  render::Framebuffer framebuffer;
  const Stopwatch tracing;
  drawn.statistics = render::render(plan.volumes, plan.scene, plan.frame, framebuffer);
  drawn.stations.trace_s = tracing.seconds();
  drawn.picks = take_picks(command.picks, framebuffer);
  if (command.self_check.pixels > 0) {
    display.show("tracing again");
    drawn.self_check = checked(plan, framebuffer, command.self_check, command.common.threads);
  }
  if (plan.page) drawn.heat = render::draw_heat_map(*plan.page, framebuffer);
  draw_annotations(drawn, framebuffer);
  framebuffer.keep(kept);
  plan.frame.channels = kept;
  const Stopwatch waiting;
  if (checks.valid()) checks.get();
  drawn.stations.wait_for_checks_s = waiting.seconds();

  display.show(concat("writing ", drawn.output.string()));
  const Stopwatch writing;
  drawn.reproduce = shell_line(reproducing_command(plan, drawn.output));
  const std::filesystem::path folder = std::filesystem::absolute(drawn.output).parent_path();
  write_picture(framebuffer,
                {{"Software", concat("rhoray ", version())},
                 {"rhoray:command", drawn.reproduce},
                 {"rhoray:scene", dump(scene_json(spelled_out(plan), folder))},
                 {"rhoray:machine", std::string(drawn.statistics.machine)}},
                drawn.output, command.common.force);
  drawn.stations.write_s = writing.seconds();
}

/// What choosing a method, and tracing again, cannot go together with.
void check(RenderCommand& command, const SceneWishes& wishes) {
  check(command.goal);
  command.self_check.max_error = command.goal.max_error;
  const bool names_method =
      !command.picture.wishes.accuracy.empty() || !command.picture.wishes.layers[0].method.empty();
  if (command.goal.is_given() && names_method)
    throw Error(Trouble::usage, "--max-error and --budget-ms choose the method: leave --accuracy and --method out");
  if (command.goal.is_given() && wishes.image.show.value_or("color") == "error")
    throw Error(Trouble::usage, "--show error needs --accuracy certified or exact, and --max-error chooses the method");
}

int run(RenderCommand& command) {
  const SceneWishes wishes = wishes_of(command);
  check(command, wishes);
  ProgressDisplay display(command.common);
  Drawn drawn;
  const bool draws = !command.explain && !command.print_scene;
  if (draws) {
    drawn.output = output_of(command, wishes);
    require_picture_format(drawn.output, channel_set(wishes.image.channels.value_or(std::vector<std::string>{})));
  }
  display.show(concat("opening ", wishes.data[0].file.string()));
  const Stopwatch opening;
  drawn.plan = plan_layers(wishes);
  if (command.explain) {
    aim_camera(wishes, drawn.plan);
    display.clear();
    const Json explanation = explained(wishes, drawn.plan);
    if (command.common.json)
      std::puts(dump(explanation).c_str());
    else
      for (const std::string& line : explained_lines(explanation)) std::puts(line.c_str());
    return 0;
  }
  if (draws) {
    require_writable(command, drawn.output, drawn.plan);
    require_memory(command, drawn.plan);
    if (has_annotations(drawn.plan)) find_font(known_fonts());
    if (command.self_check.pixels > 0) require_checkable(drawn.plan);
  }
  drawn.stations.open_s = opening.seconds();
  aim_camera(wishes, drawn.plan);
  if (draws && command.goal.is_given()) {
    display.show("trying methods");
    drawn.choices = choose_methods(drawn.plan, command.goal, command.common.threads);
  }
  if (draws) draw(command, display, drawn);
  display.clear();
  if (draws)
    report(command, drawn);
  else
    std::fputs(dump_lines(scene_json(spelled_out(drawn.plan))).c_str(), stdout);
  if (drawn.self_check && !drawn.self_check->broken.empty())
    throw Error(Trouble::outside_limit,
                concat(drawn.output.string(), ": outside the limit: ", drawn.self_check->broken));
  return 0;
}

}  // namespace

Subcommand render_subcommand() {
  const auto command = std::make_shared<RenderCommand>();
  return {
      .name = "render",
      .summary = "Packed file or scene to a picture: isosurfaces, maximum intensity projection, surfaces",
      .examples =
          "  rhoray render head.rho -o head.png\n"
          "  rhoray render head.rho --iso 500 --view -y --size 1080p -o skin.png\n"
          "  rhoray render heart.rho --iso 0.3 --normals smooth --color-by pressure --colormap coolwarm -o heart.png\n"
          "  rhoray render head.rho --mode mip --range 0,2000 -o mip.exr --channels depth,value\n"
          "  rhoray render head.rho --slice z=40 --slice y --colormap gray --range -200,400 -o planes.png\n"
          "  rhoray render head.rho --iso 500 --clip-plane 0,0,40,0,0,-1 --slice z=40 --colormap gray -o open.png\n"
          "  rhoray render lungs.rho --normals smooth -o lungs.png\n"
          "  rhoray render head.rho --iso 500 --texture photographs.rho -o skin.png\n"
          "  rhoray render smoke.vdb --iso 0.5 -o smoke.png\n"
          "  rhoray render torso.json --size 4k -o torso.png\n",
      .options = all_options(
          {{file_option("FILE", "Packed file, OpenVDB file (.vdb), or scene document (.json)", command->input)},
           output_options(command->common, "Picture: .png, .exr, .tif or .jpg; default the file's name with .png"),
           picture_options(command->picture),
           goal_options(command->goal),
           {value_option("--pick", "X,Y", "Say which cell a pixel shows; several: X,Y:X,Y", command->picks),
            flag_option("--stats", "What was traced: rays, cells, seconds by phase, on stdout", command->statistics),
            flag_option("--explain", "Say what the scene calls for, what not, and why; render nothing",
                        command->explain),
            flag_option("--print-scene", "Print the scene as a document, every choice spelled out; render nothing",
                        command->print_scene),
            answer_option("--scene-help", "Print what may stand in a scene document", scene_reference),
            answer_option("--scene-schema", "Print the JSON Schema of scene documents", scene_schema_text),
            value_option(
                "--verify", "N",
                "Trace N random pixels, and N where the picture's content ends, again by exact arithmetic, and "
                "say what was found; exit code 6 where the method's promise does not hold",
                command->self_check.pixels),
            value_option("--verify-seed", "N", "Of the random numbers that choose these pixels; default 1",
                         command->self_check.seed),
            flag_option("--no-verify", "Do not check the file's checksums beside the rendering", command->no_verify)},
           threads_option(command->common),
           memory_option(command->common, "Refuse a picture that takes more; default what the machine has"),
           message_options(command->common, "Choices, statistics and times, as one JSON document on stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

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
#include "tools/rhoray/scene/sweep.h"
#include "tools/rhoray/statistics_words.h"
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
  std::optional<int> frame;  ///< the only one to be drawn
  std::optional<int> sheet;  ///< how many frames stand in a row of one picture of all
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

/// Checksums of all files, read beside the rendering.
class Checks {
 public:
  Checks(const RenderCommand& command, const ScenePlan& plan) {
    if (!command.no_verify) running_ = std::async(std::launch::async, [&plan] { check_files(plan); });
  }

  /// @return  seconds
  double wait() {
    const Stopwatch waiting;
    if (running_.valid()) running_.get();
    return waiting.seconds();
  }

 private:
  std::future<void> running_;
};

/// Traces the picture and draws over it.
render::Framebuffer trace(const RenderCommand& command, render::FrameMemory& memory, Drawn& drawn) {
  ScenePlan& plan = drawn.plan;
  plan.frame.threads = command.common.threads;
  plan.frame.time_phases = command.statistics;
  // Picks and heat maps need channels that are not kept in the picture.
  const render::ChannelSet kept = plan.frame.channels;
  if (!command.picks.empty()) plan.frame.channels |= {.depth = true, .cell = true, .value = true};
  if (plan.page) plan.frame.channels |= render::channel_of(*plan.page);
  if (plan.annotations.box.value_or(false)) plan.frame.channels |= {.depth = true};
  if (command.self_check.pixels > 0) plan.frame.channels |= channels_to_check(plan);

  render::Framebuffer framebuffer;
  const Stopwatch tracing;
  drawn.statistics = render::render(plan.volumes, plan.scene, plan.frame, framebuffer, memory);
  drawn.stations.trace_s = tracing.seconds();
  drawn.picks = take_picks(command.picks, framebuffer);
  if (command.self_check.pixels > 0)
    drawn.self_check = checked(plan, framebuffer, command.self_check, command.common.threads);
  if (plan.page) drawn.heat = render::draw_heat_map(*plan.page, framebuffer);
  draw_annotations(drawn, framebuffer);
  framebuffer.keep(kept);
  plan.frame.channels = kept;
  return framebuffer;
}

/// Writes a picture with all that makes it again.
void write(const RenderCommand& command, const render::Framebuffer& picture, const SceneWishes& scene, Drawn& drawn) {
  const Stopwatch writing;
  const std::filesystem::path folder = std::filesystem::absolute(drawn.output).parent_path();
  write_picture(picture,
                {{"Software", concat("rhoray ", version())},
                 {"rhoray:command", drawn.reproduce},
                 {"rhoray:scene", dump(scene_json(scene, folder))},
                 {"rhoray:machine", std::string(drawn.statistics.machine)}},
                drawn.output, command.common.force);
  drawn.stations.write_s = writing.seconds();
}

/// What choosing a method, and tracing again, cannot go together with.
void check(RenderCommand& command, const SceneWishes& wishes) {
  check(command.goal);
  check(command.self_check);
  if (!command.self_check.limit) command.self_check.limit = command.goal.max_error;
  const bool names_method =
      !command.picture.wishes.accuracy.empty() || !command.picture.wishes.layers[0].method.empty();
  if (command.goal.is_given() && names_method)
    throw Error(Trouble::usage, "--max-error and --budget-ms choose the method: leave --accuracy and --method out");
  if (command.goal.is_given() && wishes.image.show.value_or("color") == "error")
    throw Error(Trouble::usage, "--show error needs --accuracy certified or exact, and --max-error chooses the method");
}

/// Traces the picture, and writes it when the files are known to be well.
void draw(const RenderCommand& command, render::FrameMemory& memory, Checks& checks, Drawn& drawn) {
  const render::Framebuffer picture = trace(command, memory, drawn);
  drawn.stations.wait_for_checks_s = checks.wait();
  drawn.reproduce = shell_line(reproducing_command(drawn.plan, drawn.output));
  write(command, picture, spelled_out(drawn.plan), drawn);
}

/// What is refused before anything is traced.
void require_picture(const RenderCommand& command, const std::filesystem::path& output, const ScenePlan& plan) {
  require_writable(command, output, plan);
  require_memory(command, plan);
  if (has_annotations(plan)) find_font(known_fonts());
  if (command.self_check.pixels > 0) require_checkable(plan);
}

/// The names of a sweep's pictures, by frame.
std::filesystem::path frame_name(const RenderCommand& command, int frame) {
  const std::filesystem::path& pattern = command.common.output;
  if (const auto name = numbered(pattern, frame)) return *name;
  if (command.frame && pattern.filename().string().find('%') == std::string::npos && !pattern.empty()) return pattern;
  throw Error(Trouble::usage,
              concat("-o: found '", pattern.string(), "'; expected a name with a place for the frame's number"),
              "such as out_%04d.png");
}

struct DrawnFrame {
  int frame;
  double time;
  std::optional<double> isovalue;  ///< of a scene of one isosurface
  std::filesystem::path picture;
  render::FrameStatistics statistics;
  double write_s;
  std::string reproduce;
};

DrawnFrame drawn_frame(int frame, const Sweep& sweep, const Drawn& drawn) {
  DrawnFrame of{frame,          sweep.time_of(frame), {}, drawn.output, drawn.statistics, drawn.stations.write_s,
                drawn.reproduce};
  const std::vector<render::Layer>& layers = drawn.plan.scene.layers;
  if (layers.size() == 1 && layers[0].mode == render::Mode::isosurface) of.isovalue = layers[0].isovalue;
  return of;
}

Json json_of(const DrawnFrame& frame) {
  Json json{{"frame", frame.frame}, {"time", frame.time}, {"picture", frame.picture.string()}};
  if (frame.isovalue) json["isovalue"] = *frame.isovalue;
  json["statistics"] = statistics_json(frame.statistics);
  json["seconds"] = {{"trace", frame.statistics.wall_s},
                     {"of_it_preparation", frame.statistics.preparation_s},
                     {"write", frame.write_s}};
  json["reproduce"] = frame.reproduce;
  return json;
}

void report_frames(const RenderCommand& command, const ScenePlan& plan, const std::vector<DrawnFrame>& frames) {
  double traced_s = 0, preparation_s = 0;
  for (const DrawnFrame& frame : frames)
    traced_s += frame.statistics.wall_s, preparation_s += frame.statistics.preparation_s;
  const double rate = static_cast<double>(frames.size()) / traced_s;
  if (command.common.json) {
    Json json{{"method", method_text(plan)},
              {"size", {plan.frame.width, plan.frame.height}},
              {"frames_per_second", rate},
              {"frames", Json::array()}};
    for (const DrawnFrame& frame : frames) json["frames"].push_back(json_of(frame));
    std::puts(dump(json).c_str());
  } else if (command.statistics) {
    std::puts("  frame       time   isovalue         rays         hits  prepared s  traced s");
    for (const DrawnFrame& frame : frames) {
      char line[160];
      std::snprintf(line, sizeof line, "  %5d %10s %10s %12s %12s %11.4f %9.4f", frame.frame,
                    rounded(frame.time).c_str(), frame.isovalue ? rounded(*frame.isovalue).c_str() : "-",
                    grouped(frame.statistics.rays).c_str(), grouped(frame.statistics.hits).c_str(),
                    frame.statistics.preparation_s, frame.statistics.wall_s);
      std::puts(line);
    }
  }
  say_choices(command.common, plan);
  say(command.common,
      concat(frames.front().picture.string(), " to ", frames.back().picture.string(), ": ", frames.size(),
             " frames by ", frames.back().statistics.machine, " kernels, traced in ", rounded(traced_s, 3), " s, ",
             rounded(preparation_s, 3), " s of it preparation: ", rounded(rate, 3), " frames per second"));
}

/// The scene of a plan with its key frames.
SceneWishes spelled_out(const ScenePlan& plan, const SceneWishes& wishes, const Sweep& sweep) {
  SceneWishes spelled = spelled_out(plan);
  spelled.camera = wishes.camera;
  spelled.image.frames = sweep.frame_count();
  return spelled;
}

/// Copies a picture to a place of a sheet, counted from the upper left in rows.
void put_on_sheet(const render::Framebuffer& picture, std::size_t place, int columns, render::Framebuffer& sheet) {
  const int column = static_cast<int>(place) % columns, row = static_cast<int>(place) / columns;
  const auto width = static_cast<std::size_t>(picture.width);
  for (int y = 0; y < picture.height; ++y) {
    const std::size_t to = static_cast<std::size_t>(row * picture.height + y) * static_cast<std::size_t>(sheet.width) +
                           static_cast<std::size_t>(column) * width;
    const float* from = picture.color.data() + 4 * static_cast<std::size_t>(y) * width;
    std::copy_n(from, 4 * width, sheet.color.data() + 4 * to);
  }
}

/// A picture of all frames, empty places in the background's colour.
render::Framebuffer empty_sheet(const ScenePlan& plan, int columns, int frame_count) {
  const int rows = (frame_count + columns - 1) / columns;
  render::Framebuffer sheet(plan.frame.width * columns, plan.frame.height * rows, {});
  for (std::size_t c = 0; c < 3; ++c)
    sheet.background[c] = static_cast<float>(plan.scene.background[static_cast<int>(c)]);
  for (std::size_t pixel = 0; pixel < sheet.pixel_count(); ++pixel)
    std::copy_n(sheet.background.data(), 3, sheet.color.data() + 4 * pixel);
  return sheet;
}

/// All frames in one picture.
void draw_sheet(const RenderCommand& command, ProgressDisplay& display, const SceneWishes& wishes, Sweep& sweep,
                ScenePlan plan) {
  Drawn drawn;
  drawn.output = command.common.output;
  drawn.plan = std::move(plan);
  const int columns = *command.sheet, frame_count = sweep.frame_count();
  if (drawn.plan.frame.channels.any())
    throw Error(Trouble::usage, "--sheet: keeps colours alone; expected no --channels beside it");
  ScenePlan& shown = drawn.plan;
  require_picture(command, drawn.output, shown);
  render::Framebuffer sheet = empty_sheet(shown, columns, frame_count);
  Checks checks(command, shown);
  render::FrameMemory memory;
  std::vector<DrawnFrame> frames;
  for (int frame = 0; frame < frame_count; ++frame) {
    display.show("drawing (frames)", static_cast<std::uint64_t>(frame), static_cast<std::uint64_t>(frame_count));
    sweep.plan_frame(frame, shown);
    put_on_sheet(trace(command, memory, drawn), frames.size(), columns, sheet);
    frames.push_back(drawn_frame(frame, sweep, drawn));
  }
  checks.wait();
  const SceneWishes spelled = spelled_out(shown, wishes, sweep);
  drawn.reproduce = shell_line(
      {"rhoray", "render", dump(scene_json(spelled)), "--sheet", concat(columns), "-o", drawn.output.string()});
  write(command, sheet, spelled, drawn);
  display.clear();
  report_frames(command, shown, frames);
  say(command.common, concat("reproduce: ", drawn.reproduce));
}

void draw_frames(const RenderCommand& command, ProgressDisplay& display, Sweep& sweep, ScenePlan plan) {
  const int first = command.frame.value_or(0), end = command.frame ? first + 1 : sweep.frame_count();
  Drawn drawn;
  drawn.plan = std::move(plan);
  const std::vector<std::string> notes = drawn.plan.notes;
  for (int frame = first; frame < end; ++frame) require_picture(command, frame_name(command, frame), drawn.plan);
  Checks checks(command, drawn.plan);
  render::FrameMemory memory;
  std::vector<DrawnFrame> frames;
  for (int frame = first; frame < end; ++frame) {
    display.show("drawing (frames)", static_cast<std::uint64_t>(frame - first),
                 static_cast<std::uint64_t>(end - first));
    drawn.plan.notes = notes;
    sweep.plan_frame(frame, drawn.plan);
    drawn.output = frame_name(command, frame);
    draw(command, memory, checks, drawn);
    frames.push_back(drawn_frame(frame, sweep, drawn));
  }
  display.clear();
  report_frames(command, drawn.plan, frames);
}

void explain(const RenderCommand& command, const SceneWishes& wishes, const ScenePlan& plan) {
  const Json explanation = explained(wishes, plan);
  if (command.common.json)
    std::puts(dump(explanation).c_str());
  else
    for (const std::string& line : explained_lines(explanation)) std::puts(line.c_str());
}

/// A scene whose camera has key frames.
int run_sweep(const RenderCommand& command, const SceneWishes& wishes) {
  ProgressDisplay display(command.common);
  Sweep sweep(wishes);
  if (command.frame && (*command.frame < 0 || *command.frame >= sweep.frame_count()))
    throw Error(Trouble::usage, concat("--frame: found ", *command.frame, "; expected 0 to ", sweep.frame_count() - 1));
  if (!command.picks.empty()) throw Error(Trouble::usage, "--pick: looks into one picture, not into frames");
  if (command.self_check.pixels > 0) throw Error(Trouble::usage, "--verify: traces one picture again, not frames");
  if (command.goal.is_given())
    throw Error(Trouble::usage, "--max-error and --budget-ms choose a method for one picture, not for frames");
  if (command.frame && command.sheet) throw Error(Trouble::usage, "--sheet: shows all frames, --frame one of them");
  if (command.sheet && !(*command.sheet >= 1 && *command.sheet <= 1000))
    throw Error(Trouble::usage, concat("--sheet: found ", *command.sheet, "; expected 1 to 1000"));
  const int frame = command.frame.value_or(0);
  const bool draws = !command.explain && !command.print_scene;
  if (draws)
    require_picture_format(command.sheet ? command.common.output : frame_name(command, frame),
                           channel_set(wishes.image.channels.value_or(std::vector<std::string>{})));
  display.show(concat("opening ", wishes.data[0].file.string()));
  const SceneWishes of_frame = sweep.wishes_at(sweep.time_of(frame));
  ScenePlan plan = plan_layers(of_frame);
  if (draws && command.sheet) draw_sheet(command, display, wishes, sweep, std::move(plan));
  if (draws && !command.sheet) draw_frames(command, display, sweep, std::move(plan));
  if (draws) return 0;
  sweep.plan_frame(frame, plan);
  display.clear();
  if (command.explain) {
    explain(command, of_frame, plan);
    std::puts(concat("frame ", frame, " of ", sweep.frame_count(), ", at time ", sweep.time_of(frame)).c_str());
    return 0;
  }
  const SceneWishes spelled = command.frame ? spelled_out(plan) : spelled_out(plan, wishes, sweep);
  std::fputs(dump_lines(scene_json(spelled)).c_str(), stdout);
  return 0;
}

int run(RenderCommand& command) {
  const SceneWishes wishes = wishes_of(command);
  check(command, wishes);
  if (wishes.camera.keyframes || wishes.image.frames || command.frame || command.sheet)
    return run_sweep(command, wishes);
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
  if (draws) require_picture(command, drawn.output, drawn.plan);
  drawn.stations.open_s = opening.seconds();
  aim_camera(wishes, drawn.plan);
  if (draws && command.goal.is_given()) {
    display.show("trying methods");
    drawn.choices = choose_methods(drawn.plan, command.goal, command.common.threads);
  }
  if (draws) {
    Checks checks(command, drawn.plan);
    render::FrameMemory memory;
    display.show("tracing");
    draw(command, memory, checks, drawn);
  }
  display.clear();
  if (command.explain)
    explain(command, wishes, drawn.plan);
  else if (draws)
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
          "  rhoray render torso.json --size 4k -o torso.png\n"
          "  rhoray render sweep.json --frames 36 -o sweep_%04d.png\n",
      .options = all_options(
          {{file_option("FILE", "Packed file, OpenVDB file (.vdb), or scene document (.json)", command->input)},
           output_options(command->common, "Picture: .png, .exr, .tif or .jpg; default the file's name with .png"),
           picture_options(command->picture),
           goal_options(command->goal),
           {value_option("--pick", "X,Y", "Say which cell a pixel shows; several: X,Y:X,Y", command->picks),
            value_option("--frame", "K", "Only this one of a scene's frames, from 0", command->frame),
            value_option("--sheet", "COLUMNS", "All of a scene's frames in one picture, so many in a row",
                         command->sheet),
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
            value_option("--verify-limit", "E",
                         "Exit code 6 also where 99 % of the random pixels are not within E: cells along the ray; of a "
                         "projection a share of the field's range",
                         command->self_check.limit),
            value_option("--verify-seed", "N", "Of the random numbers that choose these pixels; default 1",
                         command->self_check.seed),
            flag_option("--no-verify", "Do not check the file's checksums beside the rendering", command->no_verify)},
           threads_option(command->common),
           memory_option(command->common, "Refuse a picture that takes more; default what the machine has"),
           message_options(command->common, "Choices, statistics and times, as one JSON document on stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

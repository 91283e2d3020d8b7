#include "tools/rhoray/render/frames.h"

#include <algorithm>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "render/document.h"
#include "render/scene_words.h"
#include "render/sweep.h"
#include "tools/analysis/format_statistics.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/render/picture.h"
#include "tools/rhoray/render/picture_report.h"

namespace rhoray::tools {

namespace {

/// The names of a sweep's pictures, by frame.
std::filesystem::path frame_name(const RenderCommand& command, int frame) {
  const std::filesystem::path& pattern = command.common.output;
  if (const auto name = render::numbered(pattern, frame)) return *name;
  if (command.frame && pattern.filename().string().find('%') == std::string::npos && !pattern.empty()) return pattern;
  throw Error(ErrorCode::usage, concat("-o: found '", pattern.string(), "'; expected a name with a frame number"),
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

DrawnFrame drawn_frame(int frame, const render::Sweep& sweep, const Drawn& drawn) {
  DrawnFrame of{frame,          sweep.time_of(frame), {}, drawn.output, drawn.statistics, drawn.stations.write_s,
                drawn.reproduce};
  const std::vector<render::Layer>& layers = drawn.plan.scene.layers;
  if (layers.size() == 1 && layers[0].mode == render::Mode::isosurface) of.isovalue = layers[0].isovalue;
  return of;
}

Json frame_json(const DrawnFrame& frame) {
  Json json{{"frame", frame.frame}, {"time", frame.time}, {"picture", frame.picture.string()}};
  if (frame.isovalue) json["isovalue"] = *frame.isovalue;
  json["statistics"] = statistics_json(frame.statistics);
  json["seconds"] = {{"trace", frame.statistics.wall_s},
                     {"of_it_preparation", frame.statistics.preparation_s},
                     {"write", frame.write_s}};
  json["reproduce"] = frame.reproduce;
  return json;
}

void report_frames(const RenderCommand& command, const render::ResolvedScene& plan,
                   const std::vector<DrawnFrame>& frames) {
  double traced_s = 0, preparation_s = 0;
  render::RangeProof range_proof;
  for (const DrawnFrame& frame : frames) {
    traced_s += frame.statistics.wall_s, preparation_s += frame.statistics.preparation_s;
    range_proof += frame.statistics.range_proof;
  }
  const double rate = static_cast<double>(frames.size()) / traced_s;
  if (command.common.json) {
    Json json{{"method", method_text(plan)},
              {"size", {plan.frame.width, plan.frame.height}},
              {"frames_per_second", rate},
              {"range_proof", proof_json(range_proof)},
              {"frames", Json::array()}};
    for (const DrawnFrame& frame : frames) json["frames"].push_back(frame_json(frame));
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
    std::puts(concat("  ranges checked: ", proof_text(range_proof)).c_str());
  }
  say_choices(command.common, plan);
  tell(command.common, concat("stored value ranges checked: ", proof_text(range_proof)));
  say(command.common, concat(frames.front().picture.string(), " to ", frames.back().picture.string(), ": ",
                             counted(frames.size(), "frame", "frames"), " by ", frames.back().statistics.machine,
                             " kernels, traced in ", rounded(traced_s, 3), " s, including ", rounded(preparation_s, 3),
                             " s of preparation: ", rounded(rate, 3), " frames per second"));
}

/// The scene of a plan with its key frames.
render::SceneSpec to_spec(const render::ResolvedScene& plan, const render::SceneSpec& scene_spec,
                          const render::Sweep& sweep) {
  render::SceneSpec spelled = to_spec(plan);
  spelled.camera = scene_spec.camera;
  spelled.image.frames = sweep.frame_count();
  // The plan has those of one frame: lights may move with the camera, and fog begins where it sees
  // the data.
  spelled.effects = scene_spec.effects;
  if (scene_spec.lights) {
    spelled.lights = scene_spec.lights;
    spelled.style = scene_spec.style;
  }
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

/// The size of a picture of all frames.
render::PictureSize sheet_size(const render::ResolvedScene& plan, int columns, int frame_count) {
  constexpr std::int64_t largest_side = 65'536;  // as that of --size
  const std::int64_t rows = (std::int64_t{frame_count} + columns - 1) / columns;
  const std::int64_t width = std::int64_t{plan.frame.width} * columns, height = plan.frame.height * rows;
  if (width > largest_side || height > largest_side)
    throw Error(ErrorCode::usage,
                concat("--sheet: found ", width, "x", height, " pixels; expected sides up to ", largest_side),
                "a smaller --size, fewer --frames or another number of columns");
  return {.width = static_cast<int>(width), .height = static_cast<int>(height)};
}

/// A picture of all frames, empty places in the background's colour.
render::Framebuffer empty_sheet(const render::ResolvedScene& plan, const render::PictureSize& size) {
  render::Framebuffer sheet(size.width, size.height, {});
  sheet.is_transparent = plan.scene.transparent_background;
  for (std::size_t c = 0; c < 3; ++c)
    sheet.background[c] = sheet.is_transparent ? 0 : static_cast<float>(plan.scene.background[static_cast<int>(c)]);
  for (std::size_t pixel = 0; pixel < sheet.pixel_count(); ++pixel)
    std::copy_n(sheet.background.data(), 3, sheet.color.data() + 4 * pixel);
  return sheet;
}

/// Draws all frames in one picture.
void draw_sheet(const RenderCommand& command, ProgressDisplay& display, const render::SceneSpec& scene_spec,
                render::Sweep& sweep, render::ResolvedScene plan, const DataAccess& access) {
  Drawn drawn;
  drawn.output = command.common.output;
  drawn.plan = std::move(plan);
  const int columns = *command.sheet, frame_count = sweep.frame_count();
  if (drawn.plan.frame.channels.any()) throw Error(ErrorCode::usage, "--sheet and --channels are mutually exclusive");
  render::ResolvedScene& shown = drawn.plan;
  const render::PictureSize size = sheet_size(shown, columns, frame_count);
  require_picture(command, drawn.output, shown, access, size);
  render::Framebuffer sheet = empty_sheet(shown, size);
  Checks checks(command, shown);
  render::RenderContext memory;
  std::vector<DrawnFrame> frames;
  for (int frame = 0; frame < frame_count; ++frame) {
    display.show("drawing (frames)", static_cast<std::uint64_t>(frame), static_cast<std::uint64_t>(frame_count));
    sweep.plan_frame(frame, shown);
    put_on_sheet(trace(command, memory, drawn), frames.size(), columns, sheet);
    frames.push_back(drawn_frame(frame, sweep, drawn));
  }
  checks.wait();
  const render::SceneSpec spelled = to_spec(shown, scene_spec, sweep);
  drawn.reproduce = shell_line(
      {"rhoray", "render", render::scene_text(spelled), "--sheet", concat(columns), "-o", drawn.output.string()});
  write(command, sheet, spelled, drawn);
  display.clear();
  report_frames(command, shown, frames);
  say(command.common, concat("reproduce: ", drawn.reproduce));
}

void draw_frames(const RenderCommand& command, ProgressDisplay& display, render::Sweep& sweep,
                 render::ResolvedScene plan, const DataAccess& access) {
  const int first = command.frame.value_or(0), end = command.frame ? first + 1 : sweep.frame_count();
  Drawn drawn;
  drawn.plan = std::move(plan);
  const std::vector<std::string> notes = drawn.plan.notes;
  for (int frame = first; frame < end; ++frame)
    require_picture(command, frame_name(command, frame), drawn.plan, access);
  Checks checks(command, drawn.plan);
  render::RenderContext memory;
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

}  // namespace

void run_frames(const RenderCommand& command, const render::SceneSpec& scene_spec) {
  ProgressDisplay display(command.common);
  render::Sweep sweep(scene_spec);
  if (command.frame && (*command.frame < 0 || *command.frame >= sweep.frame_count()))
    throw Error(ErrorCode::usage,
                concat("--frame: found ", *command.frame, "; expected 0 to ", sweep.frame_count() - 1));
  if (!command.picks.empty()) throw Error(ErrorCode::usage, "--pick: works on one picture, not on frames");
  if (command.self_check.pixels > 0) throw Error(ErrorCode::usage, "--verify: works on one picture, not on frames");
  if (command.goal.is_given())
    throw Error(ErrorCode::usage, "--max-error and --budget-ms choose a method for one picture, not for frames");
  if (command.frame && command.sheet) throw Error(ErrorCode::usage, "--sheet and --frame are mutually exclusive");
  if (command.sheet && !(*command.sheet >= 1 && *command.sheet <= 1000))
    throw Error(ErrorCode::usage, concat("--sheet: found ", *command.sheet, "; expected 1 to 1000"));
  const int frame = command.frame.value_or(0);
  const bool draws = !command.explain && !command.print_scene;
  if (draws)
    require_picture_format(command.sheet ? command.common.output : frame_name(command, frame),
                           render::channel_set(scene_spec.image.channels.value_or(std::vector<std::string>{})),
                           keeps_alpha(scene_spec));
  display.show(concat("opening ", scene_spec.data[0].file.string()));
  const render::SceneSpec of_frame = sweep.spec_at(sweep.time_of(frame));
  const DataAccess access = access_for(command.common, display);
  render::ResolvedScene plan = resolve_layers(of_frame, access);
  settle_annotations(of_frame, command.common.output, plan);
  if (draws && command.sheet) draw_sheet(command, display, scene_spec, sweep, std::move(plan), access);
  if (draws && !command.sheet) draw_frames(command, display, sweep, std::move(plan), access);
  if (draws) return;
  sweep.plan_frame(frame, plan);
  display.clear();
  if (command.explain) {
    explain(command, of_frame, plan);
    std::puts(concat("frame ", frame, " of ", sweep.frame_count(), ", at time ", sweep.time_of(frame)).c_str());
    return;
  }
  const render::SceneSpec spelled = command.frame ? to_spec(plan) : to_spec(plan, scene_spec, sweep);
  std::fputs(dump_lines(scene_json(spelled)).c_str(), stdout);
}

}  // namespace rhoray::tools

#include "render/render.h"

#include <cmath>
#include <cstdio>
#include <future>

#include "formats/base/bytes.h"
#include "formats/base/trouble.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/method_words.h"
#include "tools/rhoray/pick.h"
#include "tools/rhoray/picture_plan.h"
#include "tools/rhoray/pictures.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/report.h"
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
};

/// Seconds of the stations on the way to a picture.
struct Stations {
  double open_s = 0;
  double trace_s = 0;
  double wait_for_checks_s = 0;
  double write_s = 0;
};

std::uint64_t framebuffer_bytes(const PictureSize& size, const render::ChannelSet& channels) {
  const std::uint64_t pixel =
      4 * sizeof(float) + (channels.depth ? sizeof(float) : 0) + (channels.normal ? 3 * sizeof(float) : 0) +
      (channels.cell ? sizeof(std::uint64_t) : 0) + (channels.value ? sizeof(double) : 0) +
      (channels.error ? sizeof(float) : 0) +
      sizeof(std::uint32_t) * (std::uint64_t{channels.roots} + channels.iterations + channels.cost);
  return pixel * static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

void require_memory(const RenderCommand& command) {
  const std::uint64_t needed = framebuffer_bytes(command.picture.size, channel_set(command.picture.channels));
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
         count("hits", statistics.hits) + count("macrocells visited", statistics.macrocells_visited) +
         count("cells visited", statistics.cells_visited) + count("cells solved", statistics.cells_solved) +
         count("samples taken", statistics.samples_taken) + count("rays redone in double", statistics.rays_redone) +
         count("rays judged exactly", statistics.rays_judged) + count("touches", statistics.touches) +
         (std::isnan(statistics.largest_error)
              ? std::string()
              : concat("  largest error         ", rounded(statistics.largest_error), "\n")) +
         count("highlights shaded", statistics.highlights_shaded) +
         count("normals smoothed", statistics.normals_smoothed) +
         count("colours looked up", statistics.colors_looked_up) + phase("traversal", phases.traversal) +
         phase("intersection", phases.intersection) + phase("shading", phases.shading) +
         concat("  prepared in          ", rounded(statistics.preparation_s, 3), " s\n") +
         concat("  traced in            ", rounded(statistics.wall_s, 3), " s\n");
}

std::string method_text(const PicturePlan& plan, const render::Volume& volume) {
  return option_of(plan.scene.layers[0].method, plan.scene.layers[0].mode, volume.is_mesh()).word;
}

void report(const RenderCommand& command, const std::filesystem::path& output, const render::Volume& volume,
            const PicturePlan& plan, const render::FrameStatistics& statistics, const Stations& stations,
            const std::vector<Json>& picks, const Interval<double>& heat, const std::string& reproduce) {
  const render::Mode mode = plan.scene.layers[0].mode;
  const bool iso = mode == render::Mode::isosurface;
  const double total = stations.open_s + stations.trace_s + stations.wait_for_checks_s + stations.write_s;
  if (command.common.json) {
    Json json{{"picture", output.string()},
              {"file", command.input.string()},
              {"mode", iso                         ? "iso"
                       : mode == render::Mode::mip ? "mip"
                                                   : "triangles"},
              {"method", method_text(plan, volume)},
              {"size", {plan.frame.width, plan.frame.height}},
              {"camera", camera_json(plan.scene.camera)}};
    if (!volume.is_surface()) json["field"] = volume.field().name;
    if (iso) {
      json["isovalue"] = plan.scene.layers[0].isovalue;
      json["isovalue_from"] = plan.isovalue_from;
    } else if (mode == render::Mode::mip) {
      json["range"] = json_of(plan.scene.layers[0].window);
    }
    json["statistics"] = statistics_json(statistics);
    json["seconds"] = {{"open", stations.open_s},
                       {"trace", stations.trace_s},
                       {"wait_for_checks", stations.wait_for_checks_s},
                       {"write", stations.write_s}};
    if (!picks.empty()) json["picks"] = picks;
    json["reproduce"] = reproduce;
    std::puts(dump(json).c_str());
  } else {
    if (command.statistics)
      std::fputs(concat("  method                ", method_text(plan, volume), "\n  machine               ",
                        statistics.machine, "\n", statistics_text(statistics))
                     .c_str(),
                 stdout);
    for (const Json& pick : picks) std::puts(picked_text(pick, volume.length_unit()).c_str());
  }
  for (const std::string& note : volume.notes()) say(command.common, concat("note: ", note));
  if (iso && plan.isovalue_from != "given")
    say(command.common, concat("isovalue ", plan.scene.layers[0].isovalue, " (", plan.isovalue_from, " of field '",
                               volume.field().name, "')"));
  if (!volume.is_surface() && command.picture.field.empty() && volume.field().name != volume.field_names().front())
    say(command.common, concat("note: field '", volume.field_names().front(), "' is the same everywhere: '",
                               volume.field().name, "' is shown"));
  if (plan.page)
    say(command.common, heat.is_empty() ? concat("note: nothing to show of ", command.picture.show)
                                        : concat(command.picture.show, ": ", rounded(heat.lo), " (dark) to ",
                                                 rounded(heat.hi), " (bright)"));
  if (statistics.hits == 0) say(command.common, "note: the picture is empty: no ray met anything");
  say(command.common,
      concat(output.string(), ": ", method_text(plan, volume), " by ", statistics.machine, " kernels, traced in ",
             rounded(statistics.wall_s, 3), " s, ", rounded(total, 3), " s in all"));
  say(command.common, concat("reproduce: ", reproduce));
}

std::vector<Json> take_picks(const std::vector<PixelPlace>& pixels, const render::Framebuffer& framebuffer) {
  std::vector<Json> picks;
  for (const PixelPlace& pixel : pixels) picks.push_back(picked(framebuffer, pixel));
  return picks;
}

int run(RenderCommand& command) {
  const std::filesystem::path output = command.common.output.empty()
                                           ? std::filesystem::path(command.input).replace_extension(".png")
                                           : command.common.output;
  require_picture_format(output, channel_set(command.picture.channels));
  Stations stations;
  ProgressDisplay display(command.common);
  display.show(concat("opening ", command.input.string()));
  Stopwatch opening;
  const render::Volume volume = load_shown(command.input, command.picture.field);
  require_writable(command.common, output, command.input);
  require_memory(command);
  stations.open_s = opening.seconds();

  PicturePlan plan = plan_picture(command.picture, volume);
  plan.frame.threads = command.common.threads;
  plan.frame.time_phases = command.statistics;
  // Picks and heat maps need channels that are not kept in the picture.
  const render::ChannelSet kept = plan.frame.channels;
  if (!command.picks.empty()) plan.frame.channels |= {.depth = true, .cell = true, .value = true};
  if (plan.page) plan.frame.channels |= render::channel_of(*plan.page);

  // Checksums are read beside the rendering; the picture is written only when both are done and well.
  std::future<std::vector<formats::DamagedBlock>> checks;
  if (!command.no_verify)
    checks = std::async(std::launch::async, [file = volume.file()] { return file.damaged_blocks(1); });
  display.show("tracing");
  render::Framebuffer framebuffer;
  const Stopwatch tracing;
  const render::FrameStatistics statistics = render::render(volume, plan.scene, plan.frame, framebuffer);
  stations.trace_s = tracing.seconds();
  const std::vector<Json> picks = take_picks(command.picks, framebuffer);
  Interval<double> heat;
  if (plan.page) heat = render::draw_heat_map(*plan.page, framebuffer);
  framebuffer.keep(kept);
  plan.frame.channels = kept;
  const Stopwatch waiting;
  if (checks.valid()) refuse_damage(volume.file(), checks.get());
  stations.wait_for_checks_s = waiting.seconds();

  display.show(concat("writing ", output.string()));
  const Stopwatch writing;
  const std::string reproduce = shell_line(reproducing_command(plan, volume, command.input, output));
  write_picture(framebuffer,
                {{"Software", concat("rhoray ", version())},
                 {"rhoray:command", reproduce},
                 {"rhoray:machine", std::string(statistics.machine)}},
                output, command.common.force);
  stations.write_s = writing.seconds();
  display.clear();
  report(command, output, volume, plan, statistics, stations, picks, heat, reproduce);
  return 0;
}

}  // namespace

Subcommand render_subcommand() {
  const auto command = std::make_shared<RenderCommand>();
  return {
      .name = "render",
      .summary = "Packed file to a picture: isosurface, maximum intensity projection, or a surface by itself",
      .examples =
          "  rhoray render head.rho -o head.png\n"
          "  rhoray render head.rho --iso 500 --view -y --size 1080p -o skin.png\n"
          "  rhoray render heart.rho --iso 0.3 --normals smooth --color-by pressure --colormap coolwarm -o heart.png\n"
          "  rhoray render head.rho --mode mip --range 0,2000 -o mip.exr --channels depth,value\n"
          "  rhoray render lungs.rho --normals smooth -o lungs.png\n"
          "  rhoray render smoke.vdb --iso 0.5 -o smoke.png\n",
      .options = all_options(
          {{file_option("FILE", "Packed file, or OpenVDB file (.vdb)", command->input)},
           output_options(command->common, "Picture: .png, .exr, .tif or .jpg; default the file's name with .png"),
           picture_options(command->picture),
           {value_option("--pick", "X,Y", "Say which cell a pixel shows; several: X,Y:X,Y", command->picks),
            flag_option("--stats", "What was traced: rays, cells, seconds by phase, on stdout", command->statistics),
            flag_option("--no-verify", "Do not check the file's checksums beside the rendering", command->no_verify)},
           threads_option(command->common),
           memory_option(command->common, "Refuse a picture that takes more; default what the machine has"),
           message_options(command->common, "Choices, statistics and times, as one JSON document on stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

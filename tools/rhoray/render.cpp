#include <algorithm>
#include <cstdio>
#include <optional>

#include "formats/base/error.h"
#include "render/document.h"
#include "render/scene_words.h"
#include "tools/analysis/measure.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/accuracy_options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/render/asked_scene.h"
#include "tools/rhoray/render/command.h"
#include "tools/rhoray/render/frames.h"
#include "tools/rhoray/render/label_layers.h"
#include "tools/rhoray/render/picture.h"
#include "tools/rhoray/render/picture_report.h"
#include "tools/rhoray/render/replacements.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

/// Whether an option is about the accuracy of hits, which boundaries do not have.
bool needs_isosurface(const RenderCommand& command) {
  const render::PictureSpec& image = command.picture.scene_spec.image;
  const std::vector<std::string> channels = image.channels.value_or(std::vector<std::string>{});
  return command.goal.is_given() || command.self_check.pixels > 0 || image.show.value_or("color") != "color" ||
         std::find(channels.begin(), channels.end(), "error") != channels.end();
}

/// The requested scene; of files, with what the command's other options need.
render::SceneSpec spec_of(const RenderCommand& command) {
  PictureOptions picture = command.picture;
  if (picture.mode.empty() && needs_isosurface(command)) picture.mode = "iso";
  // Picks and channels tell of the surface, not of what is around it.
  if (!command.picks.empty() || picture.scene_spec.image.channels) {
    std::optional<double>& context = picture.scene_spec.layers[0].context;
    context = context.value_or(0);
  }
  // Only opaque surfaces are checked; several would be transparent by default.
  std::optional<double>& opacity = picture.scene_spec.layers[0].opacity;
  if (command.self_check.pixels > 0 && picture.mode == "iso") opacity = opacity.value_or(1);
  return asked_scene(picture, command.inputs, command.common);
}

/// Whether the picture goes to standard output. Refuses what goes there, too.
bool goes_to_stdout(const RenderCommand& command) {
  if (command.common.output != "-") return false;
  for (const auto& [given, name] : {std::pair{command.common.json, "--json"},
                                    {command.statistics, "--stats"},
                                    {!command.picks.empty(), "--pick"},
                                    {command.self_check.pixels > 0, "--verify"}})
    if (given) throw Error(ErrorCode::usage, concat("-o -: writes the picture to standard output, as ", name, " does"));
  return true;
}

std::filesystem::path output_of(const RenderCommand& command, const render::SceneSpec& scene_spec) {
  if (!command.common.output.empty()) return command.common.output;
  const std::filesystem::path& input = command.inputs.front();
  if (scene_spec.document.empty() || scene_spec.document == input.string()) return default_output(input, ".png");
  throw Error(ErrorCode::usage, "a scene on the command line has no file name; name the picture with -o");
}

/// Refuses options that conflict with choosing a method or with --verify.
void check(RenderCommand& command, const render::SceneSpec& scene_spec) {
  if (command.goal.is_given()) require_valid(command.goal);
  if (command.self_check.limit) require_valid(command.self_check);
  if (!command.self_check.limit) command.self_check.limit = command.goal.max_error;
  const bool names_method =
      !command.picture.scene_spec.accuracy.empty() || !command.picture.scene_spec.layers[0].method.empty();
  if (command.goal.is_given() && names_method)
    throw Error(ErrorCode::usage, "--max-error and --budget-ms choose the method; do not give --accuracy or --method");
  if (command.goal.is_given() && scene_spec.image.show.value_or("color") == "error")
    throw Error(ErrorCode::usage,
                "--show error needs --accuracy certified or exact, and --max-error chooses the method");
}

int run(RenderCommand& command) {
  const render::SceneSpec asked = spec_of(command);
  check(command, asked);
  if (asked.camera.keyframes || asked.image.frames || command.frame || command.sheet) {
    run_frames(command, asked);
    return 0;
  }
  ProgressDisplay display(command.common);
  Drawn drawn;
  const bool draws = !command.explain && !command.print_scene;
  if (draws) {
    drawn.output = output_of(command, asked);
    drawn.to_stdout = goes_to_stdout(command);
    require_picture_format(drawn.to_stdout ? "picture.png" : drawn.output,
                           render::channel_set(asked.image.channels.value_or(std::vector<std::string>{})),
                           keeps_alpha(asked));
  }
  display.show(concat("opening ", asked.data[0].file.string()));
  const DataAccess access = access_for(command.common, display);
  const Stopwatch opening;
  const render::SceneSpec scene_spec = with_label_layers(asked, access);
  drawn.plan = resolve_layers(scene_spec, access);
  settle_annotations(scene_spec, drawn.output, drawn.plan);
  if (draws) require_picture(command, drawn.output, drawn.plan, access);
  drawn.stations.open_s = opening.seconds();
  const Progress progress = display.progress();
  aim_camera(scene_spec, drawn.plan, {{}, progress});
  if (draws && (command.goal.is_given() || command.self_check.pixels > 0)) prove_ranges(command, drawn, progress);
  if (draws && command.goal.is_given())
    drawn.choices = choose_methods(drawn.plan, command.goal, command.common.threads, {{}, progress});
  if (draws) {
    Checks checks(command, drawn.plan);
    render::RenderContext memory;
    draw(command, memory, checks, drawn, progress);
  }
  display.clear();
  if (command.explain)
    explain(command, scene_spec, drawn.plan);
  else if (draws)
    report(command, drawn);
  else
    std::fputs(dump_lines(scene_json(to_spec(drawn.plan))).c_str(), stdout);
  if (drawn.self_check && !drawn.self_check->broken.empty())
    throw Error(ErrorCode::outside_limit,
                concat(drawn.output.string(), ": outside the limit: ", drawn.self_check->broken));
  return 0;
}

}  // namespace

Subcommand render_subcommand() {
  const auto command = std::make_shared<RenderCommand>();
  return {
      .name = "render",
      .summary = "Render a picture of any file or scene",
      .group = "Pictures",
      .examples =
          {"rhoray render head.nrrd", "rhoray render head.rho --iso 500 --view -y --size 1080p -o skin.png",
           "rhoray render head.rho --mode mip --range 0,2000 -o mip.png",
           "rhoray render heart.rho --iso 0.3 --normals smooth --color-by pressure --colormap coolwarm -o heart.png",
           "rhoray render head.rho --mode mip --range 0,2000 --channels depth,value -o mip.exr",
           "rhoray render head.rho --slice z=40 --slice y --colormap gray --range -200,400 -o planes.png",
           "rhoray render head.rho --iso 500 --clip-plane 0,0,40,0,0,-1 --slice z=40 --colormap gray -o open.png",
           "rhoray render head.rho --iso 500 --texture photographs.rho -o skin.png",
           "rhoray render smoke.vdb --iso 0.5 -o smoke.png", "rhoray render torso.json --size 4k -o torso.png",
           "rhoray render sweep.json --frames 36 -o sweep_%04d.png"},
      .options = with_replacements(all_options(
          {{
               with_details(
                   files_option("FILE",
                                "Volume, mesh or surface, packed or not; scene document (.json); or picture by rhoray "
                                "(.png, .exr), with its scene",
                                command->inputs),
                   "Files that are not packed are packed first; see `rhoray cache --help`. Further files are "
                   "shown, too; options of the layer are those of the first file"),
           },
           picture_options(command->picture),
           in_group("Input", read_options(command->picture.scene_spec.data[0].read)),
           in_group("Input",
                    {cache_option(command->common),
                     answer_option("--scene-help", "Print the keys of scene documents", render::scene_reference),
                     for_experts(answer_option("--scene-schema", "Print the JSON Schema of scene documents",
                                               render::scene_schema_text)),
                     for_experts(flag_option("--no-verify", "Do not check the file's checksums while rendering",
                                             command->no_verify))}),
           goal_options(command->goal),
           self_check_options(command->self_check),
           in_group(
               "Output",
               all_options(
                   {output_options(
                        command->common,
                        "Picture: .png, .exr, .tif or .jpg; - is a PNG on standard output; default the file's "
                        "name with .png"),
                    image_options(command->picture),
                    {value_option("--frame", "K", "Draw only this frame of a scene, counted from 0", command->frame),
                     value_option("--sheet", "COLUMNS",
                                  "Draw all frames of a scene in one picture with this many columns", command->sheet),
                     with_details(
                         value_option("--pick", "X,Y...",
                                      "Print what a pixel shows: position, cell, value and, if proven, the error",
                                      command->picks),
                         "Several pixels: X,Y:X,Y, or the option again. Between consecutive ones the distance is "
                         "printed, a straight line; its error is that of both positions, proven at certified and "
                         "exact"),
                     flag_option("--stats", "Print statistics of rays, cells and times to stdout", command->statistics),
                     flag_option("--explain", "Print what the scene needs, and why; render nothing", command->explain),
                     flag_option("--print-scene", "Print the complete scene document; render nothing",
                                 command->print_scene)}})),
           in_group("General",
                    all_options({threads_option(command->common),
                                 {memory_option(command->common,
                                                "Refuse pictures that need more memory; default the machine's memory")},
                                 message_options(command->common,
                                                 "Print choices, statistics and times as JSON to stdout")}))})),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

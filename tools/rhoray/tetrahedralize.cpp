#include "preprocess/tetrahedralize.h"

#include <cstdio>

#include "formats/base/trouble.h"
#include "preprocess/import_mesh.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/input_file.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct TetrahedralizeCommand {
  CommonOptions common;
  std::filesystem::path input;
  std::filesystem::path sizes;
  preprocess::TetrahedralizeOptions fill;
  bool no_regions = false;
};

void check(const TetrahedralizeCommand& command, const std::filesystem::path& output) {
  const std::string name = command.input.string();
  require_input(command.input);
  if (preprocess::foreign_kind(command.input) != preprocess::ForeignKind::surface)
    throw Error(
        Trouble::invalid,
        concat(name, ": is not a surface; expected ", preprocess::extensions_of(preprocess::ForeignKind::surface)),
        formats::PackedFile::looks_packed(command.input) ? concat("look into it: rhoray info ", name) : std::string{});
  if (!command.sizes.empty()) require_input(command.sizes);
  if (output.extension() != ".vtu")
    throw Error(Trouble::usage,
                concat(output.string(), ": found extension '", output.extension().string(), "'; expected .vtu"));
  require_writable(command.common, output, command.input);
  if (command.fill.quality != 0) require_within("--quality", command.fill.quality, 1, 100);
  require_within("--max-volume", command.fill.max_volume, 0, 1e300);
  require_within("--time-limit", command.fill.time_limit_s, 1, 1e7);
}

/// The verb knows no file: its refusals get the name here.
preprocess::NeutralMesh fill(const preprocess::NeutralSurface& surface, const TetrahedralizeCommand& command) {
  try {
    return preprocess::tetrahedralize(surface, command.fill);
  } catch (const Error& error) {
    throw Error(error.trouble(), concat(command.input.string(), ": ", error.what()), error.hint());
  }
}

int run(TetrahedralizeCommand& command) {
  const Stopwatch watch;
  const std::filesystem::path output = command.common.output.empty()
                                           ? std::filesystem::path(command.input).replace_extension(".vtu")
                                           : command.common.output;
  check(command, output);
  command.fill.regions = !command.no_regions;
  if (command.common.memory.bytes != 0) command.fill.memory_limit_bytes = command.common.memory.bytes;

  std::vector<std::string> notes;
  preprocess::NeutralMesh mesh;
  {
    ProgressDisplay display(command.common);
    display.show(concat("reading ", command.input.string()));
    const preprocess::NeutralSurface surface =
        preprocess::import_surface(command.input, command.sizes, {.memory_limit_bytes = command.common.memory.bytes});
    display.show("filling with tetrahedra (TetGen)");
    mesh = fill(surface, command);
    notes = surface.notes;
    notes.insert(notes.end(), mesh.notes.begin(), mesh.notes.end());
    display.show(concat("writing ", output.string()));
    preprocess::export_mesh(mesh, output, command.common.force);
  }

  const Usage usage = usage_so_far();
  for (const std::string& note : notes) say(command.common, concat("note: ", note));
  say(command.common, concat(output.string(), ": ", grouped(mesh.cells.size()), " tetrahedra, ",
                             grouped(mesh.points.size()), " points"));
  say(command.common, concat("took ", rounded(watch.seconds(), 3), " s, peak memory ", bytes_text(usage.peak_bytes),
                             ", of a worker ", bytes_text(usage.worker_peak_bytes)));
  if (command.common.json)
    std::puts(dump(Json{{"file", output.string()},
                        {"cells", mesh.cells.size()},
                        {"points", mesh.points.size()},
                        {"seconds", watch.seconds()},
                        {"peak_bytes", usage.peak_bytes},
                        {"worker_peak_bytes", usage.worker_peak_bytes},
                        {"notes", notes}})
                  .c_str());
  return 0;
}

}  // namespace

Subcommand tetrahedralize_subcommand() {
  const auto command = std::make_shared<TetrahedralizeCommand>();
  return {.name = "tetrahedralize",
          .summary = "Closed surfaces to tetrahedra (TetGen, in a process of its own)",
          .examples =
              "  rhoray tetrahedralize heart.ply -o heart.vtu\n"
              "  rhoray tetrahedralize torso.smesh --quality 1.4 --sizes torso.mtr -o torso.vtu\n",
          .options = all_options(
              {{file_option("SURFACE", "Surface: .ply, .stl, .obj, .off, .poly, .smesh, .face or .vtk with POLYDATA",
                            command->input)},
               output_options(command->common, "Mesh (.vtu); default the input's name with .vtu"),
               {value_option("--quality", "R",
                             "Largest ratio of circumradius to shortest edge; 0 adds no points; default 1.4",
                             command->fill.quality),
                value_option("--max-volume", "V", "Largest volume of a tetrahedron; 0, the default, sets no limit",
                             command->fill.max_volume),
                value_option("--sizes", "FILE",
                             "Wanted sizes at the points (.mtr); default the .mtr beside the surface", command->sizes),
                {Option::Kind::flag, "--regions", "", "Number the regions in cell field 'region' (the default)",
                 [command](const std::string&) { command->no_regions = false; }},
                flag_option("--no-regions", "Do not number the regions", command->no_regions),
                value_option("--time-limit", "SECONDS", "CPU time that TetGen may take; default 3600",
                             command->fill.time_limit_s)},
               memory_option(command->common, "Limit for each worker process; default 8G for TetGen"),
               message_options(command->common, "What was made, as one JSON document on stdout")}),
          .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct ImportCommand {
  CommonOptions common;
  std::filesystem::path input;
  std::vector<std::string> fields;
  std::optional<double> max_error;
  std::string time;
};

void check(const ImportCommand& command, const std::filesystem::path& output) {
  const std::string name = command.input.string();
  preprocess::require_input(command.input);
  if (preprocess::foreign_kind(command.input) != preprocess::ForeignKind::mesh)
    throw Error(ErrorCode::unsupported,
                concat(name, ": is not a mesh of volume cells; expected a mesh such as .vtu or .vtk"),
                formats::PackedFile::looks_packed(command.input) ? concat("show its content: rhoray info ", name)
                                                                 : std::string{});
  if (output.extension() != ".vtu")
    throw Error(ErrorCode::usage,
                concat(output.string(), ": found extension '", output.extension().string(), "'; expected .vtu"));
  require_writable(command.common, output, command.input);
}

void report(const ImportCommand& command, const preprocess::NeutralMesh& mesh, const std::filesystem::path& output,
            double seconds) {
  const Usage usage = usage_so_far();
  for (const std::string& note : mesh.notes) say(command.common, concat("note: ", note));
  say(command.common, concat(output.string(), ": ", counted(mesh.cells.size(), "tetrahedron", "tetrahedra"), ", ",
                             counted(mesh.points.size(), "point", "points")));
  say(command.common, concat("took ", rounded(seconds, 3), " s, peak memory ", bytes_text(usage.peak_bytes),
                             ", in a worker ", bytes_text(usage.worker_peak_bytes)));
  if (command.common.json)
    std::puts(dump(Json{{"file", output.string()},
                        {"cells", mesh.cells.size()},
                        {"points", mesh.points.size()},
                        {"seconds", seconds},
                        {"peak_bytes", usage.peak_bytes},
                        {"worker_peak_bytes", usage.worker_peak_bytes},
                        {"notes", mesh.notes}})
                  .c_str());
}

int run(const ImportCommand& command) {
  const Stopwatch watch;
  const std::filesystem::path& output = command.common.output;
  if (output.empty()) throw Error(ErrorCode::usage, "-o: missing; expected a file name ending in .vtu");
  check(command, output);
  const ThreadLimit limit(command.common.threads);
  const preprocess::NeutralMesh mesh = [&] {
    ProgressDisplay display(command.common);
    return preprocess::convert_mesh(
        command.input, output,
        {.fields = command.fields,
         .import = {.time = command.time,
                    .max_error = command.max_error.value_or(preprocess::ImportMeshOptions{}.max_error),
                    .memory_limit_bytes = command.common.memory.bytes,
                    .progress = display.progress()},
         .replace_existing = command.common.force});
  }();
  report(command, mesh, output, watch.seconds());
  return 0;
}

}  // namespace

Subcommand import_subcommand() {
  const auto command = std::make_shared<ImportCommand>();
  return {.name = "import",
          .summary = "Convert a mesh to tetrahedra in a VTU file",
          .group = "Meshes",
          .examples = {"rhoray import can.vtu -o can-tets.vtu",
                       "rhoray import pipe.vtk --field pressure --max-error 0.002 -o pipe.vtu"},
          .options = all_options(
              {{file_option("FILE", "Mesh of volume cells", command->input)},
               output_options(command->common, "Output mesh (.vtu)"),
               {value_option("--field", "A[,B]", "Point or cell fields to keep; default all", command->fields),
                max_error_option(command->max_error), time_option(command->time)},
               threads_option(command->common),
               {worker_memory_option(command->common, "the process that reads the input")},
               message_options(command->common, "Print a JSON summary to stdout")}),
          .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

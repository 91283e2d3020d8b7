#include <algorithm>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "preprocess/import_mesh.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/input_file.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/progress_display.h"
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

/// The cell field that tells where a tetrahedron comes from.
constexpr const char* source_cell = "source_cell";

void check(const ImportCommand& command, const std::filesystem::path& output) {
  const std::string name = command.input.string();
  require_input(command.input);
  if (preprocess::foreign_kind(command.input) != preprocess::ForeignKind::mesh)
    throw Error(ErrorCode::invalid,
                concat(name, ": is not a mesh of volume cells; expected a mesh such as .vtu or .vtk"),
                formats::PackedFile::looks_packed(command.input) ? concat("show its content: rhoray info ", name)
                                                                 : std::string{});
  if (output.extension() != ".vtu")
    throw Error(ErrorCode::usage,
                concat(output.string(), ": found extension '", output.extension().string(), "'; expected .vtu"));
  require_writable(command.common, output, command.input);
}

/// Keeps the requested fields, in the file's order, and reports the others.
void keep_fields(preprocess::NeutralMesh& mesh, const ImportCommand& command) {
  if (command.fields.empty()) return;
  std::vector<std::string> names;
  for (const auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    for (const preprocess::NeutralField& field : *fields) names.push_back(field.name);
  for (const std::string& asked : command.fields)
    if (std::find(names.begin(), names.end(), asked) == names.end())
      throw Error(ErrorCode::usage, concat(command.input.string(), ": no field \"", asked, "\""),
                  did_you_mean(asked, names));
  std::string left_out;
  for (auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    std::erase_if(*fields, [&](const preprocess::NeutralField& field) {
      if (std::find(command.fields.begin(), command.fields.end(), field.name) != command.fields.end()) return false;
      left_out += concat(left_out.empty() ? "" : ", ", "\"", field.name, "\"");
      return true;
    });
  if (!left_out.empty()) mesh.notes.push_back(concat("fields that --field does not name are left out: ", left_out));
}

/// If cells were cut into tetrahedra or left out, each tetrahedron keeps the number of its cell.
void add_source_cells(preprocess::NeutralMesh& mesh) {
  const auto is_named_so = [](const preprocess::NeutralField& field) { return field.name == source_cell; };
  if (mesh.cell_ids.empty() || std::any_of(mesh.cell_fields.begin(), mesh.cell_fields.end(), is_named_so)) return;
  preprocess::NeutralField field;
  field.name = source_cell;
  field.was_single_precision = false;
  field.values.assign(mesh.cell_ids.begin(), mesh.cell_ids.end());
  mesh.cell_fields.push_back(std::move(field));
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
  preprocess::NeutralMesh mesh;
  {
    ProgressDisplay display(command.common);
    display.show(concat("reading ", command.input.string()));
    mesh = preprocess::import_mesh(command.input,
                                   {.time = command.time,
                                    .max_error = command.max_error.value_or(preprocess::ImportMeshOptions{}.max_error),
                                    .error_fields = command.fields,
                                    .memory_limit_bytes = command.common.memory.bytes,
                                    .progress = display.progress()});
    keep_fields(mesh, command);
    add_source_cells(mesh);
    display.show(concat("writing ", output.string()));
    preprocess::export_mesh(mesh, output, command.common.force);
  }
  report(command, mesh, output, watch.seconds());
  return 0;
}

}  // namespace

Subcommand import_subcommand() {
  const auto command = std::make_shared<ImportCommand>();
  return {
      .name = "import",
      .summary = "Convert a mesh to tetrahedra in a VTU file",
      .examples =
          "  rhoray import can.vtu -o can-tets.vtu\n"
          "  rhoray import pipe.vtk --field pressure --max-error 0.002 -o pipe.vtu\n",
      .options = all_options(
          {{file_option("FILE", "Mesh of volume cells", command->input)},
           output_options(command->common, "Output mesh (.vtu)"),
           {value_option("--field", "A[,B]", "Point or cell fields to keep; default all", command->fields),
            max_error_option(command->max_error), value_option("--time", "T", time_help, command->time)},
           threads_option(command->common),
           memory_option(
               command->common,
               "Memory limit of the process that reads the input, such as 2G; default: see Limits in `rhoray --help`"),
           message_options(command->common, "Print a JSON summary to stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

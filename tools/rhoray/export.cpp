#include <algorithm>
#include <cstdio>

#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/number_text.h"
#include "formats/base/regular_file.h"
#include "formats/base/word_list.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/export_grid.h"
#include "preprocess/export_tets.h"
#include "render/isovalue.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/export_formats.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct ExportCommand {
  CommonOptions common;
  std::filesystem::path input;
  render::ReadSpec read;
  std::filesystem::path packed;  ///< the input, or its packed copy
  std::string field;
  std::string isovalue;
};

const ExportFormat& format_of(const std::filesystem::path& output) {
  const std::string extension = output.extension().string();
  for (const ExportFormat& format : export_formats)
    if (extension == format.extension) return format;
  const std::vector<std::string> known = names_in(export_formats, &ExportFormat::extension);
  throw Error(ErrorCode::usage,
              concat(output.string(), ": found extension '", extension, "'; expected one of ", joined(known)),
              did_you_mean(extension, known));
}

/// The summaries of a packed file's fields, at points and in cells, and whether it is a mesh.
struct Content {
  bool is_mesh = false;
  std::vector<formats::FieldSummary> fields, cell_fields{};
};

Content content_in(const ExportCommand& command) {
  // under the name of the input, also if it is its packed copy
  const Descriptor opened(open_regular_file(command.packed));
  const formats::PackedFile file = formats::PackedFile::from_descriptor(opened.number(), command.input.string());
  refuse_damage(file, command.common.threads);
  if (file.description().kind == formats::TriangleMesh::kind)
    throw Error(ErrorCode::unsupported, concat(command.input.string(), ": holds a surface; expected a grid or a mesh"),
                "numpy reads its points and triangles from the packed file: see formats/SPEC.md");
  if (file.description().kind == "tets") {
    const formats::TetMesh mesh(file);
    return {true, mesh.description().fields, mesh.description().cell_fields};
  }
  if (file.description().kind == formats::ColorGrid::kind)
    throw Error(ErrorCode::unsupported, concat(command.input.string(), ": holds colours; expected a grid or a mesh"));
  return {false, formats::BrickGrid(file).description().fields};
}

void check(const ExportCommand& command, const ExportFormat& format, const Content& content) {
  if (!(content.is_mesh ? format.for_tets : format.for_grids))
    throw Error(ErrorCode::unsupported,
                concat(command.input.string(), ": is a ", content.is_mesh ? "mesh" : "grid", ", and ", format.extension,
                       " holds ", content.is_mesh ? "grids" : "meshes"),
                format.other);
  const bool is_stl = std::string_view(format.extension) == ".stl";
  if (!is_stl && !command.isovalue.empty())
    throw Error(ErrorCode::usage, concat("--iso: only for .stl, but the output is ", format.extension));
  if (is_stl && !content.is_mesh && command.isovalue.empty())
    throw Error(ErrorCode::usage, "--iso: missing; an .stl of a grid holds an isosurface",
                "--iso 500, --iso p95 or --iso auto");
  if (content.is_mesh && !is_stl && !command.field.empty())
    throw Error(ErrorCode::usage, concat("--field: not allowed, because ", format.extension, " holds all fields"));
  const auto holds_it = [&](const std::vector<formats::FieldSummary>& fields) {
    return std::any_of(fields.begin(), fields.end(), [&](const auto& field) { return field.name == command.field; });
  };
  if (!holds_it(content.fields) && holds_it(content.cell_fields))
    throw Error(ErrorCode::usage,
                concat(command.input.string(), ": no field '", command.field, "' at points; an .stl needs one"),
                cell_field_hint);
}

std::optional<double> chosen_isovalue(const ExportCommand& command, const Content& content) {
  if (command.isovalue.empty()) return std::nullopt;
  for (const formats::FieldSummary& field : content.fields) {
    if (!command.field.empty() && field.name != command.field) continue;
    const render::Isovalue iso = render::choose_isovalue(command.isovalue, field);
    if (iso.from != "given") say(command.common, render::isovalue_text(iso, field));
    return iso.value;
  }
  throw Error(ErrorCode::usage, concat(command.input.string(), ": no field '", command.field, "'"),
              did_you_mean(command.field, names_in(content.fields, &formats::FieldSummary::name)));
}

preprocess::ExportReport write(const ExportCommand& command, const Content& content,
                               const std::filesystem::path& output, std::optional<double> isovalue) {
  ProgressDisplay display(command.common);
  display.show(concat("writing ", output.string()));
  const preprocess::ExportOptions options{.field = command.field,
                                          .replace_existing = command.common.force,
                                          .memory_limit_bytes = command.common.memory.bytes,
                                          .source_name = command.input.string()};
  const std::string extension = output.extension().string();
  if (extension == ".vti") return preprocess::export_vti(command.packed, output, options, display.progress());
  if (extension == ".npy") return preprocess::export_npy(command.packed, output, options, display.progress());
  if (extension == ".nii") return preprocess::export_nifti(command.packed, output, options, display.progress());
  if (extension == ".vtu") return preprocess::export_vtu(command.packed, output, options);
  if (extension != ".stl") return preprocess::export_vdb(command.packed, output, options);
  if (content.is_mesh) return preprocess::export_tets_stl(command.packed, isovalue, output, options);
  return preprocess::export_grid_stl(command.packed, *isovalue, output, options);
}

int run(ExportCommand& command) {
  const Stopwatch watch;
  const std::filesystem::path output = command.common.output;
  if (output.empty()) throw Error(ErrorCode::usage, "-o: missing; the extension of the output selects the format");
  const ExportFormat& format = format_of(output);
  {
    ProgressDisplay display(command.common);
    const DataAccess access = access_for(command.common, display, command.read);
    command.packed = packed_path(command.input, command.field, access);
    require_not_read(output, access);
  }
  const Content content = content_in(command);
  check(command, format, content);
  require_writable(command.common, output, command.input);
  const std::optional<double> isovalue = chosen_isovalue(command, content);
  const preprocess::ExportReport report = write(command, content, output, isovalue);

  const bool is_stl = std::string_view(format.extension) == ".stl";
  for (const std::string& note : report.notes) say(command.common, concat("note: ", note));
  say(command.common,
      concat(output.string(), ": ", bytes_text(report.file_bytes),
             is_stl ? concat(", ", counted(report.triangle_count, "triangle", "triangles")) : std::string{}, ", took ",
             rounded(watch.seconds(), 3), " s"));
  if (!command.common.json) return 0;
  Json json{{"file", output.string()}, {"source", command.input.string()}, {"file_bytes", report.file_bytes}};
  if (isovalue) json["isovalue"] = *isovalue;
  if (is_stl) json["triangles"] = report.triangle_count;
  json["seconds"] = watch.seconds();
  json["notes"] = report.notes;
  std::puts(dump(json).c_str());
  return 0;
}

}  // namespace

Subcommand export_subcommand() {
  const auto command = std::make_shared<ExportCommand>();
  return {.name = "export",
          .summary = "Convert a file to another format",
          .group = "Files",
          .examples = {"rhoray export head.rho -o head.vti", "rhoray export head.rho --iso 500 -o skin.stl",
                       "rhoray export torso.rho -o torso.vtu", "rhoray export head.rho -o head.nvdb"},
          .options = all_options(
              {{with_details(file_option("FILE", "Packed file, or a file that `rhoray pack` reads", command->input),
                             "numpy can read it without conversion; see formats/SPEC.md")},
               read_options(command->read),
               output_options(command->common,
                              "Output: .vti, .vdb, .nvdb, .npy, .nii or .stl for a grid, .vtu or .stl for a mesh"),
               {value_option("--field", "NAME", "Field to write if the format holds only one; default the first",
                             command->field),
                with_details(value_option("--iso", "V",
                                          concat("Isovalue of an .stl: a number, a percentile (p95) or auto (",
                                                 render::auto_isovalue_words, ")"),
                                          command->isovalue),
                             "Without --iso, the .stl of a mesh is the mesh's own surface"),
                worker_memory_option(command->common, "the process that writes .vdb, .nvdb, or the .stl of a grid")},
               message_options(command->common, "Print a JSON summary to stdout")}),
          .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

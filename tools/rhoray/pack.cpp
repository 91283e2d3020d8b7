#include <cstdio>

#include "formats/base/parallel.h"
#include "preprocess/import_mesh.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/pack_any.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct PackCommand {
  CommonOptions common;
  PackOptions pack;
};

void report(const PackCommand& command, const std::filesystem::path& output, const PackResult& result, double seconds) {
  const Usage usage = usage_so_far();
  const double ratio = static_cast<double>(result.file_bytes) / static_cast<double>(result.raw_bytes);
  for (const std::string& note : result.notes) say(command.common, concat("note: ", note));
  say(command.common, concat(output.string(), ": ", result.content, ", ", bytes_text(result.file_bytes), " (",
                             rounded(ratio, 3), " x raw)"));
  say(command.common,
      concat("took ", rounded(seconds, 3), " s (", rounded(usage.cpu_s, 3), " s of CPU), peak memory ",
             bytes_text(usage.peak_bytes), ", in the reading process ", bytes_text(usage.worker_peak_bytes)));
  if (!command.common.json) return;
  const Json json{{"file", output.string()},
                  {"kind", result.kind},
                  {"file_bytes", result.file_bytes},
                  {"raw_bytes", result.raw_bytes},
                  {"ratio", ratio},
                  {"seconds", seconds},
                  {"cpu_seconds", usage.cpu_s},
                  {"peak_bytes", usage.peak_bytes},
                  {"worker_peak_bytes", usage.worker_peak_bytes},
                  {"notes", result.notes},
                  {"description", result.description}};
  std::puts(dump(json).c_str());
}

std::filesystem::path default_output(const std::filesystem::path& input) {
  std::filesystem::path output = input;
  if (output.extension() == ".gz") output.replace_extension();
  return output.replace_extension(".rho");
}

/// The command line stored in the file.
std::string command_line(const PackCommand& command, const std::filesystem::path& output) {
  const PackOptions& pack = command.pack;
  std::vector<std::string> words{"rhoray", "pack", pack.input.string(), "-o", output.string()};
  const auto add = [&](bool given, const char* name, const std::string& value) {
    if (given) words.insert(words.end(), {name, value});
  };
  const auto numbers = [](const std::optional<Vec3>& v) {
    return v ? concat(v->x, ",", v->y, ",", v->z) : std::string{};
  };
  const PackOptions defaults;
  std::string fields;
  for (const std::string& field : pack.fields) fields += (fields.empty() ? "" : ",") + field;
  add(!pack.raw.empty(), "--raw", pack.raw);
  add(!fields.empty(), "--field", fields);
  add(!pack.structure.empty(), "--structure", pack.structure);
  add(pack.cells != defaults.cells, "--cells", pack.cells);
  add(pack.leaf_ratio.has_value(), "--leaf-ratio", concat(pack.leaf_ratio.value_or(0)));
  add(pack.levels != defaults.levels, "--levels", concat(pack.levels));
  add(pack.factor != defaults.factor, "--factor", concat(pack.factor));
  if (pack.color) words.push_back("--color");
  add(pack.type.has_value(), "--type",
      std::string(formats::element_name(pack.type.value_or(formats::ElementType::U8))));
  add(!pack.layout.empty(), "--layout", pack.layout);
  add(pack.brick_edge.has_value(), "--brick-edge", concat(pack.brick_edge.value_or(0)));
  add(pack.spacing.has_value(), "--spacing", numbers(pack.spacing));
  add(pack.origin.has_value(), "--origin", numbers(pack.origin));
  if (pack.cell_data) words.push_back("--cell-data");
  add(pack.max_error.has_value(), "--max-error", concat(pack.max_error.value_or(0)));
  add(!pack.time.empty(), "--time", pack.time);
  return shell_line(words);
}

int run(PackCommand& command) {
  const Stopwatch watch;
  PackOptions& pack = command.pack;
  pack.memory_limit_bytes = command.common.memory.bytes;
  pack.replace_existing = command.common.force;
  const std::filesystem::path output =
      command.common.output.empty() ? default_output(pack.input) : command.common.output;
  pack.command = command_line(command, output);
  check_pack(pack);
  require_writable(command.common, output, pack.input);
  const ThreadLimit limit(command.common.threads);
  const PackResult result = [&] {
    ProgressDisplay display(command.common);
    return pack_any(pack, output, display.progress());
  }();
  report(command, output, result, watch.seconds());
  return 0;
}

HelpSection file_types() {
  using preprocess::ForeignKind;
  return {.heading = "File types",
          .entries = {{"volumes", preprocess::extensions_of(ForeignKind::volume)},
                      {"meshes", preprocess::extensions_of(ForeignKind::mesh)},
                      {"surfaces", preprocess::extensions_of(ForeignKind::surface)}}};
}

}  // namespace

Subcommand pack_subcommand() {
  const auto command = std::make_shared<PackCommand>();
  PackOptions& pack = command->pack;
  return {
      .name = "pack",
      .summary = "Pack a volume, a mesh or a surface",
      .group = "Files",
      .examples = {"rhoray pack head.nrrd -o head.rho", "rhoray pack torso.vtu --field potential -o torso.rho",
                   "rhoray pack ct.raw --raw 512x512x275:uint16:le --spacing 0.78,0.78,1 -o ct.rho",
                   "rhoray pack heart.stl -o heart.rho",
                   "rhoray pack slices/ --color --spacing 0.33,0.33,1 -o photographs.rho"},
      .sections = {file_types()},
      .options = all_options(
          {in_group("Input",
                    {file_option("FILE", "Volume, mesh or surface", pack.input),
                     value_option("--field", "A[,B]",
                                  "Fields to keep; `render` shows the first; default all of a mesh, the first of a "
                                  "volume",
                                  pack.fields)}),
           in_group("Volumes",
                    {value_option("--raw", "WxHxD:TYPE[:le|be][:SKIP]",
                                  "Read samples without a header, after SKIP bytes", pack.raw),
                     value_option("--spacing", "X,Y,Z", "Replace the file's spacing", pack.spacing),
                     value_option("--origin", "X,Y,Z", "Replace the file's origin", pack.origin),
                     with_details(flag_option("--color", "Keep colours, for use as a texture", pack.color),
                                  "For 8-bit RGB or RGBA volumes: a folder of pictures, .nrrd, .mha or .vti"),
                     value_option("--type", "TYPE",
                                  "Type of the stored samples: U8, I8, U16, I16, U32, I32, F32 or F64", pack.type),
                     for_experts(choice_option(
                         "--layout", {"bricks", "linear", "sparse"},
                         "Order of the samples; sparse keeps only bricks with data; default bricks", pack.layout)),
                     for_experts(value_option("--brick-edge", "N",
                                              "Samples per axis of a brick; default 4, for sparse and colours 8",
                                              pack.brick_edge))}),
           in_group("Meshes",
                    {flag_option("--cell-data", "Also keep cell fields, averaged to points", pack.cell_data),
                     time_option(pack.time), max_error_option(pack.max_error),
                     for_experts(with_details(
                         choice_option("--structure", {"clusters", "leaves"}, "Search structure; default clusters",
                                       pack.structure),
                         "clusters: neighbouring tetrahedra stand together. leaves: leaf lists of a uniform lattice")),
                     for_experts(value_option("--cells", "auto|N",
                                              "Approximate number of leaf cells, for leaves; default auto, one per "
                                              "tetrahedron",
                                              pack.cells)),
                     for_experts(value_option("--leaf-ratio", "R", "Leaf cells per tetrahedron, for leaves; default 1",
                                              pack.leaf_ratio))}),
           for_experts(
               in_group("Macrocells of volumes and leaves",
                        {value_option("--levels", "N", "Levels of macrocells; default 3", pack.levels),
                         value_option("--factor", "N", "Cells per axis of a macrocell; default 4", pack.factor)})),
           in_group("Output", output_options(command->common, "Packed file; default the input's name with .rho")),
           in_group("General", all_options({threads_option(command->common),
                                            {with_details(memory_option(command->common, "Memory cap, such as 512M"),
                                                          "Larger data are streamed through the output's folder")},
                                            message_options(command->common, "Print a JSON summary to stdout")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

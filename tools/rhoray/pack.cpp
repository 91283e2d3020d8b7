#include <cstdio>

#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "formats/base/word_list.h"
#include "preprocess/input_file.h"
#include "preprocess/pack.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct PackCommand {
  CommonOptions common;
  std::filesystem::path input;
  std::string layout, structure, cells = "auto";  ///< as typed; empty when not given
  preprocess::PackOptions pack;
};

void report(const PackCommand& command, const std::filesystem::path& output, const preprocess::PackReport& result,
            double seconds) {
  const Usage usage = usage_so_far();
  const double ratio = static_cast<double>(result.file_bytes) / static_cast<double>(result.raw_bytes);
  for (const std::string& note : result.notes) say(command.common, concat("note: ", note));
  say(command.common, concat(output.string(), ": ", content_of(result), ", ", bytes_text(result.file_bytes)));
  tell(command.common, concat("the packed file is ", rounded(ratio, 3), " times the size of the raw data"));
  say(command.common,
      concat("took ", rounded(seconds, 3), " s (", rounded(usage.cpu_s, 3), " s of CPU), peak memory ",
             bytes_text(usage.peak_bytes), ", in the reading process ", bytes_text(usage.worker_peak_bytes)));
  if (!command.common.json) return;
  const auto [kind, description] =
      std::visit([](const auto& packed) { return std::pair(formats::describe(packed).kind, json_of(packed)); },
                 result.description);
  const Json json{{"file", output.string()},
                  {"kind", kind},
                  {"file_bytes", result.file_bytes},
                  {"raw_bytes", result.raw_bytes},
                  {"ratio", ratio},
                  {"seconds", seconds},
                  {"cpu_seconds", usage.cpu_s},
                  {"peak_bytes", usage.peak_bytes},
                  {"worker_peak_bytes", usage.worker_peak_bytes},
                  {"notes", result.notes},
                  {"description", description}};
  std::puts(dump(json).c_str());
}

/// The command line stored in the file.
std::string command_line(const PackCommand& command, const std::filesystem::path& output) {
  std::vector<std::string> words{"rhoray", "pack", command.input.string(), "-o", output.string()};
  const std::vector<std::string> options = preprocess::option_words(command.pack);
  words.insert(words.end(), options.begin(), options.end());
  return shell_line(words);
}

void read_options(PackCommand& command) {
  using preprocess::MeshStructure, preprocess::SampleOrder;
  preprocess::PackOptions& pack = command.pack;
  if (command.layout == "bricks") pack.layout = SampleOrder::bricks;
  if (command.layout == "linear") pack.layout = SampleOrder::linear;
  if (command.layout == "sparse") pack.layout = SampleOrder::sparse;
  if (command.structure == "clusters") pack.structure = MeshStructure::clusters;
  if (command.structure == "leaves") pack.structure = MeshStructure::leaves;
  if (command.cells != "auto") read_value(command.cells, pack.cells);
}

int run(PackCommand& command) {
  const Stopwatch watch;
  read_options(command);
  preprocess::PackOptions& pack = command.pack;
  pack.memory_limit_bytes = command.common.memory.bytes;
  pack.replace_existing = command.common.force;
  const std::filesystem::path output =
      command.common.output.empty() ? default_output(command.input, ".rho") : command.common.output;
  pack.command = command_line(command, output);
  preprocess::check_pack(command.input, pack);
  require_writable(command.common, output, command.input);
  const ThreadLimit limit(command.common.threads);
  const preprocess::PackReport result = [&] {
    ProgressDisplay display(command.common);
    return preprocess::pack(command.input, output, pack, display.progress());
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
  preprocess::PackOptions& pack = command->pack;
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
                    {file_option("FILE", "Volume, mesh or surface", command->input),
                     value_option("--field", "A[,B]",
                                  "Fields to keep; `render` shows the first; default all of a mesh, the first of a "
                                  "volume",
                                  pack.fields),
                     time_option(pack.time)}),
           in_group(
               "Volumes",
               all_options(
                   {raw_options(pack.raw, pack.spacing, pack.origin),
                    {with_details(
                         flag_option("--color", "Keep colours, for use as a texture", pack.color),
                         "For 8-bit RGB or RGBA volumes: a folder of pictures, .nrrd, .mha, .nii, .npy or .vti"),
                     value_option("--type", "TYPE",
                                  "Type of the stored samples: U8, I8, U16, I16, U32, I32, F32 or F64", pack.type),
                     for_experts(choice_option(
                         "--layout", {"bricks", "linear", "sparse"},
                         "Order of the samples; sparse keeps only bricks with data; default bricks", command->layout)),
                     for_experts(value_option("--brick-edge", "N",
                                              "Samples per axis of a brick; default 4, for sparse and colours 8",
                                              pack.brick_edge))}})),
           in_group("Meshes",
                    {flag_option("--cell-data", "Also keep cell fields, averaged to points", pack.cell_data),
                     max_error_option(pack.max_error),
                     for_experts(with_details(
                         choice_option("--structure", {"clusters", "leaves"}, "Search structure; default clusters",
                                       command->structure),
                         "clusters: neighbouring tetrahedra stand together. leaves: leaf lists of a uniform lattice")),
                     for_experts(value_option("--cells", "auto|N",
                                              "Approximate number of leaf cells, for leaves; default auto, one per "
                                              "tetrahedron",
                                              command->cells)),
                     for_experts(value_option("--leaf-ratio", "R", "Leaf cells per tetrahedron, for leaves; default 1",
                                              pack.leaf_ratio))}),
           for_experts(
               in_group("Macrocells of volumes and leaves",
                        {value_option("--levels", "N", "Levels of macrocells; default 3", pack.levels),
                         value_option("--factor", "N", "Cells per axis of a macrocell; default 4", pack.factor)})),
           in_group("Output", output_options(command->common,
                                             "Packed file; default the input's name with .rho in the working folder")),
           in_group("General", all_options({threads_option(command->common),
                                            {with_details(memory_option(command->common, "Memory cap, such as 512M"),
                                                          "Larger data are streamed through the output's folder")},
                                            message_options(command->common, "Print a JSON summary to stdout")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

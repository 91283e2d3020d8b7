#include <cstdio>

#include "formats/base/number_text.h"
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

/// The files that are read, as lines of the help.
std::string file_types() {
  using preprocess::ForeignKind;
  return concat("Volumes: ", preprocess::extensions_of(ForeignKind::volume),
                "\nMeshes: ", preprocess::extensions_of(ForeignKind::mesh),
                "\nSurfaces: ", preprocess::extensions_of(ForeignKind::surface), "\n");
}

}  // namespace

Subcommand pack_subcommand() {
  const auto command = std::make_shared<PackCommand>();
  PackOptions& pack = command->pack;
  return {
      .name = "pack",
      .summary = "Pack a volume, a mesh or a surface",
      .examples = concat("  rhoray pack head.nrrd -o head.rho\n"
                         "  rhoray pack torso.vtu --field potential -o torso.rho\n"
                         "  rhoray pack heart.stl -o heart.rho\n"
                         "  rhoray pack slices/ --color --spacing 0.33,0.33,1 -o photographs.rho\n"
                         "  rhoray pack ct.raw --raw 512x512x275:uint16:le --spacing 0.78,0.78,1 -o ct.rho\n",
                         file_types()),
      .options = all_options(
          {{file_option("FILE", "Volume, mesh or surface", pack.input)},
           output_options(command->common, "Packed file; default the input's name with .rho"),
           {value_option(
                "--field", "A[,B]",
                "Fields to keep; the first is shown by default; default all fields of a mesh, the first of a volume",
                pack.fields),
            value_option("--raw", "WxHxD:TYPE[:le|be][:SKIP]", "Read samples without a header", pack.raw),
            flag_option("--color",
                        "Keep colours, for use as a texture (8-bit RGB or RGBA volumes: a folder of pictures, .nrrd, "
                        ".mha, .vti)",
                        pack.color),
            value_option("--spacing", "X,Y,Z", "Replace the file's spacing (volumes)", pack.spacing),
            value_option("--origin", "X,Y,Z", "Replace the file's origin (volumes)", pack.origin),
            value_option("--type", "TYPE",
                         "Type of the stored samples (volumes): U8, I8, U16, I16, U32, I32, F32 or F64", pack.type),
            choice_option(
                "--layout", {"bricks", "linear", "sparse"},
                "Order of samples in the file (volumes): bricks (default), linear, or sparse (only bricks with data)",
                pack.layout),
            value_option("--brick-edge", "N", "Samples per axis of a brick (volumes); default 4, sparse 8, colours 8",
                         pack.brick_edge),
            flag_option("--cell-data", "Also keep cell fields, averaged to points (meshes)", pack.cell_data),
            max_error_option(pack.max_error), value_option("--time", "T", time_help, pack.time),
            choice_option("--structure", {"clusters", "leaves"},
                          "Search structure (meshes): clusters of neighbouring tetrahedra (default), or leaf lists of "
                          "a uniform lattice",
                          pack.structure),
            value_option("--cells", "auto|N",
                         "Approximate number of leaf cells (leaves); default auto, one per tetrahedron", pack.cells),
            value_option("--leaf-ratio", "R", "Leaf cells per tetrahedron (leaves); default 1", pack.leaf_ratio),
            value_option("--levels", "N", "Levels of macrocells (volumes, leaves); default 3", pack.levels),
            value_option("--factor", "N", "Cells per axis of a macrocell (volumes, leaves); default 4", pack.factor)},
           threads_option(command->common),
           memory_option(command->common,
                         "Memory cap, such as 512M; larger data are streamed through the output's folder"),
           message_options(command->common, "Print a JSON summary to stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

#include <algorithm>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/parallel.h"
#include "formats/base/pending_file.h"
#include "formats/base/word_list.h"
#include "formats/packed_file.h"
#include "preprocess/input_file.h"
#include "render/document.h"
#include "render/method_words.h"
#include "render/scene_words.h"
#include "tools/rhoray/bench/tables.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

enum class Takes {
  data,           ///< any file that can be rendered
  data_or_scene,  ///< or a scene document
  unpacked        ///< a file that is to be packed
};

struct TableRow {
  const char* name;
  Takes takes;
  std::vector<Table> (*measure)(const BenchOptions&, const Step&);
  std::vector<const char*> also = {};  ///< names of tables that come with it
};

template <Table (*table)(const BenchOptions&, const Step&)>
std::vector<Table> only(const BenchOptions& options, const Step& step) {
  return {table(options, step)};
}

const TableRow table_rows[] = {{"phases", Takes::data, only<phases_table>},
                               {"threads", Takes::data, only<threads_table>},
                               {"views", Takes::data, only<views_table>},
                               {"isovalue", Takes::data, only<isovalue_table>},
                               {"effects", Takes::data_or_scene, effects_tables, {"table_4", "table_1"}},
                               {"memory", Takes::data, only<memory_table>},
                               {"open", Takes::data, only<open_table>},
                               {"view", Takes::data, only<viewer_table>},
                               {"pack", Takes::unpacked, only<pack_table>}};

/// Refuses a scene where a table does not take it.
void require_kind(const TableRow& table, const std::filesystem::path& input, bool is_scene) {
  if (!is_scene || table.takes == Takes::data_or_scene) return;
  throw Error(ErrorCode::unsupported,
              concat(input.string(), ": is a scene; table '", table.name, "' needs a file with data"));
}

struct BenchCommand {
  CommonOptions common;
  BenchOptions bench;
  std::vector<std::filesystem::path> words;  ///< [TABLE] FILE
  bool csv = false;
};

/// The tables asked for: the one that is named, or all that suit the file.
std::vector<TableRow> choose_tables(BenchCommand& command) {
  if (command.words.size() > 2)
    throw Error(ErrorCode::usage,
                concat("unexpected argument '", command.words[2].string(), "'; expected [TABLE] FILE"));
  command.bench.input = command.words.back();
  std::vector<TableRow> chosen;
  if (command.words.size() == 2) {
    const std::string asked = command.words[0].string();
    for (const TableRow& row : table_rows)
      if (asked == row.name) chosen.push_back(row);
    if (chosen.empty())
      throw Error(ErrorCode::usage,
                  concat("no table '", asked,
                         "'; available: phases, threads, views, isovalue, effects, memory, open, view and pack"),
                  did_you_mean(asked, names_in(table_rows, &TableRow::name)));
  }
  preprocess::require_input(command.bench.input);
  const bool is_packed = formats::PackedFile::looks_packed(command.bench.input);
  const bool is_scene = !is_packed && command.bench.read.raw.empty() && render::is_scene_document(command.bench.input);
  const auto suits = [&](Takes takes) {
    if (is_scene) return takes == Takes::data_or_scene;
    return !is_packed || takes != Takes::unpacked;
  };
  for (const TableRow& row : table_rows)
    if (command.words.size() == 1 && suits(row.takes)) chosen.push_back(row);
  require_kind(chosen.front(), command.bench.input, is_scene);
  const auto reads_a_copy = [](const TableRow& row) { return row.takes != Takes::unpacked; };
  if (!is_scene && std::any_of(chosen.begin(), chosen.end(), reads_a_copy)) {
    ProgressDisplay display(command.common);
    command.bench.packed = packed_data_path(command.bench.input, command.bench.field,
                                            access_for(command.common, display, command.bench.read));
  }
  return chosen;
}

void check(const BenchCommand& command) {
  require_within("--repeat", command.bench.repeat, 1, 10'000);
  std::error_code ignored;
  if (!std::filesystem::is_directory(command.bench.scratch, ignored))
    throw Error(ErrorCode::usage, concat("--scratch: there is no folder ", command.bench.scratch.string()));
  const std::filesystem::path& folder = command.common.output;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    throw Error(ErrorCode::usage, concat(folder.string(), ": there is no such folder"), "create the folder first");
}

void show(const BenchCommand& command, const Table& table) {
  const std::filesystem::path& folder = command.common.output;
  if (!folder.empty()) {
    PendingFiles files(command.common.force);
    files.add(folder / (table.name + ".csv"), csv_of(table));
    files.add(folder / (table.name + ".json"), json_of(table).dump(2) + "\n");
    files.publish();
  }
  if (command.common.json)
    std::puts(dump(json_of(table)).c_str());
  else
    std::fputs((command.csv ? csv_of(table) : text_of(table)).c_str(), stdout);
}

/// Of all tables that these measure.
std::vector<std::string> names_of(const std::vector<TableRow>& tables) {
  std::vector<std::string> names;
  for (const TableRow& row : tables) {
    names.emplace_back(row.name);
    names.insert(names.end(), row.also.begin(), row.also.end());
  }
  return names;
}

int run(BenchCommand& command) {
  if (command.bench.scratch.empty()) command.bench.scratch = std::filesystem::temp_directory_path();
  command.bench.threads = command.common.threads;
  command.bench.memory_limit_bytes = command.common.memory.bytes;
  const std::vector<TableRow> tables = choose_tables(command);
  check(command);
  if (!command.common.output.empty())
    for (const std::string& name : names_of(tables))
      for (const char* extension : {".csv", ".json"})
        require_writable(command.common, command.common.output / (name + extension), command.bench.input);
  const ThreadLimit limit(command.common.threads);
  for (const TableRow& row : tables) {
    const std::vector<Table> measured = [&] {
      ProgressDisplay display(command.common);
      return row.measure(command.bench, [&](std::string_view what) { display.show(concat(row.name, ": ", what)); });
    }();
    for (const Table& table : measured) show(command, table);
  }
  return 0;
}

}  // namespace

Subcommand bench_subcommand() {
  const auto command = std::make_shared<BenchCommand>();
  BenchOptions& bench = command->bench;
  return {
      .name = "bench",
      .summary = "Measure the speed of rendering, opening and packing",
      .group = "Measurements",
      .examples = {"rhoray bench phases head.rho --iso 500,1250 --repeat 9",
                   "rhoray bench threads head.rho --size 512x512", "rhoray bench effects head.json --repeat 9",
                   "rhoray bench pack head.nrrd --json"},
      .sections = {{.heading = "Tables",
                    .entries = {{"phases", "shares of traversal, intersection and shading"},
                                {"threads", "from 1 thread to all"},
                                {"views", "rays per second and cycles per ray: front, from the feet, close up, inside"},
                                {"isovalue", "the first picture after a change of the isovalue"},
                                {"effects", "cost of each effect, and Tables 4 and 1 of the paper"},
                                {"memory", "memory beyond the mapped file"},
                                {"open", "opening with and without checksums"},
                                {"view", "the viewer: from a request to its picture, while something is dragged"},
                                {"pack", "packing, compared with reading and writing once"}}}},
      .options = all_options(
          {in_group("Input", {files_option("[TABLE] FILE",
                                           "A table, and a file with data or a scene (effects); default all tables for "
                                           "the file",
                                           command->words),
                              value_option("--field", "NAME", "Field; default the first", bench.field)}),
           in_group("Input", read_options(bench.read)),
           in_group(
               "Picture",
               {value_option("--iso", "V[,V]", "Isovalues, as in render; default auto", bench.isovalues),
                flag_option("--mip", "Also time maximum intensity projection", bench.mip),
                value_option("--view", "WORD", "Side from which the camera looks, as in render; default iso",
                             bench.view),
                value_option("--size", "WxH", "Image size in pixels; default 512x512", bench.size),
                choice_option("--accuracy", render::accuracy_words(), "Accuracy of hits, as in render", bench.accuracy),
                for_experts(choice_option("--normals", render::normals_words(), "Surface normals, as in render",
                                          bench.normals)),
                for_experts(
                    value_option("--color-by", "NAME", "Field that colours surfaces, as in render", bench.color_by))}),
           in_group("Output",
                    {value_option("-o,--output", "FOLDER", "Also write TABLE.csv and TABLE.json to this folder",
                                  command->common.output),
                     flag_option("--force", "Overwrite existing tables", command->common.force),
                     flag_option("--csv", "Print CSV to stdout", command->csv)}),
           in_group(
               "General",
               all_options(
                   {{value_option("--repeat", "N", "Timed repetitions; default 5", bench.repeat)},
                    threads_option(command->common),
                    {for_experts(value_option(
                         "--scratch",
                         "FOLDER", "Folder to which table pack writes; default the system's temporary folder",
                         bench.scratch)),
                     worker_memory_option(command->common, "the process that reads the input of table pack")},
                    message_options(command->common, "Print one JSON document per table to stdout, one per line")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

#include <cmath>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "formats/base/printable.h"
#include "render/isovalue.h"
#include "tools/analysis/enclosed.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct MeasureCommand {
  CommonOptions common;
  std::filesystem::path input;
  render::ReadSpec read;
  std::string field, isovalue = "auto";
  std::optional<double> share;
};

/// "mm^3"; "units^3" where the file names no unit of length.
std::string unit_text(const std::string& length_unit, int power) {
  return concat(length_unit.empty() ? "units" : length_unit, "^", power);
}

std::string text_of(const Enclosed& enclosed, const std::string& unit) {
  std::string text = concat(
      "  volume  ", text_with_error(enclosed.volume, enclosed.volume_error, unit_text(unit, 3)), " (proven), ",
      enclosed.whole_volume > 0 ? concat(rounded(100 * enclosed.volume / enclosed.whole_volume, 3), " % of the data")
                                : "no cell has data",
      "\n", "  area    about ", rounded(enclosed.area, 4), " ", unit_text(unit, 2), " (an estimate)\n", "  cells   ",
      grouped(enclosed.crossed_cells), " crossed by the isosurface\n");
  if (enclosed.cells_without_data != 0)
    text += concat("  note    ", counted(enclosed.cells_without_data, "cell", "cells"),
                   " without data, counted as outside\n");
  return text;
}

int run(const MeasureCommand& command) {
  const render::Dataset dataset = [&] {
    ProgressDisplay display(command.common);
    return load_dataset(command.input, command.field, access_for(command.common, display, command.read));
  }();
  refuse_damage(dataset.file(), command.common.threads);
  const render::Isovalue isovalue = render::choose_isovalue(command.isovalue, dataset.field());
  if (!isovalue.alternatives.empty()) say(command.common, render::isovalue_text(isovalue, dataset.field()));
  EnclosedOptions options{.field = dataset.field().name, .isovalue = isovalue.value, .threads = command.common.threads};
  options.undecided_share = command.share.value_or(options.undecided_share);
  const ThreadLimit limit(command.common.threads);
  const Enclosed enclosed = [&] {
    ProgressDisplay display(command.common);
    options.progress = display.progress();
    return measure_enclosed(dataset.file(), options);
  }();
  if (command.common.json) {
    const Json json{{"file", command.input.string()},
                    {"field", dataset.field().name},
                    {"isovalue", isovalue.value},
                    {"isovalue_from", isovalue.from},
                    {"length_unit", dataset.length_unit()},
                    {"volume", enclosed.volume},
                    {"volume_error", enclosed.volume_error},
                    {"area_estimate", enclosed.area},
                    {"whole_volume", enclosed.whole_volume},
                    {"crossed_cells", enclosed.crossed_cells},
                    {"cells_without_data", enclosed.cells_without_data}};
    std::puts(dump(json).c_str());
    return 0;
  }
  std::fputs(concat(command.input.string(), ": where '", printable(dataset.field().name), "' is at least ",
                    isovalue.value, isovalue.from == "given" ? "" : concat(" (", isovalue.from, ")"), "\n",
                    text_of(enclosed, dataset.length_unit()))
                 .c_str(),
             stdout);
  return 0;
}

}  // namespace

Subcommand measure_subcommand() {
  const auto command = std::make_shared<MeasureCommand>();
  return {
      .name = "measure",
      .summary = "Measure the volume that an isosurface encloses",
      .group = "Measurements",
      .examples = {"rhoray measure head.nrrd --iso 500", "rhoray measure heart.rho --field pressure --iso p90 --json"},
      .options = all_options(
          {{with_details(file_option("FILE", "Grid or mesh, packed or not", command->input),
                         "Files that are not packed are packed first; see `rhoray cache --help`")},
           read_options(command->read),
           {value_option("--field", "NAME", "Field; default the first that is not constant", command->field),
            with_details(value_option("--iso", "V",
                                      concat("Isovalue: a number, a percentile (p95) or auto (",
                                             render::auto_isovalue_words, "); default auto"),
                                      command->isovalue),
                         "The volume is that of values of at least V. Cells without data count as outside"),
            for_experts(with_details(
                value_option_if<double>(
                    "--undecided", "S",
                    "Divide each crossed cell of a grid until at most this share is undecided; default 0.001",
                    "a number above 0", [](double share) { return share > 0; }, command->share),
                "A cell is halved at most 6 times. The proven error counts all that is undecided"))},
           threads_option(command->common),
           {cache_option(command->common)},
           message_options(command->common, "Print the measures as JSON to stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

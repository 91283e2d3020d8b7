#include <algorithm>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "formats/base/word_list.h"
#include "preprocess/export_grid.h"
#include "preprocess/resample.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct ResampleCommand {
  CommonOptions common;
  std::filesystem::path input;
  std::string size, spacing, max_error;  ///< as typed; empty when not given
  preprocess::ResampleOptions resample;
};

/// N, or three numbers with x between them.
void read_size(const std::string& text, preprocess::LatticeRequest& spec) {
  if (text.find('x') == std::string::npos) return read_value(text, spec.longest_axis);
  const std::size_t first = text.find('x'), second = text.find('x', first + 1);
  if (second == std::string::npos)
    throw Error(ErrorCode::usage, concat("--size: found '", text, "'; expected N or NxNxN"));
  read_value(text.substr(0, first), spec.sample_count.x);
  read_value(text.substr(first + 1, second - first - 1), spec.sample_count.y);
  read_value(text.substr(second + 1), spec.sample_count.z);
}

void read_spacing(const std::string& text, preprocess::LatticeRequest& spec) {
  if (text.find(',') != std::string::npos) return read_value(text, spec.spacing);
  double step = 0;
  read_value(text, step);
  spec.spacing = Vec3(step, step, step);
}

void read_max_error(std::string text, preprocess::ResampleOptions& options) {
  options.max_error_is_share = text.ends_with('%');
  if (options.max_error_is_share) text.pop_back();
  double error = 0;
  read_value(text, error);
  if (!(error > 0)) throw Error(ErrorCode::usage, concat("--max-error: found ", error, "; expected a number above 0"));
  options.max_error = options.max_error_is_share ? error / 100 : error;
}

void read_options(ResampleCommand& command) {
  if (!command.size.empty() && !command.spacing.empty())
    throw Error(ErrorCode::usage, "--size and --spacing are mutually exclusive");
  if (command.size.empty() && command.spacing.empty() && command.max_error.empty())
    throw Error(ErrorCode::usage, "no resolution given; expected --size, --spacing or --max-error",
                "--size 256 takes 256 samples along the longest axis");
  preprocess::LatticeRequest& spec = command.resample.lattice;
  if (!command.size.empty()) {
    read_size(command.size, spec);
    if (!spec.is_given()) throw Error(ErrorCode::usage, "--size: found 0; expected at least 2 samples on an axis");
  }
  if (!command.spacing.empty()) {
    read_spacing(command.spacing, spec);
    if (!spec.is_given()) throw Error(ErrorCode::usage, "--spacing: found 0; expected a number above 0");
  }
  if (!command.max_error.empty()) read_max_error(command.max_error, command.resample);
}

void check(const ResampleCommand& command, const std::filesystem::path& output) {
  preprocess::check_resample(command.input);
  if (output.extension() != ".rho" && output.extension() != ".vdb")
    throw Error(ErrorCode::usage, concat(output.string(), ": found extension '", output.extension().string(),
                                         "'; expected .rho or .vdb"));
  require_writable(command.common, output, command.input);
  if (formats::PackedFile::looks_packed(command.input))
    refuse_damage(formats::PackedFile::open(command.input), command.common.threads);
}

/// The command line stored in the file.
std::string command_line(const ResampleCommand& command, const std::filesystem::path& output) {
  std::vector<std::string> words{"rhoray", "resample", command.input.string(), "-o", output.string()};
  const std::string fields = joined(command.resample.fields, ",");
  const std::pair<const char*, const std::string&> values[] = {{"--size", command.size},
                                                               {"--spacing", command.spacing},
                                                               {"--max-error", command.max_error},
                                                               {"--field", fields}};
  for (const auto& [name, value] : values)
    if (!value.empty()) words.insert(words.end(), {name, value});
  if (command.resample.cells_to_points) words.emplace_back("--cell-data");
  return shell_line(words);
}

/// Resamples to a packed grid, and for .vdb writes that as OpenVDB: its first field, without the
/// certificate.
preprocess::ResampleReport resample_to(const std::filesystem::path& output, const ResampleCommand& command,
                                       ProgressDisplay& display) {
  const preprocess::ResampleOptions& options = command.resample;
  if (output.extension() == ".rho") return preprocess::resample(command.input, output, options, display.progress());
  const ScratchFolder scratch(output.has_parent_path() ? output.parent_path() : std::filesystem::path("."));
  const std::filesystem::path packed = scratch.path() / "grid.rho";
  preprocess::ResampleReport report = preprocess::resample(command.input, packed, options, display.progress());
  display.show(concat("writing ", output.string()));
  preprocess::ExportReport written =
      preprocess::export_vdb(packed, output, {.replace_existing = options.replace_existing});
  report.file_bytes = written.file_bytes;
  report.notes.insert(report.notes.end(), written.notes.begin(), written.notes.end());
  report.notes.push_back("an OpenVDB file cannot store the error; a .rho file stores it for each brick");
  return report;
}

Json report_json(const preprocess::ResampleReport& report) {
  Json errors = Json::array(), attempts = Json::array();
  for (const auto& error : report.errors)
    errors.push_back({{"field", error.name},
                      {"coverage", error.coverage},
                      {"max_error", error.max_error},
                      {"attained", error.attained},
                      {"attained_at", json_of(error.attained_at)},
                      {"rms_error", error.rms_error},
                      {"point_count", error.point_count}});
  for (const auto& attempt : report.attempts)
    attempts.push_back({{"sample_count", json_of(attempt.sample_count)},
                        {"coverage", attempt.coverage},
                        {"max_error", attempt.max_error}});
  return {{"coverage", report.errors.front().coverage},
          {"requested_error", report.requested_error ? Json(*report.requested_error) : Json(nullptr)},
          {"reached", report.why_not_reached.empty()},
          {"why_not_reached", report.why_not_reached},
          {"file_bytes", report.file_bytes},
          {"inside_count", report.inside_count},
          {"outside_count", report.outside_count},
          {"extended_count", report.extended_count},
          {"overlap_count", report.overlap_count},
          {"stored_brick_count", report.description.layout.stored_brick_count},
          {"brick_count", volume(report.description.layout.brick_count())},
          {"errors", errors},
          {"attempts", attempts}};
}

/// Coverage first, because the error is known only for the covered part of the mesh.
void say_errors(const CommonOptions& common, const preprocess::ResampleReport& report) {
  for (const auto& error : report.errors)
    say(common, concat("coverage of ", error.name, ": ", rounded(100 * error.coverage, 6),
                       " % of the mesh's volume where it has data lies in grid cells with values"));
  for (const auto& error : report.errors) {
    const std::string unit = [&] {
      for (const formats::FieldSummary& field : report.description.fields)
        if (field.name == error.name && !field.unit.empty()) return " " + field.unit;
      return std::string{};
    }();
    say(common,
        concat("error of ", error.name, ": at most ", rounded(error.max_error), unit, " (", rounded(error.attained),
               " at ", text_of(error.attained_at), "), root mean square about ", rounded(error.rms_error), unit));
  }
}

/// Refusal if --max-error was not reached. The file exists, and its certificate states the error.
void refuse_missed_error(const preprocess::ResampleReport& report, const std::filesystem::path& output) {
  if (report.why_not_reached.empty()) return;
  const auto& error = report.errors.front();
  throw Error(ErrorCode::outside_limit,
              concat(output.string(), ": the error of ", error.name, " is at most ", rounded(error.max_error), " in ",
                     rounded(100 * error.coverage, 6), " % of the mesh where it has data; ",
                     rounded(*report.requested_error), " was requested (", report.why_not_reached, ")"),
              "the file was written; allow a larger error or more memory, or start from a finer grid with --size");
}

int run(ResampleCommand& command) {
  const Stopwatch watch;
  const std::filesystem::path output =
      command.common.output.empty() ? command.input.parent_path() / concat(command.input.stem().string(), "_grid.rho")
                                    : command.common.output;
  read_options(command);
  check(command, output);
  preprocess::ResampleOptions& options = command.resample;
  options.memory_limit_bytes = command.common.memory.bytes;
  options.replace_existing = command.common.force;
  options.command = command_line(command, output);
  const ThreadLimit limit(command.common.threads);
  const preprocess::ResampleReport report = [&] {
    ProgressDisplay display(command.common);
    return resample_to(output, command, display);
  }();

  const CommonOptions& common = command.common;
  const Usage usage = usage_so_far();
  for (const std::string& note : report.notes) say(common, concat("note: ", note));
  for (const auto& attempt : report.attempts)
    tell(common, concat(text_of(attempt.sample_count), " samples: coverage ", rounded(100 * attempt.coverage, 6),
                        " %, error at most ", rounded(attempt.max_error)));
  const formats::BrickLayout& layout = report.description.layout;
  say_errors(common, report);
  say(common, concat(output.string(), ": ", text_of(layout.sample_count), " samples, ", grouped(report.inside_count),
                     " in the mesh and ", grouped(report.outside_count), " outside, ", grouped(report.extended_count),
                     " of them with a value for the cells at its border; ", grouped(layout.stored_brick_count), " of ",
                     grouped(static_cast<std::uint64_t>(volume(layout.brick_count()))), " bricks kept, ",
                     bytes_text(report.file_bytes)));
  say(common, concat("took ", rounded(watch.seconds(), 3), " s (", rounded(usage.cpu_s, 3), " s of CPU), peak memory ",
                     bytes_text(usage.peak_bytes), ", in the reading process ", bytes_text(usage.worker_peak_bytes)));
  if (common.json) {
    Json json = report_json(report);
    json["file"] = output.string();
    json["seconds"] = watch.seconds();
    json["cpu_seconds"] = usage.cpu_s;
    json["peak_bytes"] = usage.peak_bytes;
    json["worker_peak_bytes"] = usage.worker_peak_bytes;
    json["notes"] = report.notes;
    json["description"] = json_of(report.description);
    std::puts(dump(json).c_str());
  }
  refuse_missed_error(report, output);
  return 0;
}

}  // namespace

Subcommand resample_subcommand() {
  const auto command = std::make_shared<ResampleCommand>();
  return {
      .name = "resample",
      .summary = "Resample tetrahedra on a grid, with a certified error",
      .group = "Meshes",
      .examples = {"rhoray resample torso.vtu --size 256 -o torso_grid.rho",
                   "rhoray resample torso.rho --max-error 0.5% --field potential -o torso_grid.rho",
                   "rhoray resample torso.vtu --spacing 2 --field potential -o torso.vdb"},
      .sections = {{.heading = "Notes",
                    .entries = {{"",
                                 "Samples next to the mesh get extrapolated values where a cell at its border needs "
                                 "them. The grid therefore extends beyond the mesh, by at most one and a half cells "
                                 "per axis."},
                                {"",
                                 "Coverage counts the part of the mesh where the field has data. It is the share of "
                                 "that volume in grid cells with values. The error bound holds there."}},
                    .is_expert = true}},
      .options = all_options(
          {{file_option("MESH", "Mesh of volume cells, or packed tetrahedra", command->input)},
           output_options(command->common,
                          "Packed grid (.rho) or OpenVDB (.vdb); default the input's name with _grid.rho"),
           {value_option("--size", "N|NxNxN", "Samples on the longest axis, or on each axis", command->size),
            value_option("--spacing", "H|X,Y,Z", "Sample spacing, in the mesh's unit", command->spacing),
            with_details(value_option("--max-error", "E|E%",
                                      "Refine until the first field's error is at most E, or E % of its range, "
                                      "wherever it has data",
                                      command->max_error),
                         "--size or --spacing gives the first grid. Exit code 6 if this is not reached; the best grid "
                         "is still written"),
            value_option("--field", "A[,B]", "Fields to sample; `render` shows the first; default all",
                         command->resample.fields),
            flag_option("--cell-data", "Also sample cell fields, averaged to points",
                        command->resample.cells_to_points)},
           threads_option(command->common),
           {memory_option(command->common, "Memory limit for the samples and for the reading process, such as 2G")},
           message_options(command->common, "Print a JSON summary to stdout")}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

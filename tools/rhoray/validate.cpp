#include <cstdio>

#include "formats/base/error.h"
#include "preprocess/run_worker.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_spec.h"
#include "tools/analysis/format_statistics.h"
#include "tools/analysis/measure.h"
#include "tools/analysis/validation_report.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/cli/version.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/subcommands.h"
#include "tools/validate/request.h"

namespace rhoray::tools {

namespace {

struct ValidateCommand {
  CommonOptions common;
  std::filesystem::path input;
  render::ReadSpec read;
  std::string isovalue, field, accuracy, method;
  std::optional<std::uint64_t> samples, seed;
  std::optional<double> max_depth_error;
  double time_limit_s = 3600;
  std::filesystem::path folder;
};

constexpr render::PictureSize report_picture{.width = 640, .height = 480};

void check(const ValidateCommand& command) {
  if (command.isovalue.empty())
    throw Error(ErrorCode::usage, "--iso: missing; choose the isosurface to check",
                "--iso 500, --iso p95 or --iso auto");
  require_within("--samples", static_cast<double>(command.samples.value_or(1)), 1, 1e9);
  if (command.max_depth_error && !(*command.max_depth_error > 0))
    throw Error(ErrorCode::usage,
                concat("--max-depth-error: found ", *command.max_depth_error, "; expected more than 0"));
  require_within("--time-limit", command.time_limit_s, 1, 1e9);
  if (!command.folder.empty()) require_report_folder(command.folder, command.common.force);
}

/// Default level double, because depths are compared as closely as it promises them.
render::Method chosen_method(const ValidateCommand& command, bool is_mesh) {
  if (!command.method.empty() && !command.accuracy.empty())
    throw Error(ErrorCode::usage, "--method and --accuracy are mutually exclusive");
  if (!command.method.empty()) return render::method_named(command.method, render::Mode::isosurface, is_mesh);
  return command.accuracy.empty() ? render::Method{} : method_of(render::accuracy_named(command.accuracy));
}

formats::PackedFile compare(const ValidateCommand& command, const validate::Request& request) {
  ProgressDisplay display(command.common);
  preprocess::WorkerRequest work;
  work.program = "rhoray-validate-worker";
  work.doing = concat("validating ", command.input.string());
  work.arguments = {text_of(request)};
  work.memory_limit_bytes = command.common.memory.bytes;
  work.time_limit_s = command.time_limit_s;
  work.progress = [&](std::uint64_t done, std::uint64_t total) { display.show(work.doing, done, total); };
  display.show(work.doing);
  return preprocess::run_worker(work);
}

int run(ValidateCommand& command) {
  const Stopwatch watch;
  check(command);
  const std::filesystem::path packed = [&] {
    ProgressDisplay display(command.common);
    return packed_data_path(command.input, command.field, access_for(command.common, display, command.read));
  }();
  const render::Dataset dataset = load_dataset(packed, command.field);
  const render::Isovalue isovalue = render::choose_isovalue(command.isovalue, dataset.field());
  if (!isovalue.alternatives.empty()) say(command.common, render::isovalue_text(isovalue, dataset.field()));
  refuse_damage(dataset.file(), command.common.threads);
  const render::RangeProof range_proof = dataset.prove_ranges(command.common.threads);
  tell(command.common, concat("stored value ranges checked: ", proof_text(range_proof)));
  validate::Request request{.file = packed.string(),
                            .field = dataset.field().name,
                            .isovalue = isovalue.value,
                            .threads = command.common.threads,
                            .max_depth_error = command.max_depth_error.value_or(0)};
  const render::Method method = chosen_method(command, dataset.is_mesh());
  request.algorithm = static_cast<int>(method.algorithm);
  request.precision = static_cast<int>(method.precision);
  request.step = method.step;
  request.slack = method.slack;
  request.bisect = method.bisect;
  request.samples = command.samples.value_or(request.samples);
  request.seed = command.seed.value_or(request.seed);
  if (!command.folder.empty()) {
    request.picture_width = report_picture.width;
    request.picture_height = report_picture.height;
  }
  const formats::PackedFile answer = compare(command, request);

  ValidationReport report(answer);
  report.add_context({{"file", command.input.string()},
                      {"field", request.field},
                      {"isovalue", request.isovalue},
                      {"isovalue_from", isovalue.from},
                      {"samples", request.samples},
                      {"seed", request.seed},
                      {"range_proof", proof_json(range_proof)}},
                     watch.seconds(), version());
  std::fputs(command.common.json ? (dump(report.json()) + "\n").c_str() : report.text().c_str(), stdout);
  if (!command.folder.empty()) report.write(command.folder, command.common.force);
  report.refuse_outside_limits(command.input.string());
  return 0;
}

}  // namespace

Subcommand validate_subcommand() {
  const auto command = std::make_shared<ValidateCommand>();
  return {
      .name = "validate",
      .summary = "Check an isosurface against a CGAL reference",
      .group = "Measurements",
      .examples = {"rhoray validate torso.rho --iso 0.5",
                   "rhoray validate head.rho --iso 500 --samples 1000000 --report head_validation"},
      .sections = {{.heading = "Exit codes",
                    .entries = {{"4", "the file's value ranges are wrong"}, {"6", "a check is outside its limit"}}},
                   {.heading = "Needs",
                    .entries = {{"",
                                 "The program rhoray-validate-worker beside `rhoray`. It links CGAL (GPL-3 or "
                                 "later)."}},
                    .is_expert = true}},
      .options = all_options(
          {{file_option("FILE", "Packed file, or a file that `rhoray pack` reads", command->input)},
           in_group("Input", read_options(command->read)),
           in_group("Surface",
                    {value_option("--field", "NAME", "Field; default the first that is not constant", command->field),
                     value_option(
                         "--iso", "V",
                         concat("Isovalue: a number, a percentile (p95) or auto (", render::auto_isovalue_words, ")"),
                         command->isovalue),
                     choice_option("--accuracy", render::accuracy_words(), "Accuracy of the renderer; default double",
                                   command->accuracy),
                     for_experts(with_details(
                         value_option("--method", "NAME", "Use one method, for comparison", command->method),
                         render::method_forms()))}),
           in_group("Check",
                    {value_option("--samples", "N", "Number of rays, sent from around the data; default 100000",
                                  command->samples),
                     with_details(value_option("--max-depth-error", "E", "Largest error along a ray; default 1e-9",
                                               command->max_depth_error),
                                  "The unit is the diagonal of a mesh's box, or a cell of a grid. The error bound "
                                  "of a hit is added, if it has one"),
                     for_experts(with_details(value_option("--seed", "N", "Random seed; default 1", command->seed),
                                              "For a mesh the same seed gives the same report"))}),
           in_group("Output",
                    {with_details(value_option("--report", "DIR", "Write the report to this folder", command->folder),
                                  "The report is text, JSON and CSV, with pictures of the errors. A missing folder "
                                  "is created"),
                     flag_option("--force", "Overwrite an existing report", command->common.force)}),
           in_group("General",
                    all_options({threads_option(command->common),
                                 {for_experts(value_option("--time-limit", "S",
                                                           "CPU time limit of the worker, in seconds; default 3600",
                                                           command->time_limit_s)),
                                  worker_memory_option(command->common, "the worker")},
                                 message_options(command->common, "Print the report as JSON to stdout")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

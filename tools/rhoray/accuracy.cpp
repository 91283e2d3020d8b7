#include <algorithm>
#include <chrono>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "formats/base/stopping.h"
#include "render/document.h"
#include "tools/analysis/format_statistics.h"
#include "tools/analysis/measure.h"
#include "tools/analysis/pages.h"
#include "tools/analysis/results.h"
#include "tools/analysis/study.h"
#include "tools/rhoray/accuracy_options.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/cli/version.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/render/picture_options.h"
#include "tools/rhoray/render/reproduce.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct AccuracyCommand {
  CommonOptions common;
  std::filesystem::path input;
  PictureOptions picture;
  std::uint64_t seed = 1;
  double time_limit_s = 600;
  int repeat = 5;
  render::Goal goal;
};

constexpr render::PictureSize default_size{.width = 640, .height = 480};
constexpr int coarse_shrink = 4;
constexpr double coarse_pixels = 40'000;  ///< a picture with no more needs no coarse pass

/// Options of a picture that do not apply when every method is tried and colours are compared.
bool is_of_one_picture(const std::string& names) {
  return names == "--accuracy" || names == "--method" || names == "--channels" || names == "--show";
}

std::vector<Option> of_all_methods(std::vector<Option> rows) {
  std::erase_if(rows, [](const Option& row) { return is_of_one_picture(row.names); });
  return rows;
}

render::SceneSpec spec_of(const AccuracyCommand& command) {
  render::SceneSpec scene_spec;
  if (command.picture.scene_spec.data[0].read.raw.empty() && render::is_scene_document(command.input)) {
    const render::SceneDocument document = render::read_scene(command.input);
    for (const std::string& warning : document.warnings) say(command.common, concat("warning: ", warning));
    scene_spec = with_options(document.scene_spec, command.picture);
  } else {
    PictureOptions picture = command.picture;
    if (picture.mode.empty()) picture.mode = "iso";  // a boundary has only one method
    scene_spec = spec_of(picture, {command.input});
  }
  if (!scene_spec.image.size) scene_spec.image.size = default_size;
  scene_spec.image.channels.reset();
  scene_spec.image.show.reset();
  return scene_spec;
}

void check(const AccuracyCommand& command) {
  if (command.common.output.empty())
    throw Error(ErrorCode::usage, "-o: missing; expected a folder for the results",
                concat("rhoray accuracy ", command.input.string(), " -o accuracy"));
  require_within("--time-limit", command.time_limit_s, 1, 1e6);
  require_within("--repeat", command.repeat, 1, 1000);
  require_valid(command.goal);
}

/// The command that repeats this study, with every choice of the picture.
std::string study_command(const AccuracyCommand& command, const render::ResolvedScene& plan) {
  std::vector<std::string> words;
  const std::vector<std::string> picture = reproducing_command(plan, command.common.output);
  for (std::size_t i = 0; i < picture.size(); ++i)
    if (is_of_one_picture(picture[i]))
      ++i;  // and its value
    else
      words.push_back(i == 1 ? "accuracy" : picture[i]);
  words.insert(words.end(), {"--seed", concat(command.seed), "--repeat", concat(command.repeat), "--time-limit",
                             concat(command.time_limit_s)});
  if (command.common.threads != 0) words.insert(words.end(), {"--threads", concat(command.common.threads)});
  return shell_line(words);
}

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts);
  return text;
}

/// The name of a dataset in the report. Data in the memory of another process have a number as file
/// name.
std::string input_name(const std::filesystem::path& file) {
  return file.string().starts_with("/proc/") ? "data in memory" : file.filename().string();
}

Json facts_of(const AccuracyCommand& command, const render::ResolvedScene& plan) {
  const Machine machine = this_machine();
  std::string inputs;
  for (const render::DataSpec& data : plan.data) inputs += concat(inputs.empty() ? "" : ", ", input_name(data.file));
  return {{"input", inputs},
          {"date", date_now()},
          {"processor", machine.processor},
          {"cores", machine.core_count},
          {"threads", command.common.threads == 0 ? machine.core_count : command.common.threads},
          {"memory_bytes", machine.memory_bytes},
          {"system", machine.system},
          {"version", version()},
          {"commit", commit()},
          {"compiler", compiler()},
          {"seed", command.seed},
          {"repeat", command.repeat},
          {"time_limit_s", command.time_limit_s},
          {"size", {plan.frame.width, plan.frame.height}},
          {"command", study_command(command, plan)}};
}

std::string size_text(const render::PictureSize& size) {
  return concat(size.width, " x ", size.height);
}

/// The reason for leaving a layer out; null for layers that several methods can draw.
const char* why_left_out(const render::Layer& layer) {
  if (layer.mode == render::Mode::triangles) return "holds triangles, for which there is only one method";
  if (layer.mode == render::Mode::slice) return "is a slice, for which there is only one method";
  return nullptr;
}

std::string minutes_text(double seconds) {
  return seconds < 90 ? concat(std::llround(std::max(1.0, seconds)), " s") : concat(std::llround(seconds / 60), " min");
}

/// The complete study: a coarse pass over all layers, one pass at full size, then repeated timings.
class Work {
 public:
  Work(const AccuracyCommand& command, const render::ResolvedScene& plan, ProgressDisplay& display,
       StudyContext& context)
      : command_(command),
        display_(display),
        context_(context),
        folder_(command.common.output, command.common.force),
        scratch_(command.common.output),
        size_{plan.frame.width, plan.frame.height} {
    for (std::size_t layer = 0; layer < plan.scene.layers.size(); ++layer) {
      if (const char* const reason = why_left_out(plan.scene.layers[layer])) {
        context_.notes.push_back(concat("layer ", layer + 1, " ", reason, "; left out"));
        continue;
      }
      studies_.push_back(std::make_unique<LayerStudy>(plan, layer, study_options()));
      layers_.push_back(studies_.back().get());
    }
    const bool are_surfaces = std::all_of(plan.datasets.begin(), plan.datasets.end(),
                                          [](const render::Dataset& dataset) { return dataset.is_surface(); });
    if (layers_.empty())
      throw Error(are_surfaces ? ErrorCode::unsupported : ErrorCode::usage,
                  "every layer is triangles or a slice: there are no methods to compare",
                  "add an isosurface or a projection");
  }

  /// False when it was interrupted.
  bool run() {
    try {
      coarse_pass();
      full_pass();
      weigh_instruments();
      rounds();
    } catch (const Error&) {
      // A worker interrupted at the same time reports its own error.
      if (!interrupt_.token().stop_requested() || layers_[0]->result() == nullptr) throw;
      stage_ = concat("Interrupted. ", stage_);
      is_ended_ = true;
      write();
      return false;
    }
    stage_.clear();
    write();
    return true;
  }

  const std::vector<const LayerStudy*>& layers() const { return layers_; }

 private:
  LayerStudyOptions study_options() {
    LayerStudyOptions options{.seed = command_.seed, .threads = command_.common.threads, .stop = interrupt_.token()};
    options.forms = {.folder = scratch_.path(),
                     .memory_limit_bytes = command_.common.memory.bytes,
                     .seconds = 0.1 * command_.time_limit_s,
                     .progress = [stop = interrupt_.token()](std::string_view, std::uint64_t, std::uint64_t) {
                       end_if_stopped(stop);
                     }};
    return options;
  }

  double seconds_left() const { return command_.time_limit_s - watch_.seconds(); }

  void write() {
    context_.stage = stage_;
    if (!stage_.empty() && !is_ended_)
      context_.stage += concat(" Still running after ", minutes_text(watch_.seconds()), "; at most ",
                               minutes_text(seconds_left()), " remain. Reload this page.");
    folder_.write(layers_, context_);
    written_s_ = watch_.seconds();
  }
  void write_now_and_then() {
    constexpr double pause_s = 15;
    if (watch_.seconds() - written_s_ > pause_s) write();
  }

  void coarse_pass() {
    if (static_cast<double>(size_.width) * size_.height <= coarse_pixels) return;
    const render::PictureSize size{std::max(1, size_.width / coarse_shrink), std::max(1, size_.height / coarse_shrink)};
    stage_ = concat("These results come from a coarse pass with ", size_text(size), " pixels instead of ",
                    size_text(size_), ".");
    pass("coarse pass", size, 0.03 * command_.time_limit_s, 0.0015 * command_.time_limit_s);
    write();
  }

  void full_pass() {
    if (stage_.empty()) stage_ = "Not all variants have been measured yet.";
    const double layers = static_cast<double>(layers_.size());
    pass("full size", size_, 0.15 * std::max(1.0, seconds_left()) / layers, 0.007 * command_.time_limit_s / layers);
    stage_ = "All variants have been measured, but not all repetitions are done.";
    write();
  }

  void pass(const char* name, const render::PictureSize& size, double judge_seconds, double part_seconds) {
    std::size_t layers_left = studies_.size();
    for (const auto& study : studies_) {
      const double seconds = std::max(1.0, 0.7 * seconds_left()) / static_cast<double>(layers_left--);
      const std::string phase = concat(name, ", ", size_text(size), ", ", study->name());
      display_.show(phase, 0, study->variants().size());
      study->pass({.size = size,
                   .judge_seconds = judge_seconds,
                   .seconds = seconds,
                   .variant_seconds = 0.03 * command_.time_limit_s / static_cast<double>(studies_.size()),
                   .part_seconds = part_seconds,
                   .variant_done = [&](double share) {
                     constexpr std::uint64_t whole = 1000;
                     const auto done = static_cast<std::uint64_t>(share * whole);
                     write_now_and_then();
                     display_.show(phase, done, whole);
                   }});
    }
  }

  /// Every variant is drawn once per round, so that other load on the machine affects all of them.
  void rounds() {
    for (int round = 2; round <= command_.repeat && seconds_left() > 0; ++round) {
      const std::string phase = concat("round ", round, " of ", command_.repeat);
      for (const auto& study : studies_) {
        const std::size_t count = study->result()->rows.size();
        for (std::size_t row = 0; row < count; ++row) {
          display_.show(phase, row, count);
          const double foreseen = study->foreseen_s(row);
          if (foreseen > 0 && foreseen < 0.1 * seconds_left()) study->time_again(row);
          write_now_and_then();
        }
      }
    }
  }

  void weigh_instruments() {
    if (seconds_left() <= 0) return;
    display_.show("measuring the overhead of the measurement");
    const InstrumentCost cost = studies_[0]->instrument_cost(0.02 * command_.time_limit_s);
    context_.facts["instruments_share_of_time"] = cost.share;
    context_.facts["instruments_noise"] = cost.noise;
    context_.facts["instruments_pictures"] = cost.pictures;
  }

  const AccuracyCommand& command_;
  ProgressDisplay& display_;
  StudyContext& context_;
  Stopwatch watch_;
  InterruptRequest interrupt_{"interrupted; writing the results so far (interrupt again to stop at once)"};
  ResultsFolder folder_;  ///< before the scratch folder, which lies in it
  ScratchFolder scratch_;
  render::PictureSize size_;
  std::vector<std::unique_ptr<LayerStudy>> studies_;
  std::vector<const LayerStudy*> layers_;
  std::string stage_;  ///< how far the work is; empty: done
  bool is_ended_ = false;
  double written_s_ = 0;
};

int run(AccuracyCommand& command) {
  check(command);
  const render::SceneSpec scene_spec = spec_of(command);
  const ThreadLimit limit(command.common.threads);
  ProgressDisplay display(command.common);
  display.show(concat("opening ", scene_spec.data[0].file.string()));
  render::ResolvedScene plan = resolve_layers(scene_spec, access_for(command.common, display));
  aim_camera(scene_spec, plan);
  for (const render::Dataset& dataset : plan.datasets) refuse_damage(dataset.file(), command.common.threads);
  require_results_folder(command.common.output, command.common.force);
  render::RangeProof range_proof;
  for (const render::Dataset& dataset : plan.datasets)
    range_proof += dataset.prove_ranges(command.common.threads, {{}, display.progress()});
  tell(command.common, concat("stored value ranges checked: ", proof_text(range_proof)));

  StudyContext context{.facts = facts_of(command, plan), .stage = {}, .notes = plan.notes};
  context.facts["ranges_proven"] = proof_text(range_proof);
  if (command.goal.is_given())
    for (const render::Choice& choice :
         choose_methods(plan, command.goal, command.common.threads, {{}, display.progress()}))
      context.notes.push_back(concat("`rhoray render` would use ", choice.sentence));
  Work work(command, plan, display, context);
  const bool is_whole = work.run();
  display.clear();
  if (command.common.json)
    std::puts(dump(results_json(work.layers(), context)).c_str());
  else
    for (const LayerStudy* layer : work.layers()) {
      std::puts(concat(layer->name(), ":").c_str());
      for (const std::string& sentence : conclusions_of(*layer)) std::puts(concat("  ", sentence).c_str());
    }
  for (const std::string& note : context.notes) say(command.common, concat("note: ", note));
  say(command.common, concat("report: ", (command.common.output / "report.html").string()));
  return is_whole ? 0 : interrupted_exit_code();
}

}  // namespace

Subcommand accuracy_subcommand() {
  const auto command = std::make_shared<AccuracyCommand>();
  return {
      .name = "accuracy",
      .summary = "Measure error and time of every method on your data",
      .group = "Measurements",
      .examples = {"rhoray accuracy head.rho --iso 500 -o head_accuracy",
                   "rhoray accuracy pet.rho --mode mip -o pet_accuracy",
                   "rhoray accuracy torso.json -o torso_accuracy --size 1280x720 --time-limit 1800"},
      .sections = {{.heading = "Results",
                    .entries = {{"results.csv, .json", "all numbers"},
                                {"report.html", "one page without other files"},
                                {"pictures", "and plots, if gnuplot is installed"},
                                {"",
                                 "First results appear after a coarse pass and are then updated. After an interrupt "
                                 "the report is complete for what was measured."}}}},
      .options = all_options(
          {in_group("Input", {file_option("FILE", "Volume, mesh or surface, packed or not, or scene document (.json)",
                                          command->input)}),
           in_group("Input", read_options(command->picture.scene_spec.data[0].read)),
           of_all_methods(picture_options(command->picture)), goal_options(command->goal),
           in_group("Output", all_options({output_options(command->common, "Folder for the results; created if missing",
                                                          "FOLDER"),
                                           of_all_methods(image_options(command->picture))})),
           in_group(
               "General",
               all_options({{with_details(value_option("--time-limit", "S", "Time limit in seconds; default 600",
                                                       command->time_limit_s),
                                          "Variants that do not fit are left out and listed"),
                             for_experts(value_option(
                                 "--repeat", "N", "Number of times each variant is timed; default 5", command->repeat)),
                             for_experts(value_option("--seed", "N", "Random seed for the choice of pixels; default 1",
                                                      command->seed))},
                            threads_option(command->common),
                            {for_experts(memory_option(command->common,
                                                       "Leave out copies of the data that need more memory; "
                                                       "default half of the machine's memory"))},
                            message_options(command->common, "Print the results as JSON to stdout")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

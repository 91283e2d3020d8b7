// Stores the same field in 64 to 8 bits per sample. Measures how far the isosurface moves, how many
// pixels it gains or loses, how its normals turn, the time of a picture, and the size of the file.

#include "tools/lab/bits.h"

#include <algorithm>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/read_value.h"
#include "preprocess/pack_volume.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_spec.h"
#include "tools/lab/figures.h"
#include "tools/lab/judged_view.h"
#include "tools/lab/plain_grid.h"
#include "tools/lab/rounds.h"
#include "tools/lab/stored_samples.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::study {

namespace {

constexpr const char* table_name = "bits";
constexpr const char* depth_figure = "bits_depth";
constexpr const char* normal_figure = "bits_normal";

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field, view = "front";
  std::vector<std::string> isovalues{"auto"}, levels{"float", "double"};
  render::PictureSize size{512, 512};
  double judge_seconds = 60;
  std::uint64_t seed = 1;
  RoundsOptions rounds;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

/// The field in one storage format, packed.
struct Form {
  std::string name;
  int bits = 0;
  bool is_whole = false;
  render::Dataset dataset;
  std::uint64_t bytes = 0;
  double scale = 1, offset = 0;

  double own(double value) const { return scale * (value - offset); }
};

class Forms {
 public:
  explicit Forms(const std::filesystem::path& folder) : folder_(folder) {}

  /// Adds the original field; it comes first.
  void add_original(const preprocess::NeutralVolume& grid) {
    add(concat("as it is, ", formats::element_name(grid.type)), 8 * static_cast<int>(formats::element_bytes(grid.type)),
        grid);
  }
  void add(const Storage& storage, const preprocess::NeutralVolume& grid, const Interval<double>& range) {
    const std::optional<StoredSamples> stored = stored_as(storage, grid, range);
    if (!stored) return;
    add(storage.name, storage.bits, stored->volume);
    all_.back().is_whole = storage.is_whole;
    all_.back().scale = stored->scale;
    all_.back().offset = stored->offset;
  }

  const std::vector<Form>& all() const { return all_; }

 private:
  void add(const std::string& name, int bits, const preprocess::NeutralVolume& samples) {
    const std::filesystem::path path = folder_ / concat("form", all_.size(), ".rho");
    const std::uint64_t bytes = preprocess::pack_volume(samples, path).file_bytes;
    all_.push_back({.name = name, .bits = bits, .dataset = render::Dataset::load(path), .bytes = bytes});
  }

  std::filesystem::path folder_;
  std::vector<Form> all_;
};

std::vector<Json> rows_of(const Settings& settings, const Forms& forms, double isovalue,
                          const std::function<void(const std::string&)>& tell) {
  const render::Dataset& original = forms.all()[0].dataset;
  tell(concat("isovalue ", isovalue, ", the exact answer"));
  ExactView view(original, {.isovalue = isovalue,
                            .camera = tools::study_camera(tools::study_view_named(settings.view), original, isovalue,
                                                          double{1} * settings.size.width / settings.size.height),
                            .size = settings.size,
                            .judge_seconds = settings.judge_seconds,
                            .seed = settings.seed});
  std::vector<Json> rows;
  std::vector<TimedRow> timed;
  for (const Form& form : forms.all())
    for (const std::string& level : settings.levels) {
      tell(concat("isovalue ", isovalue, ", errors of ", form.name, ", ", level));
      const Shown shown{.dataset = form.dataset,
                        .isovalue = form.own(isovalue),
                        .method = render::method_of(render::accuracy_named(level))};
      Json row{{"isovalue", isovalue},           {"stored", form.name}, {"bits", form.bits},
               {"whole_numbers", form.is_whole}, {"level", level},      {"bytes", form.bytes}};
      row.update(view.ray_errors(shown));
      row.update(view.picture_errors(shown));
      rows.push_back(std::move(row));
      timed.push_back({.name = concat(form.name, ", ", level), .act = [&view, shown] { view.draw(shown); }});
    }
  run_rounds(timed, settings.rounds, [&](const std::string& what) { tell(concat("isovalue ", isovalue, ", ", what)); });
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const tools::Spread ms = timed[r].cpu_ms();
    rows[r]["cpu_ms"] = ms.median;
    rows[r]["cpu_ms_min"] = ms.smallest;
    rows[r]["cpu_ms_max"] = ms.largest;
  }
  return rows;
}

/// Curves for each isovalue. Only for storage in whole numbers, at the last level, which is the
/// most exact one.
Figure figure_of(const std::vector<Json>& rows, const std::string& name, const char* column, const Axis& y) {
  Figure figure{.name = name, .x = {.label = "bits of a sample", .is_logarithmic = false}, .y = y, .curves = {}};
  std::vector<double> isovalues;
  for (const Json& row : rows)
    if (const double isovalue = row["isovalue"]; isovalues.empty() || isovalues.back() != isovalue)
      isovalues.push_back(isovalue);
  for (const double isovalue : isovalues)
    for (const bool is_p99 : {false, true}) {
      Curve curve{concat("isovalue ", rounded(isovalue, 6), is_p99 ? ", 99 % of pixels" : ", median"), {}, is_p99};
      const std::string key = concat(column, is_p99 ? "_p99_" : "_median_", name == normal_figure ? "deg" : "cells");
      for (const Json& row : rows)
        if (row["isovalue"] == isovalue && row["whole_numbers"] == true && row["level"] == rows.back()["level"] &&
            row[key].is_number())
          curve.points.push_back({row["bits"], row[key], {}});
      figure.curves.push_back(std::move(curve));
    }
  return figure;
}

int run(const Settings& settings) {
  require_publishable(settings.common, {table_name});
  require_publishable_figures(settings.common, {depth_figure, normal_figure});
  require_within("--repeat", settings.rounds.rounds, 1, 10'000);
  require_within("--judge-seconds", settings.judge_seconds, 0, 1e6);
  tools::Table table{table_name, "An isosurface of a field stored in fewer bits", {}, {}};
  {
    tools::ProgressDisplay display(settings.common);
    const tools::ScratchFolder scratch(settings.scratch);
    display.show("reading and packing");
    const preprocess::NeutralVolume grid = plain_grid(settings.input, settings.field);
    Forms forms(scratch.path());
    forms.add_original(grid);
    const formats::FieldSummary field = forms.all()[0].dataset.field();
    if (field.no_data_count > 0 || !(field.range.hi > field.range.lo))
      throw Error(ErrorCode::usage, concat(settings.input.string(), ": the field is the same everywhere or has gaps; ",
                                           "expected one that whole numbers can hold"));
    for (const Storage& storage : storages()) {
      display.show(concat("packing ", storage.name));
      forms.add(storage, grid, field.range);
    }
    const Index3 n = grid.sample_count;
    table.context = context_with({{"input", settings.input.filename().string()},
                                  {"field", field.name},
                                  {"type", formats::element_name(grid.type)},
                                  {"range", {field.range.lo, field.range.hi}},
                                  {"samples", {n.x, n.y, n.z}},
                                  {"view", settings.view},
                                  {"size", {settings.size.width, settings.size.height}},
                                  {"machine", render::name_of(render::chosen_machine())},
                                  {"repeat", settings.rounds.rounds},
                                  {"seed", settings.seed}});
    for (const std::string& text : settings.isovalues)
      for (Json& row : rows_of(settings, forms, render::choose_isovalue(text, field).value,
                               [&](const std::string& what) { display.show(what); }))
        table.rows.push_back(std::move(row));
  }
  publish(table, settings.common);
  publish({figure_of(table.rows, depth_figure, "depth", {.label = "depth error, cells"}),
           figure_of(table.rows, normal_figure, "normal", {.label = "angle between normals, degrees"})},
          settings.common);
  return 0;
}

}  // namespace

tools::Subcommand bits() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "bits",
      .summary = "An isosurface of a grid whose samples are stored in fewer bits",
      .examples = {"rhoray-study bits smooth.rho --iso 600.5,2200.5 -o results"},
      .sections = {{.heading = "Notes",
                    .entries = {{"",
                                 "Errors are against the exact answer of the field as it is; storages that lose "
                                 "nothing are left out."}}}},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid", settings->input)},
           tools::output_options(settings->common, "FOLDER for bits.csv, .json and two figures (.svg)"),
           {tools::value_option("--iso", "V[,V]", "Isovalues, as in render; default auto", settings->isovalues),
            tools::value_option("--field", "NAME", "Field; default the first", settings->field),
            tools::value_option("--levels", "NAME[,NAME]", "As render's --accuracy; default float,double",
                                settings->levels),
            tools::value_option("--view", "NAME", "front, from-feet, close-up or inside; default front",
                                settings->view),
            tools::value_option("--size", "WxH", "Pixels; default 512x512", settings->size),
            tools::value_option("--judge-seconds", "S",
                                "Pixels are judged in random order until this time is over; default 60",
                                settings->judge_seconds),
            tools::value_option("--seed", "N", "Of that order; default 1", settings->seed),
            tools::value_option("--repeat", "N", "Rounds; default 5", settings->rounds.rounds),
            tools::value_option("--scratch", "FOLDER", "For the copies", settings->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

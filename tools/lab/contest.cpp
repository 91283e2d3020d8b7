#include "tools/lab/contest.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "formats/base/nearest_name.h"
#include "formats/base/parallel.h"
#include "formats/base/read_value.h"
#include "preprocess/input_file.h"
#include "render/isovalue.h"
#include "render/scene_spec.h"
#include "tools/lab/peers/ours.h"
#include "tools/lab/picture_errors.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/cli/progress_display.h"

namespace rhoray::study {

double cpu_ms_of(const std::function<void()>& act) {
  return 1e3 * tools::CpuMeter().measure(act).cpu_s;
}

bool ContestSettings::wants(const std::string& system) const {
  return systems.empty() || std::find(systems.begin(), systems.end(), system) != systems.end();
}

namespace {

using Tell = std::function<void(const std::string&)>;

std::string listed(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += list.empty() ? word : ", " + word;
  return list;
}

/// Anonymous memory of this process: neither mapped files nor memory returned to the operating
/// system.
double anonymous_mb() {
  std::ifstream lines("/proc/self/status");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("RssAnon:")) return std::strtod(line.c_str() + 8, nullptr) / 1024;
  return 0;
}

/// Limits the other systems (on oneTBB) and our own loops to one thread during its lifetime.
struct OneThread {
  tbb::global_control of_peers{tbb::global_control::max_allowed_parallelism, 1};
  ThreadLimit ours{1};
};

/// One system with the cost of its preparation.
struct Entrant {
  Peer& peer;
  Preparation preparation;
  /// Memory of the prepared data: as the library counts it, or the growth of the process.
  double memory_mb;
};

std::vector<Entrant> prepare(const Contest& contest, const Subject& subject, double isovalue,
                             const PeerView& first_view, const Tell& tell) {
  std::vector<Entrant> entrants;
  for (const PeerPointer& peer : contest.peers) {
    tell("preparing " + peer->name());
    const double before_mb = anonymous_mb();
    const Preparation preparation = peer->prepare(subject.data, isovalue);
    PeerView small = first_view;
    small.width = std::min(small.width, 64);
    small.height = std::min(small.height, 64);
    peer->draw(small);
    entrants.push_back({*peer, preparation, peer->prepared_mb().value_or(anonymous_mb() - before_mb)});
  }
  return entrants;
}

double ms_of(const std::vector<TimedRow>& rows, const std::string& name) {
  for (const TimedRow& row : rows)
    if (row.name == name) return row.cpu_ms().median;
  return 0;
}

/// @param own_ms  of the level with which others are compared
Json speed_of(const TimedRow& row, double own_ms, const PeerView& view, const Entrant& entrant) {
  const tools::Spread ms = row.cpu_ms();
  const double rays = static_cast<double>(view.pixel_count());
  return {{"cpu_ms", ms.median},
          {"cpu_ms_min", ms.smallest},
          {"cpu_ms_max", ms.largest},
          {"times", row.costs.size()},
          {"cycles_per_ray", row.median_cycles() / rays},
          {"million_rays_per_s", rays / ms.median / 1e3},
          {"over_ours", own_ms > 0 ? Json(ms.median / own_ms) : Json()},
          {"once_ms", entrant.preparation.once_ms},
          {"extraction_ms", entrant.preparation.extraction_ms},
          {"build_ms", entrant.preparation.build_ms},
          {"memory_mb", std::max(entrant.memory_mb, 0.0)}};
}

Json json_of(const DepthErrors& errors, const std::string& unit) {
  const auto known = [&](double value) { return errors.has_depth ? Json(value) : Json(); };
  return {{"covered", static_cast<double>(errors.hits) / static_cast<double>(errors.rays)},
          {"hits", errors.hits},
          {"missed", errors.missed},
          {"false", errors.invented},
          {concat("error_median_", unit, "s"), known(errors.median)},
          {concat("error_p99_", unit, "s"), known(errors.p99)},
          {concat("error_largest_", unit, "s"), known(errors.largest)},
          {concat("share_above_1_", unit), known(errors.share_above_1)}};
}

Json json_of(const LevelErrors& errors) {
  return {{"with_data", errors.with_data},
          {"missed", errors.missed},
          {"false", errors.invented},
          {"error_mean_levels", errors.mean},
          {"error_p99_levels", errors.p99},
          {"error_largest_levels", errors.largest},
          {"share_above_1_level", errors.share_above_1}};
}

/// @param truth  the level against which errors are measured
Json context_of(const ContestSettings& settings, const Subject& subject, const Contest& contest,
                const std::string& truth) {
  Json systems = Json::object();
  for (const PeerPointer& peer : contest.peers) systems[peer->name()] = peer->does();
  Json context{{"input", settings.input.filename().string()},
               {"size", {settings.size.width, settings.size.height}},
               {"threads", 1},
               {"repeat", settings.rounds.rounds},
               {"cycles", cycles_source()},
               {"truth", truth},
               {"systems", systems},
               {"left_out", contest.left_out}};
  context.update(subject.about);
  return context_with(context);
}

void say_left_out(const Contest& contest, const ContestSettings& settings) {
  for (const auto& [system, reason] : contest.left_out.items())
    tools::say(settings.common, concat("left out: ", system, ": ", reason.get<std::string>()));
}

PeerView view_of(const Subject& subject, tools::StudyView view, std::optional<double> isovalue,
                 const render::PictureSize& size) {
  return {.camera = tools::study_camera(view, subject.dataset, isovalue, double{1} * size.width / size.height),
          .width = size.width,
          .height = size.height};
}

/// One query, answered by all contestants from every view.
struct Heat {
  const ContestSettings& settings;
  const Subject& subject;
  const Tell& tell;
  std::optional<double> isovalue;  ///< nothing: largest values
  PeerPointer judge;
  std::string own_level;  ///< the time of this level is the reference for others

  /// Appends a row for each contestant and view.
  void run(const Contest& contest, tools::Table& table) {
    std::vector<Entrant> entrants;
    {
      const OneThread limit;
      judge->prepare(subject.data, isovalue.value_or(0));
      entrants = prepare(contest, subject, isovalue.value_or(0),
                         view_of(subject, subject.views[0], isovalue, settings.size), tell);
    }
    for (const tools::StudyView named : subject.views) {
      const PeerView view = view_of(subject, named, isovalue, settings.size);
      const std::string what = concat(isovalue ? concat("isovalue ", *isovalue) : "mip", ", ", name_of(named));
      tell(what + ", the exact answer");
      const std::vector<double> truth = judge->answers(view);
      const std::vector<TimedRow> rows = [&] {
        const OneThread limit;
        return time_all(entrants, view, what);
      }();
      for (std::size_t r = 0; r < rows.size(); ++r) {
        Peer& peer = entrants[r].peer;
        Json row = Json::object();
        if (isovalue) row["isovalue"] = concat(*isovalue);
        row.update({{"view", name_of(named)}, {"system", peer.name()}});
        row.update(speed_of(rows[r], ms_of(rows, own_level), view, entrants[r]));
        // Of the timed picture: answers() makes another afterwards.
        const std::string picture = peer.picture_hash();
        row.update(errors_of(truth, peer.name() == judge->name() ? truth : peer.answers(view)));
        row["picture"] = picture.empty() ? Json() : Json(picture);
        table.rows.push_back(std::move(row));
      }
    }
  }

 private:
  std::vector<TimedRow> time_all(const std::vector<Entrant>& entrants, const PeerView& view, const std::string& what) {
    std::vector<TimedRow> rows;
    for (const Entrant& entrant : entrants)
      rows.push_back({.name = entrant.peer.name(), .act = [&entrant, &view] { entrant.peer.draw(view); }});
    run_rounds(rows, settings.rounds, [&](const std::string& step) { tell(concat(what, ", ", step)); });
    return rows;
  }

  Json errors_of(std::span<const double> truth, std::span<const double> found) const {
    if (isovalue) return json_of(depth_errors(truth, found, subject.unit), subject.unit_name);
    const Interval<double>& range = subject.data.range;
    return json_of(level_errors(truth, found, range.hi - range.lo));
  }
};

tools::Table isosurface_table(const ContestSettings& settings, const Subject& subject, const std::string& name,
                              const std::function<Contest()>& contestants, const Tell& tell) {
  tools::Table table{name + "_isosurface", "Isosurfaces: CPU time of one thread, and errors", {}, {}};
  for (const double isovalue : subject.isovalues) {
    const Contest contest = contestants();
    if (table.rows.empty()) say_left_out(contest, settings);
    table.context = context_of(settings, subject, contest, settings.truth);
    Heat{settings, subject, tell, isovalue, own_isosurface(settings.truth), "Rhoray, float"}.run(contest, table);
  }
  return table;
}

tools::Table largest_value_table(const ContestSettings& settings, const Subject& subject, const std::string& name,
                                 const std::function<Contest()>& contestants, const Tell& tell) {
  // Exact arithmetic takes hours for large data. Certified answers carry a bound far below the
  // compared errors.
  const std::string truth = "certified";
  tools::Table table{name + "_mip", "Largest values along rays: CPU time of one thread, and errors", {}, {}};
  const Contest contest = contestants();
  say_left_out(contest, settings);
  table.context = context_of(settings, subject, contest, truth);
  Heat{settings, subject, tell, {}, own_largest_values(truth), "Rhoray, double"}.run(contest, table);
  return table;
}

}  // namespace

std::vector<tools::Option> contest_options(ContestSettings& settings, const std::vector<std::string>& systems,
                                           const std::string& tables) {
  return tools::all_options(
      {tools::output_options(settings.common, concat("FOLDER for ", tables, ", .csv and .json")),
       {tools::value_option("--iso", "V[,V]", "Isovalues, as in render; default auto", settings.isovalues),
        tools::flag_option("--mip", "Also largest values", settings.mip),
        tools::flag_option("--no-iso", "No isosurfaces", settings.no_isosurfaces),
        tools::value_option("--views", "NAME[,NAME]", "Of front, from-feet, close-up and inside; default all",
                            settings.views),
        tools::value_option("--systems", "NAME[,NAME]", concat("Of ", listed(systems), "; default all that were built"),
                            settings.systems),
        tools::choice_option("--truth", {"exact", "certified"},
                             "What isosurfaces are measured against: every ray judged exactly, or certified, which "
                             "largest values always are",
                             settings.truth),
        tools::value_option("--field", "NAME", "Field; default the first", settings.field),
        tools::value_option("--size", "WxH", "Pixels; default 512x512", settings.size),
        tools::value_option("--repeat", "N", "Rounds; default 5", settings.rounds.rounds),
        tools::value_option("--row-seconds", "S", "What has taken so much CPU time is not timed again; default 8",
                            settings.rounds.row_seconds),
        tools::flag_option("-q,--quiet", "Do not say what is left out", settings.common.quiet),
        tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings.common.progress)}});
}

void prepare_contest(const ContestSettings& settings, const std::vector<std::string>& systems,
                     const std::string& name) {
  require_within("--repeat", settings.rounds.rounds, 1, 10'000);
  require_within("--row-seconds", settings.rounds.row_seconds, 0, 1e6);
  for (const std::string& system : settings.systems)
    if (std::find(systems.begin(), systems.end(), system) == systems.end())
      throw Error(ErrorCode::usage, concat("--systems: found '", system, "'; expected ", listed(systems)),
                  did_you_mean(system, systems));
  preprocess::require_input(settings.input);
  if (!settings.no_isosurfaces) require_publishable(settings.common, {name + "_isosurface"});
  if (settings.mip) require_publishable(settings.common, {name + "_mip"});
  ::setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);
  ::setenv("VTK_SMP_MAX_THREADS", "1", 1);
  ::setenv("LP_NUM_THREADS", "0", 1);  // Mesa's software renderer
}

Subject::Subject(const ContestSettings& settings, const PeerData& given, double unit_length,
                 const std::string& unit_word)
    : data(given),
      dataset(render::Dataset::load(data.packed_file, data.field)),
      unit(unit_length),
      unit_name(unit_word) {
  data.bounds = dataset.bounds();
  data.range = dataset.field().range;
  for (const std::string& isovalue : settings.isovalues)
    isovalues.push_back(render::choose_isovalue(isovalue, dataset.field()).value);
  for (const std::string& view : settings.views) views.push_back(tools::study_view_named(view));
}

void run_contest(const ContestSettings& settings, const Subject& subject, const std::string& name,
                 const std::function<Contest()>& isosurfaces, const std::function<Contest()>& largest) {
  const auto show = [&](auto&& table_of, const std::function<Contest()>& contestants) {
    const tools::Table table = [&] {
      tools::ProgressDisplay display(settings.common);
      return table_of(settings, subject, name, contestants, [&](const std::string& what) { display.show(what); });
    }();
    publish(table, settings.common);
  };
  if (!settings.no_isosurfaces) show(isosurface_table, isosurfaces);
  if (settings.mip) show(largest_value_table, largest);
}

}  // namespace rhoray::study

// Isosurfaces and largest values of one grid, by this renderer and by other programs' libraries, in one run: the same
// samples, cameras and pixels, one thread, and every picture against the exact answer.

#include "tools/study/peers_grid.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "formats/base/nearest_name.h"
#include "preprocess/pack_volume.h"
#include "tools/rhoray/input_file.h"
#include "tools/rhoray/interrupt.h"
#include "tools/rhoray/picture_plan.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/views.h"
#include "tools/study/peers/ours.h"
#include "tools/study/peers/triangles.h"
#include "tools/study/peers/vdb.h"
#include "tools/study/picture_errors.h"
#include "tools/study/plain_grid.h"
#include "tools/study/rounds.h"
#include "tools/study/study_run.h"
#ifdef RHORAY_WITH_EMBREE
#include "tools/study/peers/embree_triangles.h"
#endif
#ifdef RHORAY_WITH_VTK_RENDERING
#include "tools/study/peers/vtk_rendering.h"
#endif

namespace rhoray::study {

double cpu_ms_of(const std::function<void()>& act) {
  return 1e3 * tools::CpuMeter().measure(act).cpu_s;
}

namespace {

using tools::Json;

struct Wishes {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field;
  std::vector<std::string> isovalues{"auto"};
  std::vector<std::string> views{"front", "from-feet", "close-up", "inside"};
  std::vector<std::string> systems;  ///< empty = all
  bool mip = false, no_isosurfaces = false;
  std::string truth = "exact";
  tools::PictureSize size{512, 512};
  RoundsOptions rounds;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

/// The systems that answer one question, and those that cannot run here with the reason.
struct Contest {
  std::vector<PeerPointer> peers;
  Json left_out = Json::object();
};

const std::vector<std::string> system_words{"ours", "embree", "nanovdb", "openvdb", "vtk"};

bool is_wanted(const Wishes& wishes, const std::string& word) {
  return wishes.systems.empty() ||
         std::find(wishes.systems.begin(), wishes.systems.end(), word) != wishes.systems.end();
}

const char* const own_levels[] = {"preview", "float", "default", "certified", "exact"};

Contest isosurface_contest(const Wishes& wishes) {
  Contest contest;
  const auto add = [&](PeerPointer peer) { contest.peers.push_back(std::move(peer)); };
  if (is_wanted(wishes, "ours"))
    for (const char* level : own_levels) add(own_isosurface(level));
  const auto triangles = std::make_shared<Triangles>();
#ifdef RHORAY_WITH_EMBREE
  if (is_wanted(wishes, "embree")) {
    const auto scene = embree_scene(triangles);
    add(embree_packets(scene));
    add(embree_single_rays(scene));
  }
#else
  if (is_wanted(wishes, "embree")) contest.left_out["Embree"] = "not built: install libembree-dev";
#endif
  if (is_wanted(wishes, "nanovdb")) {
    add(nanovdb_dense());
    add(nanovdb_narrow());
  }
  if (is_wanted(wishes, "openvdb")) add(openvdb_level_set());
#ifdef RHORAY_WITH_VTK_RENDERING
  if (is_wanted(wishes, "vtk")) {
    if (const std::string reason = no_display(); !reason.empty())
      contest.left_out["VTK, drawing"] = reason;
    else
      add(vtk_drawing(triangles));
  }
#else
  if (is_wanted(wishes, "vtk")) contest.left_out["VTK, drawing"] = "not built: install libvtk9-dev with its rendering";
#endif
  return contest;
}

Contest largest_value_contest(const Wishes& wishes) {
  Contest contest;
  if (is_wanted(wishes, "ours"))
    for (const char* level : {"float", "default", "certified"}) contest.peers.push_back(own_largest_values(level));
#ifdef RHORAY_WITH_VTK_RENDERING
  if (is_wanted(wishes, "vtk"))
    for (const double step : {1.0, 0.5, 0.1}) contest.peers.push_back(vtk_largest_values(step));
#else
  if (is_wanted(wishes, "vtk"))
    contest.left_out["VTK, largest values"] = "not built: install libvtk9-dev with its rendering";
#endif
  return contest;
}

/// Anonymous memory of this process: what is neither a mapped file nor given back to the system.
double anonymous_mb() {
  std::ifstream lines("/proc/self/status");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("RssAnon:")) return std::strtod(line.c_str() + 8, nullptr) / 1024;
  return 0;
}

/// The data as the systems get it, and what is shown of it.
struct Subject {
  preprocess::NeutralVolume grid;
  std::filesystem::path packed_file;
  render::Volume volume;
  std::vector<double> isovalues;
  std::vector<tools::StudyView> views;

  PeerData data() const { return {.grid = grid, .range = volume.field().range, .packed_file = packed_file}; }
  double voxel() const {
    const Vec3 spacing = spacing_of(grid);
    return std::cbrt(spacing.x * spacing.y * spacing.z);
  }
  PeerView view(tools::StudyView view, std::optional<double> isovalue, const tools::PictureSize& size) const {
    return {.camera = tools::study_camera(view, volume, isovalue, double{1} * size.width / size.height),
            .width = size.width,
            .height = size.height};
  }
};

Subject subject_of(const Wishes& wishes, const std::filesystem::path& scratch) {
  preprocess::NeutralVolume grid = plain_grid(wishes.input, wishes.field);
  const std::filesystem::path file = scratch / "grid.rho";
  preprocess::pack_volume(grid, file);
  Subject subject{
      .grid = std::move(grid), .packed_file = file, .volume = render::Volume::load(file), .isovalues = {}, .views = {}};
  subject.grid.samples = subject.grid.owned_samples;
  for (const std::string& isovalue : wishes.isovalues)
    subject.isovalues.push_back(tools::choose_isovalue(isovalue, subject.volume.field()).value);
  for (const std::string& view : wishes.views) subject.views.push_back(tools::study_view_named(view));
  return subject;
}

/// One system with what preparing it took.
struct Entrant {
  Peer& peer;
  Preparation preparation;
  double memory_mb;  ///< of what was prepared: as the library counts it, or by how much the process has grown
};

std::vector<Entrant> prepare(Contest& contest, const Subject& subject, double isovalue, const PeerView& first_view,
                             const std::function<void(const std::string&)>& tell) {
  std::vector<Entrant> entrants;
  for (const PeerPointer& peer : contest.peers) {
    tell("preparing " + peer->name());
    const double before_mb = anonymous_mb();
    const Preparation preparation = peer->prepare(subject.data(), isovalue);
    PeerView small = first_view;
    small.width = std::min(small.width, 64);
    small.height = std::min(small.height, 64);
    peer->draw(small);
    entrants.push_back({*peer, preparation, peer->prepared_mb().value_or(anonymous_mb() - before_mb)});
  }
  return entrants;
}

std::vector<TimedRow> time_all(const std::vector<Entrant>& entrants, const PeerView& view, const Wishes& wishes,
                               const std::string& what, const std::function<void(const std::string&)>& tell) {
  std::vector<TimedRow> rows;
  for (const Entrant& entrant : entrants)
    rows.push_back({.name = entrant.peer.name(), .act = [&entrant, &view] { entrant.peer.draw(view); }});
  run_rounds(rows, wishes.rounds, [&](const std::string& step) { tell(concat(what, ", ", step)); });
  return rows;
}

/// What rows of both tables have in common.
/// @param own_ms  of the level that others are compared with: float for isosurfaces, the default for largest values
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

double ms_of(const std::vector<TimedRow>& rows, const std::string& name) {
  for (const TimedRow& row : rows)
    if (row.name == name) return row.cpu_ms().median;
  return 0;
}

Json json_of(const DepthErrors& errors) {
  const auto known = [&](double value) { return errors.has_depth ? Json(value) : Json(); };
  return {{"covered", static_cast<double>(errors.hits) / static_cast<double>(errors.rays)},
          {"hits", errors.hits},
          {"missed", errors.missed},
          {"false", errors.invented},
          {"error_median_voxels", known(errors.median)},
          {"error_p99_voxels", known(errors.p99)},
          {"error_largest_voxels", known(errors.largest)},
          {"share_above_1_voxel", known(errors.share_above_1)}};
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

Json picture_of(const Peer& peer) {
  const std::string hash = peer.picture_hash();
  return hash.empty() ? Json() : Json(hash);
}

/// @param truth  the level that errors are measured against
Json context_of(const Wishes& wishes, const Subject& subject, const Contest& contest, const std::string& truth) {
  Json systems = Json::object();
  for (const PeerPointer& peer : contest.peers) systems[peer->name()] = peer->does();
  const Index3 n = subject.grid.sample_count;
  return context_with({{"input", wishes.input.filename().string()},
                       {"samples", {n.x, n.y, n.z}},
                       {"type", formats::element_name(subject.grid.type)},
                       {"size", {wishes.size.width, wishes.size.height}},
                       {"threads", 1},
                       {"repeat", wishes.rounds.rounds},
                       {"cycles", cycles_source()},
                       {"truth", truth},
                       {"systems", systems},
                       {"left_out", contest.left_out}});
}

void tell_left_out(const Contest& contest, const Wishes& wishes) {
  for (const auto& [system, reason] : contest.left_out.items())
    tools::say(wishes.common, concat("left out: ", system, ": ", reason.get<std::string>()));
}

using Tell = std::function<void(const std::string&)>;

tools::Table isosurface_table(const Wishes& wishes, const Subject& subject, const Tell& tell) {
  tools::Table table{"peers_isosurface", "Isosurfaces: CPU time of one thread, and errors", {}, {}};
  const PeerPointer judge = own_isosurface(wishes.truth);
  for (const double isovalue : subject.isovalues) {
    Contest contest = isosurface_contest(wishes);
    if (table.rows.empty()) {
      tell_left_out(contest, wishes);
      table.context = context_of(wishes, subject, contest, wishes.truth);
    }
    std::vector<Entrant> entrants;
    {
      const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
      judge->prepare(subject.data(), isovalue);
      entrants = prepare(contest, subject, isovalue, subject.view(subject.views[0], isovalue, wishes.size), tell);
    }
    for (const tools::StudyView named : subject.views) {
      const PeerView view = subject.view(named, isovalue, wishes.size);
      const std::string what = concat("isovalue ", isovalue, ", ", name_of(named));
      tell(what + ", the exact answer");
      const std::vector<double> truth = judge->answers(view);
      const std::vector<TimedRow> rows = [&] {
        const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
        return time_all(entrants, view, wishes, what, tell);
      }();
      for (std::size_t r = 0; r < rows.size(); ++r) {
        Peer& peer = entrants[r].peer;
        Json row{{"isovalue", concat(isovalue)}, {"view", name_of(named)}, {"system", peer.name()}};
        row.update(speed_of(rows[r], ms_of(rows, "Rhoray, float"), view, entrants[r]));
        const Json picture = picture_of(peer);
        const bool is_the_judge = peer.name() == judge->name();
        row.update(json_of(depth_errors(truth, is_the_judge ? truth : peer.answers(view), subject.voxel())));
        row["picture"] = picture;
        table.rows.push_back(std::move(row));
      }
    }
  }
  return table;
}

tools::Table largest_value_table(const Wishes& wishes, const Subject& subject, const Tell& tell) {
  Contest contest = largest_value_contest(wishes);
  tell_left_out(contest, wishes);
  tools::Table table{"peers_mip", "Largest values along rays: CPU time of one thread, and errors", {}, {}};
  // The judge takes hours for large data; what is certified carries a bound far below what is compared here.
  const PeerPointer judge = own_largest_values("certified");
  std::vector<Entrant> entrants;
  {
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    judge->prepare(subject.data(), 0);
    entrants = prepare(contest, subject, 0, subject.view(subject.views[0], {}, wishes.size), tell);
  }
  const double window = subject.data().range.hi - subject.data().range.lo;
  for (const tools::StudyView named : subject.views) {
    const PeerView view = subject.view(named, {}, wishes.size);
    const std::string what = concat("mip, ", name_of(named));
    tell(what + ", the exact answer");
    const std::vector<double> truth = judge->answers(view);
    const std::vector<TimedRow> rows = [&] {
      const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
      return time_all(entrants, view, wishes, what, tell);
    }();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      Peer& peer = entrants[r].peer;
      Json row{{"view", name_of(named)}, {"system", peer.name()}};
      row.update(speed_of(rows[r], ms_of(rows, "Rhoray, default"), view, entrants[r]));
      const Json picture = picture_of(peer);
      row.update(json_of(level_errors(truth, peer.answers(view), window)));
      row["picture"] = picture;
      table.rows.push_back(std::move(row));
    }
  }
  table.context = context_of(wishes, subject, contest, "certified");
  return table;
}

void check(const Wishes& wishes) {
  tools::require_within("--repeat", wishes.rounds.rounds, 1, 10'000);
  tools::require_within("--row-seconds", wishes.rounds.row_seconds, 0, 1e6);
  for (const std::string& system : wishes.systems)
    if (std::find(system_words.begin(), system_words.end(), system) == system_words.end())
      throw Error(Trouble::usage,
                  concat("--systems: found '", system, "'; expected ours, embree, nanovdb, openvdb, vtk"),
                  did_you_mean(system, system_words));
  tools::require_input(wishes.input);
}

/// One thread, for what reads it from the environment when it starts.
void ask_for_one_thread() {
  ::setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);
  ::setenv("VTK_SMP_MAX_THREADS", "1", 1);
  ::setenv("LP_NUM_THREADS", "0", 1);  // Mesa's software renderer
}

int run(const Wishes& wishes) {
  check(wishes);
  ask_for_one_thread();
  const tools::ScratchFolder scratch(wishes.scratch);
  const Subject subject = subject_of(wishes, scratch.path());
  const auto show = [&](tools::Table (*measure)(const Wishes&, const Subject&, const Tell&)) {
    const tools::Table table = [&] {
      tools::ProgressDisplay display(wishes.common);
      return measure(wishes, subject, [&](const std::string& what) { display.show(what); });
    }();
    publish(table, wishes.common);
  };
  if (!wishes.no_isosurfaces) show(isosurface_table);
  if (wishes.mip) show(largest_value_table);
  return 0;
}

}  // namespace

tools::Subcommand peers_grid() {
  const auto wishes = std::make_shared<Wishes>();
  return {
      .name = "peers-grid",
      .summary = "A grid's isosurfaces and largest values by this renderer and by others, in one run",
      .examples =
          "  rhoray-study peers-grid smooth.rho --iso 600.5,2200.5 --mip -o results\n"
          "  xvfb-run -a rhoray-study peers-grid smooth.rho --views front --systems ours,vtk\n"
          "VTK's drawing needs an X display; xvfb-run brings one where there is none.\n",
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid", wishes->input)},
           tools::output_options(wishes->common, "FOLDER for peers_isosurface and peers_mip, .csv and .json"),
           {tools::value_option("--iso", "V[,V]", "Isovalues, as in render; default auto", wishes->isovalues),
            tools::flag_option("--mip", "Also largest values", wishes->mip),
            tools::flag_option("--no-iso", "No isosurfaces", wishes->no_isosurfaces),
            tools::value_option("--views", "NAME[,NAME]", "Of front, from-feet, close-up and inside; default all",
                                wishes->views),
            tools::value_option("--systems", "NAME[,NAME]",
                                "Of ours, embree, nanovdb, openvdb and vtk; default all that were built",
                                wishes->systems),
            tools::choice_option("--truth", {"exact", "certified"},
                                 "What isosurfaces are measured against: every ray judged exactly, or certified, which "
                                 "largest values always are",
                                 wishes->truth),
            tools::value_option("--field", "NAME", "Field; default the first", wishes->field),
            tools::value_option("--size", "WxH", "Pixels; default 512x512", wishes->size),
            tools::value_option("--repeat", "N", "Rounds; default 5", wishes->rounds.rounds),
            tools::value_option("--row-seconds", "S", "What has taken so much CPU time is not timed again; default 8",
                                wishes->rounds.row_seconds),
            tools::value_option("--scratch", "FOLDER", "For the packed grid", wishes->scratch),
            tools::flag_option("-q,--quiet", "Do not say what is left out", wishes->common.quiet),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", wishes->common.progress)}}),
      .run = [wishes] { return run(*wishes); }};
}

}  // namespace rhoray::study

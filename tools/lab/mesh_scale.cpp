// How packing, a new isovalue and a frame scale with the number of tetrahedra, for a fixed picture.

#include "tools/lab/mesh_scale.h"

#include <tbb/global_control.h>

#include <algorithm>

#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "formats/base/read_value.h"
#include "formats/tet_mesh.h"
#include "preprocess/pack_mesh.h"
#include "render/isovalue.h"
#include "render/load.h"
#include "render/scene_spec.h"
#include "tools/lab/peers/ours.h"
#include "tools/lab/rounds.h"
#include "tools/lab/study_run.h"
#include "tools/lab/warped_box.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::study {

namespace {

struct Settings {
  tools::CommonOptions common;
  std::vector<std::string> cell_counts{"100000", "1000000", "10000000"};
  std::vector<std::string> levels{"float", "certified"};
  std::string view = "front";
  bool mip = false;
  render::PictureSize size{512, 512};
  RoundsOptions rounds;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

/// The result and the cost of packing.
struct Packed {
  std::uint64_t cells = 0, points = 0, bytes = 0, peak_bytes = 0;
  double cpu_s = 0, wall_s = 0;

  /// Without coordinates in double and one value in single precision for every point.
  double structure_bytes_per_cell() const {
    return (static_cast<double>(bytes) - 28.0 * static_cast<double>(points)) / static_cast<double>(cells);
  }
};

Packed pack_box(std::uint64_t cell_count, const std::filesystem::path& file, const Progress& progress) {
  const preprocess::NeutralMesh mesh = warped_box(edge_for(cell_count));
  const tools::Stopwatch watch;
  const double cpu_before = tools::usage_so_far().cpu_s;
  const preprocess::PackMeshReport report = preprocess::pack_mesh(mesh, file, {.replace_existing = true}, progress);
  const tools::Usage usage = tools::usage_so_far();
  return {.cells = report.description.cell_count,
          .points = report.description.point_count,
          .bytes = report.file_bytes,
          .peak_bytes = usage.peak_bytes,
          .cpu_s = usage.cpu_s - cpu_before,
          .wall_s = watch.seconds()};
}

/// CPU milliseconds of one thread for new isovalues: the additional time of their first pictures.
double new_isovalue_ms(Peer& peer, const PeerData& data, const Interval<double>& range) {
  std::vector<double> times;
  for (const double share : {0.35, 0.45, 0.55, 0.65, 0.75})
    times.push_back(peer.prepare(data, range.lo + share * (range.hi - range.lo)).build_ms);
  return tools::spread_of(times).median;
}

void add_rows(const Settings& settings, std::uint64_t cell_count, const std::filesystem::path& file,
              tools::ProgressDisplay& display, tools::Table& table) {
  const std::string size = grouped(cell_count);
  display.show(concat("making and packing ", size, " tetrahedra"));
  const Packed packed = pack_box(cell_count, file, {});
  const tbb::global_control one_thread_of_peers(tbb::global_control::max_allowed_parallelism, 1);
  const ThreadLimit one_thread(1);
  std::optional<render::Dataset> dataset;
  const double open_ms = cpu_ms_of([&] { dataset = render::Dataset::load(file); });
  PeerData data;
  data.packed_file = file;
  data.bounds = dataset->bounds();
  data.range = dataset->field().range;
  const double isovalue = render::choose_isovalue("auto", dataset->field()).value;
  const PeerView view{.camera = tools::study_camera(tools::study_view_named(settings.view), *dataset, isovalue,
                                                    double{1} * settings.size.width / settings.size.height),
                      .width = settings.size.width,
                      .height = settings.size.height};

  std::vector<PeerPointer> peers;
  for (const std::string& level : settings.levels) peers.push_back(own_isosurface(level));
  const std::size_t isosurface_count = peers.size();
  if (settings.mip) peers.push_back(own_largest_values("double"));
  std::vector<double> isovalue_ms;
  std::vector<TimedRow> rows;
  for (std::size_t p = 0; p < peers.size(); ++p) {
    isovalue_ms.push_back(p < isosurface_count ? new_isovalue_ms(*peers[p], data, data.range) : 0);
    peers[p]->prepare(data, isovalue);
    rows.push_back({.name = peers[p]->name(), .act = [&peer = *peers[p], &view] { peer.draw(view); }});
  }
  run_rounds(rows, settings.rounds, [&](const std::string& step) { display.show(concat(size, ", ", step)); });
  const double rays = static_cast<double>(view.pixel_count());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const tools::Spread ms = rows[r].cpu_ms();
    table.rows.push_back({{"cells", packed.cells},
                          {"points", packed.points},
                          {"file_mb", static_cast<double>(packed.bytes) / 1e6},
                          {"structure_bytes_per_cell", packed.structure_bytes_per_cell()},
                          {"pack_cpu_s", packed.cpu_s},
                          {"pack_wall_s", packed.wall_s},
                          {"cells_per_cpu_s", static_cast<double>(packed.cells) / packed.cpu_s},
                          {"peak_mb_so_far", static_cast<double>(packed.peak_bytes) / 1e6},
                          {"open_ms", open_ms},
                          {"shows", r < isosurface_count ? "isosurface" : "mip"},
                          {"level", rows[r].name},
                          {"new_isovalue_ms", r < isosurface_count ? Json(isovalue_ms[r]) : Json()},
                          {"frame_ms", ms.median},
                          {"frame_ms_min", ms.smallest},
                          {"frame_ms_max", ms.largest},
                          {"cycles_per_ray", rows[r].median_cycles() / rays}});
  }
}

int run(const Settings& settings) {
  require_publishable(settings.common, {"mesh_scale"});
  require_within("--repeat", settings.rounds.rounds, 1, 10'000);
  require_within("--row-seconds", settings.rounds.row_seconds, 0, 1e6);
  tools::Table table{"mesh_scale", "Meshes of growing size, the same picture: CPU time of one thread", {}, {}};
  table.context = context_with({{"view", settings.view},
                                {"size", {settings.size.width, settings.size.height}},
                                {"threads", "all in packing, 1 in frames"},
                                {"repeat", settings.rounds.rounds},
                                {"cycles", cycles_source()}});
  const tools::ScratchFolder scratch(settings.scratch);
  {
    tools::ProgressDisplay display(settings.common);
    for (const std::string& count : settings.cell_counts) {
      std::uint64_t cell_count = 0;
      tools::read_value(count, cell_count);
      require_within("--cells", static_cast<double>(cell_count), 6, 600e6);
      add_rows(settings, cell_count, scratch.path() / "box.rho", display, table);
    }
  }
  publish(table, settings.common);
  return 0;
}

}  // namespace

tools::Subcommand mesh_scale() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "mesh-scale",
      .summary = "Packing, a new isovalue and a frame for meshes of growing size",
      .examples = {"rhoray-study mesh-scale --cells 1000000,10000000,100000000 --mip -o results"},
      .options = tools::all_options(
          {tools::output_options(settings->common, "FOLDER for mesh_scale.csv and .json"),
           {tools::value_option("--cells", "N[,N]", "About so many; default 100000,1000000,10000000",
                                settings->cell_counts),
            tools::value_option("--levels", "NAME[,NAME]", "As render's --accuracy; default float,certified",
                                settings->levels),
            tools::flag_option("--mip", "Also largest values", settings->mip),
            tools::value_option("--view", "NAME", "front, from-feet, close-up or inside; default front",
                                settings->view),
            tools::value_option("--size", "WxH", "Pixels; default 512x512", settings->size),
            tools::value_option("--repeat", "N", "Rounds; default 5", settings->rounds.rounds),
            tools::value_option("--row-seconds", "S", "What has taken so much CPU time is not timed again; default 8",
                                settings->rounds.row_seconds),
            tools::value_option("--scratch", "FOLDER", "For the packed mesh", settings->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

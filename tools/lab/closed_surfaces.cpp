// Traces many rays at closed isosurfaces of grids and meshes, of many sizes and at many positions.
// Counts the errors of float, double and certified answers.

#include "tools/lab/closed_surfaces.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "formats/base/number_text.h"
#include "formats/base/parallel.h"
#include "formats/base/read_value.h"
#include "tools/lab/ray_tally.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"

namespace rhoray::study {
namespace {

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
  std::uint64_t rays = 1'000'000;
  std::int64_t edge = 20;
  std::uint64_t sample_every = 1000;
  std::uint64_t seed = 1;
  bool by_row = false;
};

struct Row {
  SceneKind kind;
  Placement placement;
  Aim aim;
  RayTally tally{};
};

std::vector<Row> all_rows() {
  const Vec3 centres[] = {Vec3(0), Vec3(1e3), Vec3(1e5), Vec3(148376, 1234, -223423)};
  std::vector<Row> rows;
  for (const SceneKind kind : scene_kinds)
    for (const Vec3& centre : centres)
      for (const double scale : {1e-6, 1.0, 1e6})
        for (const Aim aim : aims) rows.push_back({kind, {centre, scale}, aim});
  return rows;
}

constexpr std::uint64_t chunk_size = 2048;

/// Makes rays from one seed per chunk, so that the result does not depend on which thread works on
/// which chunk.
void fill(Row& row, const ClosedScene& scene, std::uint64_t first_seed, std::uint64_t ray_count,
          std::uint64_t sample_every, const std::function<void(std::uint64_t)>& tell_done) {
  const std::uint64_t chunks = (ray_count + chunk_size - 1) / chunk_size;
  std::vector<RayTally> parts(chunks);
  std::mutex telling;
  parallel_for_each(chunks, [&](std::uint64_t chunk) {
    const std::uint64_t count = std::min(chunk_size, ray_count - chunk * chunk_size);
    parts[chunk] = tally_rays(scene, row.aim, count, first_seed ^ chunk, sample_every);
    const std::scoped_lock lock(telling);
    tell_done(count);
  });
  for (const RayTally& part : parts) row.tally.add(part);
}

void measure(std::vector<Row>& rows, const Settings& settings) {
  const tools::ScratchFolder scratch(settings.scratch);
  tools::ProgressDisplay display(settings.common);
  std::optional<ClosedScene> scene;
  std::uint64_t done = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    Row& row = rows[r];
    if (row.aim == aims.front()) scene = closed_scene(row.kind, row.placement, settings.edge, scratch.path());
    const std::uint64_t share = settings.rays * (r + 1) / rows.size() - settings.rays * r / rows.size();
    fill(row, *scene, (settings.seed << 48) ^ (static_cast<std::uint64_t>(r) << 36), share, settings.sample_every,
         [&](std::uint64_t count) { display.show("tracing [rays]", done += count, settings.rays); });
  }
}

/// The columns of a tally; `what` describes its rays.
Json columns(const RayTally& tally, Json what) {
  const auto rate = [&](const RayTally::OfMethod& method) {
    return method.cpu_s == 0 ? 0.0 : static_cast<double>(method.rays) / method.cpu_s;
  };
  what["rays"] = tally.rays;
  what["hits"] = tally.hits;
  const auto add = [&](const std::string& name, const RayTally::OfMethod& method) {
    what[name + "_rays"] = method.rays;
    what[name + "_missed"] = method.missed;
    what[name + "_extra"] = method.extra;
    what[name + "_elsewhere"] = method.elsewhere;
    what[name + "_error_cells"] = method.largest_error;
    what[name + "_rays_per_s"] = rate(method);
  };
  add("float", tally.single);
  add("double", tally.float64);
  add("certified", tally.certified);
  what["bound_cells"] = tally.largest_bound;
  what["bound_broken"] = tally.bound_broken;
  what["redone"] = tally.redone;
  what["judged"] = tally.judged;
  what["redecided"] = tally.redecided;
  what["touches"] = tally.touches;
  what["odd"] = tally.odd;
  what["miscounted"] = tally.miscounted;
  return what;
}

std::string text_of(const Vec3& centre) {
  return centre.x == centre.y && centre.y == centre.z ? rounded(centre.x)
                                                      : concat(centre.x, " ", centre.y, " ", centre.z);
}

/// Every row, or the sums for each kind of scene and way to aim, and for all.
std::vector<Json> table_rows(const std::vector<Row>& rows, bool by_row) {
  std::vector<Json> out;
  if (by_row) {
    for (const Row& row : rows)
      out.push_back(columns(row.tally, {{"scene", name_of(row.kind)},
                                        {"centre", text_of(row.placement.centre)},
                                        {"scale", row.placement.scale},
                                        {"aim", name_of(row.aim)}}));
    return out;
  }
  RayTally all;
  for (const SceneKind kind : scene_kinds)
    for (const Aim aim : aims) {
      RayTally sum;
      for (const Row& row : rows)
        if (row.kind == kind && row.aim == aim) sum.add(row.tally);
      out.push_back(columns(sum, {{"scene", name_of(kind)}, {"aim", name_of(aim)}}));
      all.add(sum);
    }
  out.push_back(columns(all, {{"scene", "all"}, {"aim", "all"}}));
  return out;
}

int run(const Settings& settings) {
  require_within("--rays", static_cast<double>(settings.rays), 1, 1e11);
  require_within("--edge", static_cast<double>(settings.edge), 4, 256);
  require_within("--sample", static_cast<double>(settings.sample_every), 1, 1e12);
  require_publishable(settings.common, {"closed_surfaces"});
  require_within("--seed", static_cast<double>(settings.seed), 0, 65535);
  const ThreadLimit limit(settings.common.threads);
  const tools::Stopwatch watch;
  std::vector<Row> rows = all_rows();
  measure(rows, settings);

  tools::Table table{"closed_surfaces", "Rays at closed isosurfaces", {}, table_rows(rows, settings.by_row)};
  table.context = context_with({{"edge", settings.edge},
                                {"sample_every", settings.sample_every},
                                {"seed", settings.seed},
                                {"wall_s", watch.seconds()}});
  publish(table, settings.common);
  bool is_right = true;
  for (const Row& row : rows) {
    const RayTally::OfMethod& certified = row.tally.certified;
    is_right =
        is_right &&
        certified.missed + certified.extra + certified.elsewhere + row.tally.bound_broken + row.tally.miscounted == 0;
    for (const std::string& complaint : row.tally.complaints)
      std::fputs(concat(name_of(row.kind), ", centre ", text_of(row.placement.centre), ", scale ", row.placement.scale,
                        ", ", complaint, "\n")
                     .c_str(),
                 stderr);
  }
  return is_right ? 0 : static_cast<int>(ErrorCode::outside_limit);
}

}  // namespace

tools::Subcommand closed_surfaces() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "closed-surfaces",
      .summary = "Many rays at closed isosurfaces: float, double and certified against the truth",
      .examples = {"rhoray-study closed-surfaces --rays 10000000 -o results"},
      .sections =
          {{.heading = "Notes",
            .entries =
                {{"",
                  "Wavy balls in jittered tetrahedra and noisy ones in grids, also with values in coarse steps so that "
                  "vertices, edges and faces lie at the isovalue; centres at 0, 1e3, 1e5 and (148376, 1234, -223423), "
                  "scales 1e-6, 1 and 1e6; a third of the rays anywhere, a third at edges, a third at vertices; half "
                  "aimed in the volume's frame, half in the world. The truth is what certified says, or the judge, "
                  "who decides again every ray"},
                 {"", "- for which double decides otherwise, or finds another place (1e-6 cells and the bound);"},
                 {"",
                  "- that changes side an odd number of times between its ends, both outside: further changes are "
                  "looked for in double from 0.001 cells behind each; in odd rays certified and the judge follow all "
                  "of them (miscounted: they differ);"},
                 {"", "- of a random sample."},
                 {"",
                  "Float is asked for one ray in eight. The same rays come out for any number of threads, others for "
                  "another seed. Exit code 6 when certified missed, saw too much, was elsewhere, broke its bound or "
                  "was miscounted."}}}},
      .options = tools::all_options(
          {tools::output_options(settings->common, "FOLDER for closed_surfaces.csv and .json"),
           {tools::value_option("--scratch", "FOLDER", "For the packed volumes", settings->scratch),
            tools::value_option("--rays", "N", "In all; default 1000000", settings->rays),
            tools::value_option("--edge", "N", "Cells along a volume; default 20", settings->edge),
            tools::value_option("--sample", "N", "Decide one ray in N again, at random; default 1000",
                                settings->sample_every),
            tools::flag_option("--by-row", "A row for each centre and scale, too", settings->by_row),
            tools::value_option("--seed", "N", "Of the random numbers, 0 to 65535; default 1", settings->seed)},
           tools::threads_option(settings->common),
           {tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

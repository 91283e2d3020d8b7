#include "tools/lab/structures.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "formats/base/number_text.h"
#include "formats/base/read_value.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "render/isovalue.h"
#include "render/ray_caster.h"
#include "render/scene_spec.h"
#include "tools/lab/rounds.h"
#include "tools/lab/structures/made_meshes.h"
#include "tools/lab/structures/ways.h"
#include "tools/lab/study_run.h"
#include "tools/lab/warped_box.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::study {
namespace {

using preprocess::NeutralMesh;
using render::Hit;
using render::Ray;

struct Settings {
  tools::CommonOptions common;
  std::vector<std::string> inputs;
  std::uint64_t cells = 200'000;
  std::string isovalue = "auto";
  render::PictureSize size{256, 256};
  int repeat = 3;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

struct NamedMesh {
  std::string name;
  std::function<NeutralMesh()> make;
};

std::vector<NamedMesh> meshes_of(const Settings& settings) {
  const std::int64_t edge = edge_for(settings.cells);
  std::vector<NamedMesh> meshes{{"uniform", [=] { return warped_box(edge); }}};
  for (const int orders : {2, 4, 6})
    meshes.push_back({concat("graded over 10^", orders), [=] { return graded(warped_box(edge), orders); }});
  meshes.push_back({"slivers", [=] { return with_slivers(warped_box(edge), edge); }});
  for (const std::filesystem::path input : settings.inputs)
    meshes.push_back({input.stem().string(), [=] { return preprocess::import_mesh(input); }});
  return meshes;
}

double per(double amount, std::uint64_t count) {
  return amount / static_cast<double>(count);
}

/// Hash of t, cell and gradient of every hit, and of misses; 16 hexadecimal digits (XXH3).
std::string hash_of(std::span<const Hit> hits) {
  std::vector<double> numbers;
  for (const Hit& hit : hits)
    numbers.insert(numbers.end(),
                   {hit.t, static_cast<double>(hit.cell), hit.gradient.x, hit.gradient.y, hit.gradient.z});
  char text[17];
  std::snprintf(text, sizeof text, "%016llx",
                static_cast<unsigned long long>(XXH3_64bits(numbers.data(), numbers.size() * sizeof(double))));
  return text;
}

/// The rays of one mesh, and the library's answers.
struct Asked {
  std::string mesh;
  double isovalue;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
};

Asked ask_library(const Settings& settings, const std::string& mesh, const render::Dataset& dataset) {
  const double isovalue = render::choose_isovalue(settings.isovalue, dataset.field()).value;
  const render::Camera camera = tools::study_camera(tools::study_view_named("front"), dataset, isovalue,
                                                    double{1} * settings.size.width / settings.size.height);
  Asked asked{mesh, isovalue, render::camera_rays(dataset, camera, settings.size.width, settings.size.height), {}};
  asked.hits.resize(asked.rays.size());
  render::RayCaster(dataset, isovalue, render::method_of(render::Accuracy::float64))
      .first_crossings(asked.rays, asked.hits);
  return asked;
}

/// The answers of one way, and its work.
struct Answered {
  std::vector<Hit> hits;
  render::KernelCounters counters;
};

Answered answer(const Way& way, const Asked& asked) {
  Answered answered{std::vector<Hit>(asked.rays.size()), {}};
  way.ask(asked.rays, answered.hits, answered.counters);
  return answered;
}

/// CPU microseconds per ray: the median of rounds in which all ways are timed one after the other.
std::vector<double> times_of(const Settings& settings, const std::vector<Way>& ways, const Asked& asked,
                             tools::ProgressDisplay& display) {
  std::vector<TimedRow> rows;
  std::vector<Hit> hits(asked.rays.size());
  for (const Way& way : ways)
    rows.push_back({.name = way.name, .act = [&way, &asked, &hits] {
                      render::KernelCounters counters;
                      way.ask(asked.rays, hits, counters);
                    }});
  run_rounds(rows, {.rounds = settings.repeat},
             [&](const std::string& doing) { display.show(concat(asked.mesh, ", ", doing)); });
  std::vector<double> times;
  for (const TimedRow& row : rows) times.push_back(1e3 * per(row.cpu_ms().median, asked.rays.size()));
  return times;
}

Json row_of(const Way& way, const Asked& asked, const Answered& answered, double us_per_ray) {
  const auto a_ray = [&](std::uint64_t count) { return per(static_cast<double>(count), asked.rays.size()); };
  return {{"mesh", asked.mesh},
          {"structure", way.name},
          {"bytes_per_cell", way.bytes_per_cell},
          {"times_named", way.named_per_cell},
          {"pack_cells_per_cpu_s", way.cells_per_cpu_s ? Json(*way.cells_per_cpu_s) : Json()},
          {"nodes_per_ray", a_ray(answered.counters.macrocells_visited)},
          {"regions_per_ray", a_ray(answered.counters.cells_visited)},
          {"tested_per_ray", a_ray(answered.counters.cells_solved)},
          {"cpu_us_per_ray", us_per_ray},
          {"answers", hash_of(answered.hits)}};
}

/// Adds rows of ways that must all give the library's answers.
/// @return  whether they do
bool add_rows(const Settings& settings, const std::vector<Way>& ways, const Asked& asked,
              tools::ProgressDisplay& display, tools::Table& table) {
  const std::vector<double> times = times_of(settings, ways, asked, display);
  bool is_same = true;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    table.rows.push_back(row_of(ways[w], asked, answer(ways[w], asked), times[w]));
    is_same &= table.rows.back()["answers"] == hash_of(asked.hits);
  }
  return is_same;
}

double longest_edge(const formats::TetMesh& mesh, std::uint32_t cell) {
  double longest = 0;
  for (const std::uint32_t a : mesh.cell(cell))
    for (const std::uint32_t b : mesh.cell(cell)) {
      const std::array<double, 3>&p = mesh.points()[a], &q = mesh.points()[b];
      longest = std::max(longest, Vec3(p[0] - q[0], p[1] - q[1], p[2] - q[2]).length());
    }
  return longest;
}

/// Deviations of the answers from those for the original points, in longest edges of the hit cell.
/// A deviation of more than one edge is another sheet of the surface. Where the ray does not graze
/// the surface (sine of the angle between them above 0.1), it is a hole.
Json errors_of(const Asked& asked, const std::vector<Hit>& rounded, const formats::TetMesh& mesh) {
  std::uint64_t lost = 0, gained = 0, elsewhere = 0, holes = 0;
  std::vector<double> off_edges{0};
  for (std::size_t r = 0; r < rounded.size(); ++r) {
    const Hit &hit = asked.hits[r], &now = rounded[r];
    lost += !hit.is_miss() && now.is_miss();
    gained += hit.is_miss() && !now.is_miss();
    if (hit.is_miss()) continue;
    const double length = asked.rays[r].direction.length();
    const double off = std::abs(now.t - hit.t) * length / longest_edge(mesh, hit.tet);
    if (off <= 1) off_edges.push_back(off);
    elsewhere += !now.is_miss() && off > 1;
    const double slope = std::abs(hit.gradient.dot(asked.rays[r].direction)) / (hit.gradient.length() * length);
    holes += off > 1 && slope > 0.1;
  }
  const double sum = std::accumulate(off_edges.begin(), off_edges.end(), 0.0);
  return {{"lost", lost},
          {"gained", gained},
          {"elsewhere", elsewhere},
          {"holes", holes},
          {"off_mean_edges", sum / static_cast<double>(off_edges.size())},
          {"off_largest_edges", *std::max_element(off_edges.begin(), off_edges.end())}};
}

void add_rounded_rows(const Settings& settings, const MeshForWays& mesh, const Asked& asked,
                      tools::ProgressDisplay& display, tools::Table& table) {
  std::vector<Way> ways;
  std::vector<RoundedShape> shapes;
  for (const MeshForWays::RoundedWay& rounded : mesh.rounded(asked.isovalue))
    ways.push_back(rounded.way), shapes.push_back(rounded.shape);
  const std::vector<double> times = times_of(settings, ways, asked, display);
  for (std::size_t w = 0; w < ways.size(); ++w) {
    Json row{{"mesh", asked.mesh},
             {"points", ways[w].name},
             {"point_bytes_per_cell", ways[w].bytes_per_cell},
             {"cpu_us_per_ray", times[w]},
             {"folded_cells", shapes[w].folded_cells},
             {"split_points", shapes[w].split_points},
             {"widest_gap_edges", shapes[w].widest_gap_edges}};
    row.update(errors_of(asked, answer(ways[w], asked).hits, mesh.packed()));
    table.rows.push_back(row);
  }
}

int run(const Settings& settings) {
  require_within("--cells", static_cast<double>(settings.cells), 6, 1e9);
  require_within("--repeat", settings.repeat, 1, 10'000);
  for (const std::string& input : settings.inputs) preprocess::require_input(input);
  require_publishable(settings.common, {"structures", "structures_orders", "structures_points"});
  const tools::ScratchFolder scratch(settings.scratch);
  tools::Table shapes{
      "structures", "How rays find tetrahedra: bytes, packing, and first crossings on one thread", {}, {}};
  tools::Table orders{"structures_orders", "The same with lists and cells in other orders and forms", {}, {}};
  tools::Table points{"structures_points", "Clusters of 64 with points in fewer bytes, and what that moves", {}, {}};
  bool is_same_everywhere = true;
  {
    tools::ProgressDisplay display(settings.common);
    for (const NamedMesh& named : meshes_of(settings)) {
      display.show(concat("making ", named.name));
      const MeshForWays mesh(named.make(), scratch.path());
      const Asked asked = ask_library(settings, named.name, mesh.dataset());
      is_same_everywhere &= add_rows(settings, mesh.structures(asked.isovalue), asked, display, shapes);
      is_same_everywhere &= add_rows(settings, mesh.orders(asked.isovalue), asked, display, orders);
      add_rounded_rows(settings, mesh, asked, display, points);
    }
  }
  for (tools::Table* table : {&shapes, &orders, &points}) {
    table->context = context_with({{"isovalue", settings.isovalue},
                                   {"cells", settings.cells},
                                   {"size", {settings.size.width, settings.size.height}},
                                   {"threads", 1},
                                   {"repeat", settings.repeat}});
    publish(*table, settings.common);
  }
  if (!is_same_everywhere)
    throw Error(ErrorCode::outside_limit, "structures: a way answers otherwise than the library; see column 'answers'");
  return 0;
}

}  // namespace

tools::Subcommand structures() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "structures",
      .summary = "How rays find tetrahedra, and what that costs: lists, grids, trees, orders, rounded points",
      .examples = {"rhoray-study structures --cells 1000000 -o results"},
      .options = tools::all_options(
          {tools::output_options(settings->common, "FOLDER for structures*.csv and .json"),
           {tools::value_option("--meshes", "FILE[,FILE]", "Beside those that are made", settings->inputs),
            tools::value_option("--cells", "N", "Tetrahedra of those that are made; default 200000", settings->cells),
            tools::value_option("--iso", "V", "Isovalue, as in render; default auto", settings->isovalue),
            tools::value_option("--size", "WxH", "Pixels; default 256x256", settings->size),
            tools::value_option("--repeat", "N", "Pictures of each; default 3", settings->repeat),
            tools::value_option("--scratch", "FOLDER", "For the packed meshes", settings->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

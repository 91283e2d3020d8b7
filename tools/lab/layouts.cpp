// The cost of memory layouts of samples. The paper's Table 3 (initial; bricking; hierarchy and
// bricking, from four views), with rows for today's systems: edges of bricks, superbricks, factors
// of levels, types of samples, huge pages.

#include "tools/lab/layouts.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "formats/base/read_value.h"
#include "formats/brick_grid.h"
#include "preprocess/input_file.h"
#include "preprocess/pack_volume.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/render.h"
#include "render/scene_spec.h"
#include "tools/lab/huge_pages.h"
#include "tools/lab/plain_grid.h"
#include "tools/lab/rounds.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/bench/parts.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::study {
namespace {

using formats::ElementType;
using preprocess::PackVolumeOptions;
using preprocess::SampleOrder;

/// The settings of a picture; the same for every layout.
struct Shown {
  std::string isovalue = "auto";
  std::string accuracy = "double";
  render::PictureSize size{512, 512};
};

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field;
  Shown shown;
  std::vector<std::string> views{"front", "from-feet", "close-up", "inside"};
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
  RoundsOptions rounds;
  bool count_instructions = false;
  render::PictureSize count_size{96, 96};
};

/// One memory layout of the samples and a way to traverse them.
struct Layout {
  const char* name;
  PackVolumeOptions pack{};
  bool use_hierarchy = true;
  std::optional<ElementType> type{};  ///< of the samples, if not the data's own type
  bool huge_pages = false;
};

std::vector<Layout> all_layouts() {
  const PackVolumeOptions linear{.order = SampleOrder::linear};
  return {{.name = "initial", .pack = linear, .use_hierarchy = false},
          {.name = "bricking", .use_hierarchy = false},
          {.name = "hierarchy and bricking"},
          {.name = "hierarchy, linear", .pack = linear},
          {.name = "bricks of 2", .pack = {.brick_edge = 2}},
          {.name = "bricks of 8", .pack = {.brick_edge = 8}},
          {.name = "bricks of 16", .pack = {.brick_edge = 16}},
          {.name = "no superbricks", .pack = {.largest_superbrick = 1}},
          {.name = "six levels of 2", .pack = {.macro_factor = 2, .macro_level_count = 6}},
          {.name = "two levels of 8", .pack = {.macro_factor = 8, .macro_level_count = 2}},
          {.name = "8 bit", .type = ElementType::U8},
          {.name = "16 bit", .type = ElementType::U16},
          {.name = "32 bit float", .type = ElementType::F32},
          {.name = "huge pages", .huge_pages = true}};
}

/// A layout as a volume that is ready to be shown.
struct Entrant {
  Layout layout;
  std::filesystem::path file;
  render::Dataset dataset;
  double isovalue;
  std::uint64_t file_bytes;
  std::size_t huge_bytes = 0;
};

render::Scene scene_of(const Shown& shown, const render::Dataset& dataset, double isovalue, tools::StudyView view) {
  render::Scene scene;
  scene.layers[0].isovalue = isovalue;
  scene.layers[0].method = render::method_of(render::accuracy_named(shown.accuracy));
  scene.camera = tools::study_camera(view, dataset, isovalue, double{1} * shown.size.width / shown.size.height);
  return scene;
}

render::FrameOptions frame_of(const render::PictureSize& size, bool use_hierarchy) {
  return {.width = size.width, .height = size.height, .threads = 1, .use_hierarchy = use_hierarchy};
}

std::vector<Entrant> pack_all(const Settings& settings, const std::filesystem::path& folder,
                              const std::function<void(const std::string&)>& tell) {
  const preprocess::NeutralVolume grid = plain_grid(settings.input, settings.field);
  std::vector<Entrant> entrants;
  double isovalue = 0;
  Interval<double> range;
  for (const Layout& layout : all_layouts()) {
    // A row in the data's own type would repeat the one with which it is compared.
    if (layout.type == grid.type) continue;
    tell(concat("packing ", layout.name));
    const std::filesystem::path file = folder / concat(entrants.size(), ".rho");
    std::optional<preprocess::NeutralVolume> other;
    if (layout.type) other = converted(grid, *layout.type, range);
    const auto report = preprocess::pack_volume(other ? *other : grid, file, layout.pack);
    render::Dataset dataset = render::Dataset::load(file);
    if (entrants.empty()) {
      isovalue = render::choose_isovalue(settings.shown.isovalue, dataset.field()).value;
      range = dataset.field().range;
    }
    const double own_isovalue = layout.type ? converted_isovalue(isovalue, *layout.type, range) : isovalue;
    entrants.push_back({layout, file, std::move(dataset), own_isovalue, report.file_bytes});
    Entrant& entrant = entrants.back();
    if (layout.huge_pages) entrant.huge_bytes = move_to_huge_pages(entrant.dataset.file().bytes("samples"));
  }
  return entrants;
}

/// Instructions of one picture of the layout, counted by callgrind, and its cells; nothing when
/// they cannot be counted.
std::optional<double> counted_by_callgrind(const Settings& settings, const Entrant& entrant, const char* view,
                                           const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "callgrind.out", program = std::filesystem::read_symlink("/proc/self/exe");
  std::vector<std::string> words{"valgrind",
                                 "--tool=callgrind",
                                 "-q",
                                 "--callgrind-out-file=" + out.string(),
                                 "--toggle-collect=rhoray::render::render(*FrameMemory&)",
                                 program.string(),
                                 "one-frame",
                                 entrant.file.string(),
                                 "--iso",
                                 concat(entrant.isovalue),
                                 "--accuracy",
                                 settings.shown.accuracy,
                                 "--view",
                                 view,
                                 "--size",
                                 concat(settings.count_size.width, "x", settings.count_size.height)};
  if (!entrant.layout.use_hierarchy) words.push_back("--no-hierarchy");
  if (std::system((tools::shell_line(words) + " >/dev/null 2>&1").c_str()) != 0) return std::nullopt;
  std::ifstream lines(out);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("totals: ")) return std::strtod(line.c_str() + 8, nullptr);
  return std::nullopt;
}

/// Instructions of a picture, and the work in it by which they are divided.
struct Count {
  double instructions;
  render::FrameStatistics statistics;
};

std::optional<Count> count_of(const Settings& settings, const Entrant& entrant, const TimedRow& row,
                              const render::FrameStatistics& statistics, tools::StudyView view,
                              const std::filesystem::path& folder) {
  if (const auto counted = row.median_instructions()) return Count{*counted, statistics};
  // Valgrind's processor lacks instructions that wide kernels need: other kernels would answer.
  if (!settings.count_instructions || statistics.machine != "scalar") return std::nullopt;
  const auto counted = counted_by_callgrind(settings, entrant, tools::name_of(view), folder);
  if (!counted) return std::nullopt;
  Shown small = settings.shown;
  small.size = settings.count_size;
  render::Framebuffer picture;
  return Count{*counted, render::render(entrant.dataset, scene_of(small, entrant.dataset, entrant.isovalue, view),
                                        frame_of(small.size, entrant.layout.use_hierarchy), picture)};
}

/// Fraction of the pixels whose colours differ by more than a level of 255. In single precision,
/// kernels for different instruction sets round differently, so pictures of the same samples need
/// not be bit-identical.
double share_of_other_pixels(const render::Framebuffer& a, const render::Framebuffer& b) {
  std::size_t others = 0;
  for (std::size_t pixel = 0; pixel < a.pixel_count(); ++pixel) {
    float difference = 0;
    for (std::size_t c = 4 * pixel; c < 4 * pixel + 4; ++c)
      difference = std::max(difference, std::abs(a.color[c] - b.color[c]));
    others += difference > 1.0F / 255;
  }
  return static_cast<double>(others) / static_cast<double>(a.pixel_count());
}

double per(double amount, std::uint64_t count) {
  return count == 0 ? 0 : amount / static_cast<double>(count);
}

Json row_of(const Entrant& entrant, const TimedRow& timed, const render::FrameStatistics& statistics,
            const std::optional<Count>& count, double usual_ms) {
  const tools::Spread ms = timed.cpu_ms();
  Json row{{"layout", entrant.layout.name},
           {"machine", statistics.machine},
           {"cpu_ms", ms.median},
           {"cpu_ms_min", ms.smallest},
           {"cpu_ms_max", ms.largest},
           {"times", timed.costs.size()},
           {"over_usual", ms.median / usual_ms},
           {"cycles_per_ray", per(timed.median_cycles(), statistics.rays)},
           {"macrocells_per_ray", per(static_cast<double>(statistics.macrocells_visited), statistics.rays)},
           {"cells_per_ray", per(static_cast<double>(statistics.cells_visited), statistics.rays)},
           {"instructions_per_ray", nullptr},
           {"instructions_per_cell", nullptr}};
  if (count) {
    row["instructions_per_ray"] = per(count->instructions, count->statistics.rays);
    row["instructions_per_cell"] = per(count->instructions, count->statistics.cells_visited);
  }
  row["file_mb"] = static_cast<double>(entrant.file_bytes) / 1e6;
  row["huge_mb"] = entrant.layout.huge_pages ? Json(static_cast<double>(entrant.huge_bytes) / 1e6) : Json();
  return row;
}

std::string instructions_source(const Settings& settings) {
  if (tools::CpuMeter().counts_instructions()) return "counted by the processor";
  if (!settings.count_instructions) return "not measured: the system offers no counter";
  return concat("callgrind, of rows that the scalar kernels answer, at ", settings.count_size.width, "x",
                settings.count_size.height);
}

/// The layout with which all others are compared.
constexpr std::size_t usual = 2;

int run(const Settings& settings) {
  require_publishable(settings.common, {"layouts"});
  require_within("--repeat", settings.rounds.rounds, 1, 10'000);
  require_within("--row-seconds", settings.rounds.row_seconds, 0, 1e6);
  preprocess::require_input(settings.input);
  const tools::ScratchFolder scratch(settings.scratch);
  tools::Table table{"layouts", "How samples lie in memory: CPU time of one thread", {}, {}};
  bool is_same_everywhere = true;
  {
    tools::ProgressDisplay display(settings.common);
    const auto tell = [&](const std::string& what) { display.show(what); };
    const std::vector<Entrant> entrants = pack_all(settings, scratch.path(), tell);
    for (const std::string& word : settings.views) {
      const tools::StudyView view = tools::study_view_named(word);
      std::vector<render::Framebuffer> pictures(entrants.size());
      std::vector<render::RenderContext> memories(entrants.size());
      std::vector<render::FrameStatistics> statistics(entrants.size());
      std::vector<TimedRow> rows;
      for (std::size_t e = 0; e < entrants.size(); ++e) {
        const Entrant& entrant = entrants[e];
        const render::Scene scene = scene_of(settings.shown, entrant.dataset, entrant.isovalue, view);
        rows.push_back({.name = entrant.layout.name, .act = [&, e, scene] {
                          statistics[e] =
                              render::render(entrants[e].dataset, scene,
                                             frame_of(settings.shown.size, entrants[e].layout.use_hierarchy),
                                             pictures[e], memories[e]);
                        }});
      }
      run_rounds(rows, settings.rounds, [&](const std::string& step) { tell(concat(word, ", ", step)); });
      for (std::size_t e = 0; e < entrants.size(); ++e) {
        tell(concat(word, ", counting, ", entrants[e].layout.name));
        const auto count = count_of(settings, entrants[e], rows[e], statistics[e], view, scratch.path());
        const double off = share_of_other_pixels(pictures[e], pictures[usual]);
        Json row{{"view", word}};
        row.update(row_of(entrants[e], rows[e], statistics[e], count, rows[usual].cpu_ms().median));
        row["other_pixels"] = off;
        row["picture"] = tools::picture_hash(pictures[e]);
        is_same_everywhere &= entrants[e].layout.type.has_value() || off <= 1e-3;
        table.rows.push_back(std::move(row));
      }
    }
    const Index3 n = entrants[usual].dataset.file().description().kind == "grid"
                         ? formats::BrickGrid(entrants[usual].dataset.file()).description().layout.sample_count
                         : Index3(0);
    table.context = context_with({{"input", settings.input.filename().string()},
                                  {"samples", {n.x, n.y, n.z}},
                                  {"type", formats::element_name(entrants[usual].dataset.field().type)},
                                  {"isovalue", entrants[usual].isovalue},
                                  {"accuracy", settings.shown.accuracy},
                                  {"size", {settings.shown.size.width, settings.shown.size.height}},
                                  {"threads", 1},
                                  {"repeat", settings.rounds.rounds},
                                  {"cycles", cycles_source()},
                                  {"instructions", instructions_source(settings)}});
  }
  publish(table, settings.common);
  if (!is_same_everywhere)
    throw Error(ErrorCode::outside_limit,
                "layouts: pictures of the same samples differ in more than a thousandth of the pixels; see column "
                "'other_pixels'");
  return 0;
}

std::vector<tools::Option> shown_options(Shown& shown) {
  return {tools::value_option("--iso", "V", "Isovalue, as in render; default auto", shown.isovalue),
          tools::choice_option("--accuracy", render::accuracy_words(),
                               "Level; default double, at which all layouts of the same samples give one picture",
                               shown.accuracy),
          tools::value_option("--size", "WxH", "Pixels; default 512x512", shown.size)};
}

struct FrameSpec {
  std::filesystem::path input;
  Shown shown;
  std::string view = "front";
  bool no_hierarchy = false;
};

int show_one_frame(const FrameSpec& settings) {
  const render::Dataset dataset = tools::load_dataset(settings.input, {});
  const double isovalue = render::choose_isovalue(settings.shown.isovalue, dataset.field()).value;
  const render::Scene scene = scene_of(settings.shown, dataset, isovalue, tools::study_view_named(settings.view));
  render::Framebuffer picture;
  render::RenderContext memory;
  const render::FrameStatistics statistics =
      render::render(dataset, scene, frame_of(settings.shown.size, !settings.no_hierarchy), picture, memory);
  std::puts(concat("machine ", statistics.machine, ", picture ", tools::picture_hash(picture)).c_str());
  return 0;
}

}  // namespace

tools::Subcommand layouts() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "layouts",
      .summary = "How samples lie in memory, and what that costs: the paper's Table 3 with rows of today",
      .examples = {"rhoray-study layouts smooth.rho --iso 600.5 -o results"},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid", settings->input)},
           tools::output_options(settings->common, "FOLDER for layouts.csv and .json"),
           shown_options(settings->shown),
           {tools::value_option("--views", "NAME[,NAME]", "Of front, from-feet, close-up and inside; default all",
                                settings->views),
            tools::value_option("--field", "NAME", "Field; default the first", settings->field),
            tools::value_option("--repeat", "N", "Rounds; default 5", settings->rounds.rounds),
            tools::value_option("--row-seconds", "S", "What has taken so much CPU time is not timed again; default 8",
                                settings->rounds.row_seconds),
            tools::flag_option("--count-instructions",
                               "With valgrind, where the system offers no counter; takes minutes",
                               settings->count_instructions),
            tools::value_option("--count-size", "WxH", "Pixels for valgrind; default 96x96", settings->count_size),
            tools::value_option("--scratch", "FOLDER", "For the packed grids", settings->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

tools::Subcommand one_frame() {
  const auto settings = std::make_shared<FrameSpec>();
  return {.name = "one-frame",
          .summary = "One picture on one thread, for tools that count from outside; prints who answered and its hash",
          .examples = {"valgrind --tool=callgrind '--toggle-collect=rhoray::render::render(*FrameMemory&)' "
                       "rhoray-study one-frame smooth.rho --size 96x96"},
          .options = tools::all_options(
              {{tools::file_option("FILE", "Packed file", settings->input)},
               shown_options(settings->shown),
               {tools::value_option("--view", "NAME", "front, from-feet, close-up or inside", settings->view),
                tools::flag_option("--no-hierarchy", "Walk every leaf cell", settings->no_hierarchy)}}),
          .run = [settings] { return show_one_frame(*settings); }};
}

}  // namespace rhoray::study

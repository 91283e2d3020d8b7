// What a method for the first crossing in a trilinear cell gets wrong, on many random and hard cells, by the judge.

#include "tools/study/judge_cells.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

#include "formats/base/trouble.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/new_file.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/table.h"
#include "tools/rhoray/threads.h"
#include "tools/rhoray/version.h"
#include "tools/study/hard_cells.h"

namespace rhoray::study {
namespace {

using tools::Json;

struct MethodAnswer {
  enum class Says { none, crosses, in_doubt };

  Says says = Says::none;
  double s = 0;
  double s_error = std::numeric_limits<double>::infinity();  ///< claimed; infinite when nothing is claimed
};

struct Method {
  const char* name;
  const char* story;
  MethodAnswer (*answer)(const CellCase&, bool starts_inside);
};

MethodAnswer bracketed_double(const CellCase& made, bool starts_inside) {
  const auto s = render::first_change_of_side(made.cell.along(made.p0, made.p1, made.isovalue), starts_inside);
  return s ? MethodAnswer{MethodAnswer::Says::crosses, *s} : MethodAnswer{};
}

constexpr Method methods[] = {{"bracketed:double", "what the kernels do: bracketed iteration", bracketed_double}};

struct Wishes {
  tools::CommonOptions common;
  std::uint64_t cells = 100'000;  ///< of each class
  std::vector<std::string> classes;
  std::string method = methods[0].name;
  double width = 1e-13;
  std::uint64_t seed = 1;
};

/// What came out for some cells of one class. Sums and largest ones, so that parts add up in any order.
struct Tally {
  std::uint64_t cells = 0, crossings = 0, touches = 0;
  std::uint64_t missed = 0, missed_touches = 0, extra = 0, not_first = 0, in_doubt = 0, bound_broken = 0,
                beyond_1e12 = 0;
  double largest_error = 0;  ///< in cell edges
  std::uint64_t filtered = 0, exact = 0;
  double filter_s = 0, exact_s = 0;

  void add(const Tally& other) {
    cells += other.cells, crossings += other.crossings, touches += other.touches;
    missed += other.missed, missed_touches += other.missed_touches, extra += other.extra;
    not_first += other.not_first, in_doubt += other.in_doubt, bound_broken += other.bound_broken;
    beyond_1e12 += other.beyond_1e12;
    largest_error = std::max(largest_error, other.largest_error);
    filtered += other.filtered, exact += other.exact;
    filter_s += other.filter_s, exact_s += other.exact_s;
  }
};

/// The judge's verdict, and its cost in the tally.
render::CellVerdict judged(const CellCase& made, bool starts_inside, double width, Tally& tally) {
  const auto begin = std::chrono::steady_clock::now();
  const render::CellVerdict verdict =
      render::judge_crossing(made.cell, made.p0, made.p1, made.isovalue, starts_inside, width);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const bool is_exact = verdict.road == render::Road::exact;
  ++(is_exact ? tally.exact : tally.filtered);
  (is_exact ? tally.exact_s : tally.filter_s) += seconds;
  return verdict;
}

double distance(double s, const render::Enclosure& enclosure) {
  return std::max({0.0, enclosure.lo - s, s - enclosure.hi});
}

/// True when another root than the one at which the side changes lies nearest.
bool is_another_root(const CellCase& made, double s, const render::Enclosure& right, double width) {
  for (const render::Enclosure& root : render::judge_roots(made.cell, made.p0, made.p1, made.isovalue, width))
    if (distance(s, root) < distance(s, right)) return true;
  return false;
}

void judge_one(const CellCase& made, const Method& method, double width, Tally& tally) {
  ++tally.cells;
  // The side at the start is the exact one, as a ray that lost no crossing before would have it.
  bool starts_inside = false;
  render::CellVerdict truth = judged(made, false, width, tally);
  if (truth.changes && truth.s.hi == 0) {
    starts_inside = true;
    truth = judged(made, true, width, tally);
  }
  tally.crossings += truth.changes;
  tally.touches += truth.touches;

  const MethodAnswer answer = method.answer(made, starts_inside);
  if (answer.says == MethodAnswer::Says::in_doubt) {
    ++tally.in_doubt;
    return;
  }
  const bool crosses = answer.says == MethodAnswer::Says::crosses;
  if (!truth.changes) {
    tally.extra += crosses;
    return;
  }
  if (!crosses) {
    ++(truth.touches ? tally.missed_touches : tally.missed);
    return;
  }
  const double off = distance(answer.s, truth.s);
  const double error = off * (made.p1 - made.p0).length();
  tally.largest_error = std::max(tally.largest_error, error);
  tally.beyond_1e12 += error > 1e-12;
  tally.bound_broken += off > answer.s_error;
  if (truth.root_count > 1 && off > width && is_another_root(made, answer.s, truth.s, width)) ++tally.not_first;
}

constexpr std::uint64_t chunk_size = 4096;

/// Cells are made from a seed for each chunk, so that the result does not depend on who works on which.
Tally judge_class(const CellClass& of, const Method& method, const Wishes& wishes, tools::ProgressDisplay& display) {
  const std::uint64_t chunks = (wishes.cells + chunk_size - 1) / chunk_size;
  const std::uint64_t class_number = static_cast<std::uint64_t>(&of - cell_classes().data());
  Tally whole;
  std::mutex adding;
  tbb::parallel_for(std::uint64_t{0}, chunks, [&](std::uint64_t chunk) {
    Dice dice((wishes.seed << 48) ^ (class_number << 40) ^ chunk);
    Tally part;
    const std::uint64_t count = std::min(chunk_size, wishes.cells - chunk * chunk_size);
    for (std::uint64_t c = 0; c < count; ++c) judge_one(of.make(dice), method, wishes.width, part);
    const std::scoped_lock lock(adding);
    whole.add(part);
    display.show(concat("judging ", of.name, " [cells]"), whole.cells, wishes.cells);
  });
  return whole;
}

Json row_of(const CellClass& of, const Tally& tally) {
  const auto mean = [](double seconds, std::uint64_t count) {
    return count == 0 ? 0.0 : seconds / static_cast<double>(count);
  };
  return {{"class", of.name},
          {"cells", tally.cells},
          {"crossings", tally.crossings},
          {"touches", tally.touches},
          {"missed", tally.missed},
          {"missed_touches", tally.missed_touches},
          {"false", tally.extra},
          {"not_first", tally.not_first},
          {"in_doubt", tally.in_doubt},
          {"bound_broken", tally.bound_broken},
          {"error_above_1e-12", tally.beyond_1e12},
          {"largest_error_cells", tally.largest_error},
          {"judge_exact_share", mean(static_cast<double>(tally.exact), tally.exact + tally.filtered)},
          {"judge_filter_us", 1e6 * mean(tally.filter_s, tally.filtered)},
          {"judge_exact_us", 1e6 * mean(tally.exact_s, tally.exact)}};
}

template <class Row>
std::string names_of(std::span<const Row> rows) {
  std::string names;
  for (const Row& row : rows) names += concat(names.empty() ? "" : ", ", row.name);
  return names;
}

template <class Row>
const Row& named(std::span<const Row> rows, const std::string& option, const std::string& name) {
  for (const Row& row : rows)
    if (name == row.name) return row;
  throw Error(Trouble::usage, concat(option, ": found '", name, "'; expected one of ", names_of(rows)));
}

Json context(const Wishes& wishes, double wall_s) {
  const tools::Machine machine = tools::this_machine();
  return {{"processor", machine.processor},
          {"cores", machine.core_count},
          {"system", machine.system},
          {"version", tools::version()},
          {"commit", tools::commit()},
          {"compiler", tools::compiler()},
          {"method", wishes.method},
          {"width", wishes.width},
          {"seed", wishes.seed},
          {"wall_s", wall_s}};
}

int run(const Wishes& wishes) {
  tools::require_within("--cells", static_cast<double>(wishes.cells), 1, 1e12);
  tools::require_within("--width", wishes.width, 1e-300, 1);
  tools::require_within("--seed", static_cast<double>(wishes.seed), 0, 65535);
  const Method& method = named(std::span<const Method>(methods), "--method", wishes.method);
  std::vector<const CellClass*> wanted;
  for (const std::string& name : wishes.classes) wanted.push_back(&named(cell_classes(), "--classes", name));
  if (wanted.empty())
    for (const CellClass& each : cell_classes()) wanted.push_back(&each);

  const tools::ThreadLimit limit(wishes.common.threads);
  const tools::Stopwatch watch;
  tools::Table table{"judge_cells", concat("First crossings in trilinear cells: ", method.name), {}, {}};
  {
    tools::ProgressDisplay display(wishes.common);
    for (const CellClass* each : wanted)
      table.rows.push_back(row_of(*each, judge_class(*each, method, wishes, display)));
  }
  table.context = context(wishes, watch.seconds());
  std::fputs(tools::text_of(table).c_str(), stdout);
  if (wishes.common.output.empty()) return 0;
  const auto write = [&](const std::string& extension, const std::string& text) {
    tools::write_new_file(wishes.common.output / (table.name + extension), text, wishes.common.force);
  };
  write(".csv", tools::csv_of(table));
  write(".json", tools::json_of(table).dump(2) + "\n");
  return 0;
}

std::string stories_of_classes() {
  std::string help = "Only these kinds of cells; default all. ";
  for (const CellClass& each : cell_classes()) help += concat(each.name, ": ", each.story, "; ");
  help.resize(help.size() - 2);
  return help;
}

}  // namespace

tools::Subcommand judge_cells() {
  const auto wishes = std::make_shared<Wishes>();
  return {
      .name = "judge-cells",
      .summary = "A method for the first crossing in a trilinear cell against the exact judge",
      .examples = "  rhoray-study judge-cells --cells 1000000 --classes random,near-tangent -o results\n",
      .options = tools::all_options(
          {{tools::value_option("-o,--output", "FOLDER", "For judge_cells.csv and .json", wishes->common.output),
            tools::flag_option("--force", "Replace files that are there", wishes->common.force),
            tools::value_option("--cells", "N", "Cells of each kind; default 100000", wishes->cells),
            tools::value_option("--classes", "NAME[,NAME]", stories_of_classes(), wishes->classes),
            tools::value_option(
                "--method", "NAME",
                concat("Default ", methods[0].name, "; one of ", names_of(std::span<const Method>(methods))),
                wishes->method),
            tools::value_option("--width", "S", "Width of the judge's enclosures, in chords; default 1e-13",
                                wishes->width),
            tools::value_option("--seed", "N", "Of the random numbers, 0 to 65535; default 1", wishes->seed)},
           tools::threads_option(wishes->common),
           {tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", wishes->common.progress)}}),
      .run = [wishes] { return run(*wishes); }};
}

}  // namespace rhoray::study

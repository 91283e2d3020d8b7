// Counts the errors of methods for the first crossing in a trilinear cell, on many random and hard
// cells, by exact arithmetic.

#include "tools/lab/judge_cells.h"

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/base/read_value.h"
#include "tools/lab/hard_cells.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/cli/progress_display.h"

namespace rhoray::study {
namespace {

/// The arithmetic that decided an answer. Certified methods try them in this order.
enum class Decider { single, float64, judge };
constexpr std::array<const char*, 3> decider_names{"float", "double", "judge"};

struct MethodAnswer {
  bool crosses = false;
  double s = 0;
  /// Claimed bound; infinite when nothing is claimed.
  double s_error = std::numeric_limits<double>::infinity();
  Decider by = Decider::float64;
};

template <class Real>
constexpr Decider decider_of = std::is_same_v<Real, float> ? Decider::single : Decider::float64;

struct Method {
  const char* name;
  const char* story;
  MethodAnswer (*answer)(const CellCase&, bool starts_inside);
};

template <render::CrossingMethod method, class Real>
MethodAnswer named_method(const CellCase& made, bool starts_inside) {
  // The ray begins where it enters the cell, where the paper's expansion is at its best.
  const render::CellPassage way{
      .in = made.p0, .out = made.p1, .origin = made.p0, .direction = made.p1 - made.p0, .t_in = 0, .t_out = 1};
  const render::CellCrossing found = render::find_crossing<Real>(method, made.cell, way, made.isovalue, starts_inside);
  return {.crosses = found.crosses, .s = found.s, .by = decider_of<Real>};
}

/// Returns nothing when the arithmetic leaves the answer in doubt, or the position too uncertain.
template <class Real>
std::optional<MethodAnswer> proven(const CellCase& made, bool starts_inside) {
  constexpr double point_error = 0x1p-52;  // the smallest that kernels assume
  const render::CertifiedCrossing found =
      render::certify_crossing<Real>(made.cell, made.p0, made.p1, point_error, made.isovalue, starts_inside);
  if (found.decision == render::Decision::none) return MethodAnswer{.by = decider_of<Real>};
  if (found.decision == render::Decision::unknown ||
      !render::is_placed_well<Real>(found, made.p0, made.p1, point_error))
    return std::nullopt;
  return MethodAnswer{.crosses = true, .s = found.s, .s_error = found.s_error, .by = decider_of<Real>};
}

MethodAnswer by_the_judge(const CellCase& made, bool starts_inside) {
  const render::CellVerdict verdict =
      render::exact_crossing(made.cell, made.p0, made.p1, made.isovalue, starts_inside, 0x1p-40);
  const double s = 0.5 * (verdict.s.lo + verdict.s.hi);
  return {.crosses = verdict.changes,
          .s = s,
          .s_error = std::max(s - verdict.s.lo, verdict.s.hi - s),
          .by = Decider::judge};
}

MethodAnswer certified_in_double(const CellCase& made, bool starts_inside) {
  if (const auto answer = proven<double>(made, starts_inside)) return *answer;
  return by_the_judge(made, starts_inside);
}

MethodAnswer certified(const CellCase& made, bool starts_inside) {
  if (const auto answer = proven<float>(made, starts_inside)) return *answer;
  return certified_in_double(made, starts_inside);
}

using enum render::CrossingMethod;

constexpr Method methods[] = {{"certified", "proven in float, else in double, else judged", certified},
                              {"certified:double", "proven in double, else judged", certified_in_double},
                              {"bracketed:double", "bracketed iteration", named_method<bracketed, double>},
                              {"bracketed:float", "the same in single precision", named_method<bracketed, float>},
                              {"paper:double", "Appendix A with Schwarze's closed form", named_method<paper, double>},
                              {"paper:float", "the same in single precision", named_method<paper, float>}};
constexpr std::size_t method_count = std::size(methods);

struct Settings {
  tools::CommonOptions common;
  std::uint64_t cells = 100'000;  ///< per class
  std::vector<std::string> classes;
  std::vector<std::string> methods;
  double width = 1e-13;
  std::uint64_t seed = 1;
};

/// The results for some cells of one class. Sums and maxima, so that parts add up in any order.
struct Tally {
  /// The answers of one decider; lengths in cell edges.
  struct OfDecider {
    std::uint64_t answers = 0;
    double largest_error = 0;  ///< of right roots: the most that the exact enclosure permits
    double largest_bound = 0;  ///< claimed
  };

  std::uint64_t missed = 0, missed_touches = 0, extra = 0, not_first = 0, bound_broken = 0;
  std::array<OfDecider, decider_names.size()> by{};

  void add(const Tally& other) {
    missed += other.missed, missed_touches += other.missed_touches, extra += other.extra;
    not_first += other.not_first, bound_broken += other.bound_broken;
    for (std::size_t d = 0; d < by.size(); ++d) {
      by[d].answers += other.by[d].answers;
      by[d].largest_error = std::max(by[d].largest_error, other.by[d].largest_error);
      by[d].largest_bound = std::max(by[d].largest_bound, other.by[d].largest_bound);
    }
  }
};

struct ClassTally {
  std::uint64_t cells = 0, crossings = 0, touches = 0;
  std::uint64_t filtered = 0, exact = 0;
  double filter_s = 0, exact_s = 0;
  std::array<Tally, method_count> of_method{};

  void add(const ClassTally& other) {
    cells += other.cells, crossings += other.crossings, touches += other.touches;
    filtered += other.filtered, exact += other.exact;
    filter_s += other.filter_s, exact_s += other.exact_s;
    for (std::size_t m = 0; m < method_count; ++m) of_method[m].add(other.of_method[m]);
  }
};

/// Computes the exact verdict and adds its cost to the tally.
render::CellVerdict judged(const CellCase& made, bool starts_inside, double width, ClassTally& tally) {
  const auto begin = std::chrono::steady_clock::now();
  const render::CellVerdict verdict =
      render::exact_crossing(made.cell, made.p0, made.p1, made.isovalue, starts_inside, width);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const bool is_exact = verdict.road == render::Road::exact;
  ++(is_exact ? tally.exact : tally.filtered);
  (is_exact ? tally.exact_s : tally.filter_s) += seconds;
  return verdict;
}

double distance(double s, const render::Enclosure& enclosure) {
  return std::max({0.0, enclosure.lo - s, s - enclosure.hi});
}

/// True when a root other than the one at which the side changes is nearest.
bool is_another_root(const CellCase& made, double s, const render::Enclosure& right, double width) {
  for (const render::Enclosure& root : render::exact_roots(made.cell, made.p0, made.p1, made.isovalue, width))
    if (distance(s, root) < distance(s, right)) return true;
  return false;
}

void compare(const MethodAnswer& answer, const CellCase& made, const render::CellVerdict& truth, double width,
             Tally& tally) {
  Tally::OfDecider& by = tally.by[static_cast<std::size_t>(answer.by)];
  ++by.answers;
  if (!truth.changes) {
    tally.extra += answer.crosses;
    return;
  }
  if (!answer.crosses) {
    ++(truth.touches ? tally.missed_touches : tally.missed);
    return;
  }
  const double off = distance(answer.s, truth.s), chord = (made.p1 - made.p0).length();
  tally.bound_broken += off > answer.s_error;
  if (std::isfinite(answer.s_error)) by.largest_bound = std::max(by.largest_bound, answer.s_error * chord);
  if (truth.root_count > 1 && off > width && is_another_root(made, answer.s, truth.s, width)) {
    ++tally.not_first;
    return;
  }
  const double farthest = std::max(truth.s.hi - answer.s, answer.s - truth.s.lo);
  by.largest_error = std::max(by.largest_error, farthest * chord);
}

/// The methods to test.
using Chosen = std::array<bool, method_count>;

void judge_one(const CellCase& made, const Chosen& chosen, double width, ClassTally& tally) {
  ++tally.cells;
  // The side at the start is the exact one, as for a ray that lost no crossing before.
  bool starts_inside = false;
  render::CellVerdict truth = judged(made, false, width, tally);
  if (truth.changes && truth.s.hi == 0) {
    starts_inside = true;
    truth = judged(made, true, width, tally);
  }
  tally.crossings += truth.changes;
  tally.touches += truth.touches;
  for (std::size_t m = 0; m < method_count; ++m)
    if (chosen[m]) compare(methods[m].answer(made, starts_inside), made, truth, width, tally.of_method[m]);
}

constexpr std::uint64_t chunk_size = 4096;

/// Makes cells from one seed per chunk, so that the result does not depend on which thread works on
/// which chunk.
ClassTally judge_class(const CellClass& of, const Chosen& chosen, const Settings& settings,
                       tools::ProgressDisplay& display) {
  const std::uint64_t chunks = (settings.cells + chunk_size - 1) / chunk_size;
  const std::uint64_t class_number = static_cast<std::uint64_t>(&of - cell_classes().data());
  ClassTally whole;
  std::mutex adding;
  parallel_for_each(chunks, [&](std::uint64_t chunk) {
    Dice dice((settings.seed << 48) ^ (class_number << 40) ^ chunk);
    ClassTally part;
    const std::uint64_t count = std::min(chunk_size, settings.cells - chunk * chunk_size);
    for (std::uint64_t c = 0; c < count; ++c) judge_one(of.make(dice), chosen, settings.width, part);
    const std::scoped_lock lock(adding);
    whole.add(part);
    display.show(concat("judging ", of.name, " [cells]"), whole.cells, settings.cells);
  });
  return whole;
}

Json row_of(const CellClass& of, const ClassTally& judged, std::size_t method) {
  const Tally& tally = judged.of_method[method];
  const auto mean = [](double seconds, std::uint64_t count) {
    return count == 0 ? 0.0 : seconds / static_cast<double>(count);
  };
  Json row{{"class", of.name},
           {"method", methods[method].name},
           {"cells", judged.cells},
           {"crossings", judged.crossings},
           {"touches", judged.touches},
           {"missed", tally.missed},
           {"missed_touches", tally.missed_touches},
           {"false", tally.extra},
           {"not_first", tally.not_first},
           {"bound_broken", tally.bound_broken}};
  for (std::size_t d = 0; d < tally.by.size(); ++d) {
    const Tally::OfDecider& by = tally.by[d];
    const std::string name = decider_names[d];
    row[concat("by_", name)] = by.answers;
    row[concat(name, "_error_cells")] = by.largest_error;
    row[concat(name, "_bound_cells")] = by.largest_bound;
  }
  row["judge_exact_share"] = mean(static_cast<double>(judged.exact), judged.exact + judged.filtered);
  row["judge_filter_us"] = 1e6 * mean(judged.filter_s, judged.filtered);
  row["judge_exact_us"] = 1e6 * mean(judged.exact_s, judged.exact);
  return row;
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
  throw Error(ErrorCode::usage, concat(option, ": found '", name, "'; expected one of ", names_of(rows)));
}

int run(const Settings& settings) {
  require_within("--cells", static_cast<double>(settings.cells), 1, 1e12);
  require_within("--width", settings.width, 1e-300, 1);
  require_publishable(settings.common, {"judge_cells"});
  require_within("--seed", static_cast<double>(settings.seed), 0, 65535);
  Chosen chosen;
  chosen.fill(settings.methods.empty());
  for (const std::string& name : settings.methods)
    chosen[static_cast<std::size_t>(&named(std::span<const Method>(methods), "--methods", name) - methods)] = true;
  std::vector<const CellClass*> wanted;
  for (const std::string& name : settings.classes) wanted.push_back(&named(cell_classes(), "--classes", name));
  if (wanted.empty())
    for (const CellClass& each : cell_classes()) wanted.push_back(&each);

  const ThreadLimit limit(settings.common.threads);
  const tools::Stopwatch watch;
  tools::Table table{"judge_cells", "First crossings in trilinear cells, against the judge", {}, {}};
  {
    tools::ProgressDisplay display(settings.common);
    for (const CellClass* each : wanted) {
      const ClassTally judged = judge_class(*each, chosen, settings, display);
      for (std::size_t m = 0; m < method_count; ++m)
        if (chosen[m]) table.rows.push_back(row_of(*each, judged, m));
    }
  }
  table.context = context_with({{"width", settings.width}, {"seed", settings.seed}, {"wall_s", watch.seconds()}});
  publish(table, settings.common);
  return 0;
}

std::string stories_of_methods() {
  std::string help = "Only these methods; default all:";
  for (const Method& each : methods) help += concat(" ", each.name, " (", each.story, ")");
  return help;
}

std::string stories_of_classes() {
  std::string help = "Only these kinds of cells; default all. ";
  for (const CellClass& each : cell_classes()) help += concat(each.name, ": ", each.story, "; ");
  help.resize(help.size() - 2);
  return help;
}

}  // namespace

tools::Subcommand judge_cells() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "judge-cells",
      .summary = "Methods for the first crossing in a trilinear cell against the exact judge",
      .examples = {"rhoray-study judge-cells --cells 1000000 --classes random,near-tangent -o results"},
      .options = tools::all_options(
          {{tools::value_option("-o,--output", "FOLDER", "For judge_cells.csv and .json", settings->common.output),
            tools::flag_option("--force", "Replace files that are there", settings->common.force),
            tools::value_option("--cells", "N", "Cells of each kind; default 100000", settings->cells),
            tools::value_option("--classes", "NAME[,NAME]", stories_of_classes(), settings->classes),
            tools::value_option("--methods", "NAME[,NAME]", stories_of_methods(), settings->methods),
            tools::value_option("--width", "S", "Width of the judge's enclosures, in chords; default 1e-13",
                                settings->width),
            tools::value_option("--seed", "N", "Of the random numbers, 0 to 65535; default 1", settings->seed)},
           tools::threads_option(settings->common),
           {tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

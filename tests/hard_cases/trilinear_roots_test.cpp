// Compares the first root in 250,000 trilinear cells, hard in every way known to us, with exact
// arithmetic. No change of side is missed, none is invented, and only the first is reported. The
// environment variable RHORAY_ROOT_CELLS sets a larger number of cells (tests/nightly).
#include <gtest/gtest.h>

#include <hwy/highway.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "formats/base/parallel.h"
#include "render/exact.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "tests/hard_cases/trilinear_root_cells.h"
#include "tests/support/asked_count.h"

namespace rhoray::tests {
namespace {

namespace wide = render::wide::HWY_NAMESPACE;
namespace hn = hwy::HWY_NAMESPACE;

using render::CellVerdict;
using study::CellCase;

/// A cell, the side on which the chord begins, and the exact answer.
struct JudgedCell {
  CellCase made;
  bool starts_inside = false;
  CellVerdict truth;
};

constexpr double width = 1e-14;  // of the exact enclosures, in chords

JudgedCell judged(const CellCase& made) {
  JudgedCell cell{made, false, exact_crossing(made.cell, made.p0, made.p1, made.isovalue, false, width)};
  if (cell.truth.changes && cell.truth.s.hi == 0) {
    cell.starts_inside = true;
    cell.truth = exact_crossing(made.cell, made.p0, made.p1, made.isovalue, true, width);
  }
  return cell;
}

struct Answer {
  bool crosses = false;
  double s = 0;
};
using Answers = std::vector<Answer>;

template <render::CrossingMethod method, class Real>
Answers one_by_one(const std::vector<JudgedCell>& cells) {
  Answers answers;
  for (const auto& [made, starts_inside, truth] : cells) {
    const render::CellPassage way{
        .in = made.p0, .out = made.p1, .origin = made.p0, .direction = made.p1 - made.p0, .t_in = 0, .t_out = 1};
    const render::CellCrossing found =
        render::find_crossing<Real>(method, made.cell, way, made.isovalue, starts_inside);
    answers.push_back({found.crosses, found.s});
  }
  return answers;
}

/// Computes as the wide kernels do, many cells at once. Compiled for the instruction set of the
/// test itself.
Answers by_lanes(const std::vector<JudgedCell>& cells) {
  constexpr std::size_t lanes = wide::float_lanes;
  Answers answers;
  for (std::size_t first = 0; first < cells.size(); first += lanes) {
    const std::size_t count = std::min(lanes, cells.size() - first);
    HWY_ALIGN float corner[8][lanes] = {}, in[3][lanes] = {}, out[3][lanes] = {}, side[lanes] = {}, s[lanes];
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [made, starts_inside, truth] = cells[first + i];
      const render::TrilinearCellOf<float> differences = render::minus<float>(made.cell, made.isovalue).cell;
      for (std::size_t c = 0; c < 8; ++c) corner[c][i] = differences.corner[c];
      for (int a = 0; a < 3; ++a) in[a][i] = static_cast<float>(made.p0[a]), out[a][i] = static_cast<float>(made.p1[a]);
      side[i] = starts_inside ? 1 : -1;
    }
    wide::Corners corners;
    for (std::size_t c = 0; c < 8; ++c) corners.f[c] = hn::Load(wide::floats, corner[c]);
    wide::VecF from[3], to[3];
    for (int a = 0; a < 3; ++a) from[a] = hn::Load(wide::floats, in[a]), to[a] = hn::Load(wide::floats, out[a]);
    const wide::CubicLanes cubic = wide::along(corners, from, to);
    const wide::MaskF inside = hn::Gt(hn::Load(wide::floats, side), hn::Zero(wide::floats));
    const wide::Changes changes = wide::first_changes(cubic, inside, hn::FirstN(wide::floats, count));
    wide::RootSearch search(cubic, changes.low, changes.high);
    for (int step = 0; step < 100 && !search.is_done(); ++step) search.step();
    hn::Store(search.roots().s, wide::floats, s);
    const std::uint64_t found = wide::bits_of(wide::floats, changes.found);
    for (std::size_t i = 0; i < count; ++i) answers.push_back({(found >> i & 1) != 0, static_cast<double>(s[i])});
  }
  return answers;
}

struct Method {
  const char* name;
  Answers (*answers)(const std::vector<JudgedCell>&);
  double unit;             ///< unit of rounding
  double largest_residue;  ///< largest allowed |value - isovalue|, relative to the range of the
                           ///< corners
};
constexpr double unit_of_float = 0x1p-24, unit_of_double = 0x1p-53;
constexpr Method methods[] = {{"double", one_by_one<render::CrossingMethod::bracketed, double>, unit_of_double, 1e-12},
                              {"float", one_by_one<render::CrossingMethod::bracketed, float>, unit_of_float, 1e-5},
                              {"wide float", by_lanes, unit_of_float, 1e-5}};
constexpr std::size_t method_count = std::size(methods);

struct Tally {
  struct OfMethod {
    std::uint64_t missed = 0, extra = 0, not_first = 0, ties = 0;
    double largest_residue = 0;
  };
  std::uint64_t cells = 0, changes = 0, touches = 0;
  std::array<OfMethod, method_count> of{};
  std::uint64_t proven = 0, wrongly_proven = 0, missed_by_paper = 0;

  void add(const Tally& part) {
    cells += part.cells, changes += part.changes, touches += part.touches;
    proven += part.proven, wrongly_proven += part.wrongly_proven, missed_by_paper += part.missed_by_paper;
    for (std::size_t m = 0; m < method_count; ++m) {
      of[m].missed += part.of[m].missed, of[m].extra += part.of[m].extra, of[m].ties += part.of[m].ties;
      of[m].not_first += part.of[m].not_first;
      of[m].largest_residue = std::max(of[m].largest_residue, part.of[m].largest_residue);
    }
  }
};

/// |value - isovalue| at a position on the chord, relative to the range of the corners. Values far
/// from the isovalue are rounded by at most 2^-64 of themselves.
double residue(const CellCase& made, double s) {
  using Exact = long double;
  Exact f[8];
  for (std::size_t c = 0; c < 8; ++c) f[c] = static_cast<Exact>(made.cell.corner[c]) - made.isovalue;
  std::size_t count = 8;
  for (int axis = 0; axis < 3; ++axis) {
    const Exact w = made.p0[axis] + static_cast<Exact>(s) * (static_cast<Exact>(made.p1[axis]) - made.p0[axis]);
    count /= 2;
    for (std::size_t i = 0; i < count; ++i) f[i] = (1 - w) * f[2 * i] + w * f[2 * i + 1];
  }
  const double range = made.cell.largest() - made.cell.smallest();
  return f[0] == 0 ? 0 : static_cast<double>(std::abs(f[0])) / range;
}

/// How far the searched cubic may lie from the exact one. 20 units of rounding are for its
/// coefficients, including the subtraction of the isovalue, and for points rounded to float
/// (certified_crossing.h); 16 are for the search (cubic.h).
double margin_of(const CellCase& made, double unit) {
  const double lo = made.cell.smallest(), hi = made.cell.largest();
  const double largest = std::max(std::abs(lo - made.isovalue), std::abs(hi - made.isovalue));
  return 36 * unit * largest + (unit > unit_of_double ? 3.1 * unit / 2 * (hi - lo) : 0);
}

/// The first changes of side of the cubics within the margin: the earliest and the latest that any
/// of them may have.
struct Range {
  CellVerdict earliest, latest;
};
Range range_within_margin(const JudgedCell& cell, double unit) {
  const CellCase& made = cell.made;
  const double margin = margin_of(made, unit), towards_start = cell.starts_inside ? margin : -margin;
  // Subtract the isovalue first: the margin may be less than its last digit.
  render::TrilinearCell differences = made.cell;
  for (double& f : differences.corner) f -= made.isovalue;
  const auto with = [&](double shift) {
    return exact_crossing(differences, made.p0, made.p1, shift, cell.starts_inside, std::max(width, unit));
  };
  return {with(towards_start), with(-towards_start)};
}

/// An answer is right when it is the exact change of side. Where it is another or none, it is right
/// when some cubic within the margin has it.
/// @param range  for the method's unit, computed when it is first needed
void compare(const Answer& answer, const JudgedCell& cell, const Method& method, std::optional<Range>& range,
             Tally::OfMethod& tally) {
  const auto& [made, starts_inside, truth] = cell;
  if (answer.crosses) tally.largest_residue = std::max(tally.largest_residue, residue(made, answer.s));
  // Neither the search nor s itself is finer than the last digits of numbers near 1.
  const double s_error = 4 * method.unit + width;
  if (answer.crosses == truth.changes &&
      (!truth.changes || (answer.s >= truth.s.lo - s_error && answer.s <= truth.s.hi + s_error)))
    return;
  if (!range) range = range_within_margin(cell, method.unit);
  if (!answer.crosses && range->latest.changes)
    ++tally.missed;
  else if (answer.crosses && (!range->earliest.changes || answer.s < range->earliest.s.lo - s_error))
    ++tally.extra;
  else if (answer.crosses && range->latest.changes && answer.s > range->latest.s.hi + s_error)
    ++tally.not_first;
  else
    ++tally.ties;
}

/// Compares each proven decision and its bound with the exact answer.
void check_proof(const JudgedCell& cell, Tally& tally) {
  const CellCase& made = cell.made;
  const CellVerdict& truth = cell.truth;
  const auto check = [&](const render::CertifiedCrossing& found) {
    if (found.decision == render::Decision::unknown) return;
    ++tally.proven;
    const bool crosses = found.decision == render::Decision::crosses;
    const bool is_in_bound = truth.s.hi >= found.s - found.s_error && truth.s.lo <= found.s + found.s_error;
    tally.wrongly_proven += crosses != truth.changes || (crosses && !is_in_bound);
  };
  constexpr double point_error = 0x1p-52;  // the smallest that kernels assume
  check(render::certify_crossing<double>(made.cell, made.p0, made.p1, point_error, made.isovalue, cell.starts_inside));
  check(render::certify_crossing<float>(made.cell, made.p0, made.p1, point_error, made.isovalue, cell.starts_inside));
}

Tally tally_of(const study::CellClass& of, std::size_t count, std::uint64_t seed) {
  study::Dice dice(seed);
  std::vector<JudgedCell> cells;
  for (std::size_t c = 0; c < count; ++c) cells.push_back(judged(of.make(dice)));
  Tally tally;
  for (const JudgedCell& cell : cells) {
    ++tally.cells, tally.changes += cell.truth.changes, tally.touches += cell.truth.touches;
    check_proof(cell, tally);
  }
  std::array<Answers, method_count> answers;
  for (std::size_t m = 0; m < method_count; ++m) answers[m] = methods[m].answers(cells);
  for (std::size_t c = 0; c < count; ++c) {
    std::optional<Range> of_float, of_double;
    for (std::size_t m = 0; m < method_count; ++m)
      compare(answers[m][c], cells[c], methods[m], methods[m].unit == unit_of_float ? of_float : of_double,
              tally.of[m]);
  }
  const Answers paper = one_by_one<render::CrossingMethod::paper, double>(cells);
  for (std::size_t c = 0; c < count; ++c) tally.missed_by_paper += cells[c].truth.changes && !paper[c].crosses;
  return tally;
}

std::vector<study::CellClass> all_classes() {
  std::vector<study::CellClass> all(study::cell_classes().begin(), study::cell_classes().end());
  all.insert(all.end(), root_cells().begin(), root_cells().end());
  return all;
}

TEST(TrilinearRoots, of_hard_cells_are_the_first_ones_and_none_is_missed) {
  constexpr std::size_t chunk = 4096;
  const std::vector<study::CellClass> classes = all_classes();
  const std::uint64_t cell_count = asked_count("RHORAY_ROOT_CELLS", 250'000);
  const std::uint64_t chunks = (cell_count + classes.size() * chunk - 1) / (classes.size() * chunk);
  std::uint64_t cells = 0, changes = 0, missed_by_paper = 0;
  for (std::size_t k = 0; k < classes.size(); ++k) {
    Tally whole;
    std::mutex adding;
    parallel_for_each(chunks, [&](std::uint64_t c) {
      const Tally part = tally_of(classes[k], chunk, (k + 1) << 32 | c);
      const std::scoped_lock lock(adding);
      whole.add(part);
    });
    std::cout << classes[k].name << ": " << whole.cells << " cells, " << whole.changes << " changes, " << whole.touches
              << " touches, proven " << whole.proven << ", missed by the paper " << whole.missed_by_paper << "\n";
    for (std::size_t m = 0; m < method_count; ++m) {
      const Tally::OfMethod& of = whole.of[m];
      std::cout << "  " << methods[m].name << ": missed " << of.missed << ", extra " << of.extra << ", not first "
                << of.not_first << ", ties " << of.ties << ", residue " << of.largest_residue << "\n";
      EXPECT_EQ(of.missed, 0U) << classes[k].name << ", " << methods[m].name;
      EXPECT_EQ(of.extra, 0U) << classes[k].name << ", " << methods[m].name;
      EXPECT_EQ(of.not_first, 0U) << classes[k].name << ", " << methods[m].name;
      EXPECT_LE(of.largest_residue, methods[m].largest_residue) << classes[k].name << ", " << methods[m].name;
    }
    EXPECT_EQ(whole.wrongly_proven, 0U) << classes[k].name;
    cells += whole.cells, changes += whole.changes, missed_by_paper += whole.missed_by_paper;
  }
  EXPECT_GE(cells, cell_count);
  EXPECT_GT(changes, cells / 4);
  EXPECT_GT(missed_by_paper, cells / 1000) << "the paper's method is right too: are these cells still hard?";
}

}  // namespace
}  // namespace rhoray::tests

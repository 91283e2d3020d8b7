#include "tests/hard_cases/catalogue/trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "tests/render/support/rays.h"

namespace rhoray::tests {

using render::Hit;
using render::Method;
using render::Ray;

namespace {

constexpr Method judged{.algorithm = Method::Algorithm::exact};
constexpr double place_tolerance_cells = 1e-3, value_tolerance = 1e-6;

/// The widest bound that still locates a hit: in cells, and in t from far away. Points of the ray
/// are known to 2^-49 of |origin| + |t direction|, which is 2 |t direction| there. A hit counts as
/// certain up to 64 times as much (render/cell/certified_crossing.h, is_placed_well).
constexpr double largest_bound_cells = 1e-2, largest_bound_of_t = 64 * 2 * 0x1p-49;

Method in_precision(Method::Algorithm algorithm, Method::Precision precision) {
  return {.algorithm = algorithm, .precision = precision};
}
Method at_steps(double step, bool bisect = false) {
  return {.algorithm = Method::Algorithm::sampled, .step = step, .bisect = bisect};
}

std::string described(const HardCase& hard_case, std::string_view method, const Ray& ray, double isovalue,
                      const Hit& answer, const Hit& truth) {
  std::ostringstream text;
  text << std::setprecision(17) << hard_case.id << ", " << method << ": ray " << ray.origin << " + t " << ray.direction
       << ", t in [" << ray.t_min << ", " << ray.t_max << "], isovalue " << isovalue << ": t " << answer.t << " +- "
       << answer.error << ", value " << answer.value << "; the judge: t " << truth.t << " +- " << truth.error
       << ", value " << truth.value;
  return text.str();
}

}  // namespace

std::span<const NamedMethod> catalogue_methods() {
  using enum Method::Algorithm;
  constexpr auto single = Method::Precision::float32, float64 = Method::Precision::float64;
  static const std::array methods{
      NamedMethod{"preview", in_precision(preview, single), true, false, false},
      NamedMethod{"direct float", in_precision(direct, single), true, true, true},
      NamedMethod{"direct double", in_precision(direct, float64), true, true, true},
      NamedMethod{"paper float", in_precision(paper, single), true, true, false},
      NamedMethod{"paper double", in_precision(paper, float64), true, true, true},
      NamedMethod{"slack 1e-12", {.algorithm = slack, .slack = 1e-12}, false, true, false},
      NamedMethod{"sampled 1", at_steps(1), true, false, true},
      NamedMethod{"sampled 0.5", at_steps(0.5), true, true, true},
      NamedMethod{"sampled 0.25 bisect", at_steps(0.25, true), true, false, false},
      NamedMethod{"certified", {.algorithm = certified}, true, true, true},
  };
  return methods;
}

const NamedMethod& method_named(std::string_view name) {
  for (const NamedMethod& method : catalogue_methods())
    if (method.name == name) return method;
  throw std::invalid_argument("no method of the catalogue is named " + std::string(name));
}

Trial::Trial(const HardCase& hard_case) : case_(hard_case), traced_(hard_case.pack()) {
  for (const double isovalue : case_.isovalues)
    for (const Ray& ray : case_.rays) {
      traced_->scratch.counters = {};
      const Hit hit = ask(ray, isovalue, judged);
      truths_.push_back({hit, traced_->scratch.counters.touches > 0});
    }
}

Hit Trial::ask(const Ray& ray, double isovalue, const Method& method) {
  return case_.asked == Asked::largest_value ? traced_->largest_value(ray, method)
                                             : traced_->first_crossing(ray, isovalue, method);
}

double Trial::t_per_cell(const Ray& ray) const {
  return case_.cell_edge / traced_->ray_data(ray).direction.length();
}

double Trial::longest_edge() const {
  const Vec3 edges = traced_->dataset().bounds().size();
  return std::max({edges.x, edges.y, edges.z});
}

bool Trial::resolves(double moved_by) const {
  return moved_by * longest_edge() <= place_tolerance_cells * case_.cell_edge;
}

bool Trial::is_right(const Hit& answer, const Hit& truth, const Ray& ray, bool proves) const {
  if (answer.is_miss() != truth.is_miss()) return false;
  if (answer.is_miss()) return true;
  // Written so that NaN is wrong.
  const double bound = answer.error + truth.error;
  if (case_.asked == Asked::largest_value) {
    const auto& range = traced_->dataset().field().range;
    return std::abs(answer.value - truth.value) <= (proves ? bound : value_tolerance * (range.hi - range.lo));
  }
  if (proves)
    return std::abs(answer.t - truth.t) <= bound && (answer.error <= largest_bound_cells * t_per_cell(ray) ||
                                                     answer.error <= largest_bound_of_t * std::abs(answer.t));
  return std::abs(answer.t - truth.t) <= place_tolerance_cells * t_per_cell(ray);
}

bool Trial::is_right_when_moved(const Hit& answer, const Ray& ray, double isovalue, double moved_by) {
  constexpr int tries = 200;
  const double farthest = moved_by * longest_edge();
  Dice dice(1);
  for (int n = 0; n < tries; ++n) {
    Ray moved = ray;
    moved.origin += dice.point(Vec3(-farthest), Vec3(farthest));
    if (is_right(answer, ask(moved, isovalue, judged), ray, false)) return true;
  }
  return false;
}

Tally Trial::tally(const NamedMethod& named, double moved_by) {
  Tally tally;
  const bool proves = render::proves(named.method);
  const auto complain = [&](int& count, const std::string& text) {
    ++count;
    if (tally.complaints.size() < 5) tally.complaints.push_back(text);
  };
  std::size_t n = 0;
  for (const double isovalue : case_.isovalues)
    for (const Ray& ray : case_.rays) {
      const Truth& truth = truths_[n++];
      const Hit answer = ask(ray, isovalue, named.method);
      const bool is_there = is_right(answer, truth.hit, ray, proves);
      if (truth.touches && !proves) {
        ++tally.touches;
        tally.touches_lost += !is_there;
        continue;
      }
      ++tally.queries;
      if (is_there || (moved_by > 0 && is_right_when_moved(answer, ray, isovalue, moved_by))) continue;
      complain(answer.is_miss()      ? tally.missed
               : truth.hit.is_miss() ? tally.false_hits
                                     : tally.wrong_place,
               described(case_, named.name, ray, isovalue, answer, truth.hit));
    }
  return tally;
}

Tally Trial::against_known_answers() const {
  Tally tally;
  if (!case_.known) return tally;
  std::size_t n = 0;
  for (const double isovalue : case_.isovalues)
    for (const Ray& ray : case_.rays) {
      const Hit& judge = truths_[n++].hit;
      const std::optional<double> known = case_.known(ray, isovalue);
      if (!known) continue;
      ++tally.queries;
      const bool agrees = case_.asked == Asked::largest_value
                              ? std::abs(judge.value - *known) <= judge.error + 1e-12 * std::abs(*known)
                          : *known == std::numeric_limits<double>::infinity()
                              ? judge.is_miss()
                              : std::abs(judge.t - *known) <=
                                    judge.error + case_.known_cells * t_per_cell(ray) + 0x1p-50 * std::abs(*known);
      if (agrees) continue;
      Hit closed_form;
      (case_.asked == Asked::largest_value ? closed_form.value : closed_form.t) = *known;
      ++tally.wrong_place;
      if (tally.complaints.size() < 5)
        tally.complaints.push_back(described(case_, "closed form", ray, isovalue, closed_form, judge));
    }
  return tally;
}

int Trial::hit_count() const {
  int hits = 0;
  for (const Truth& truth : truths_) hits += !truth.hit.is_miss();
  return hits;
}

std::vector<HardCase> catalogue() {
  std::vector<HardCase> all;
  for (const auto family : {cubic_cases, chord_cases, traversal_cases, value_cases, tet_cases, maximum_cases})
    for (HardCase& hard_case : family()) all.push_back(std::move(hard_case));
  return all;
}

}  // namespace rhoray::tests

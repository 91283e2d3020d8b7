#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "formats/base/json.h"
#include "tools/validate/shots.h"

namespace rhoray::tools::validate {

/// NaN where there are no values.
struct Quantiles {
  std::uint64_t count = 0;
  double p50 = not_measured, p90 = not_measured, p99 = not_measured, p999 = not_measured, largest = not_measured;
};
/// Quantiles of the values that are not NaN.
Quantiles quantiles_of(std::vector<double> values);

struct Measure {
  std::string name;
  std::string unit;
  Quantiles quantiles;
};

/// A number and its limit.
struct Check {
  std::string name;
  double found = not_measured;  ///< NaN if there was nothing to measure
  double limit = 0;
  std::string reason;  ///< reason for this limit

  bool is_measured() const { return !std::isnan(found); }
  bool is_broken() const { return found > limit; }
};

struct RayCounts {
  std::uint64_t rays = 0, hits = 0, missed = 0, false_hits = 0, elsewhere = 0, grazes = 0, undecided = 0;
  std::uint64_t redecided = 0;
};

struct DisputedRay {
  AimedRay ray;
  Verdict verdict = Verdict::right;
  double t_renderer = 0, t_reference = 0;
};

struct Report {
  std::string reference;  ///< description of the reference, a sentence
  std::uint64_t straddling_cells = 0, triangles = 0;
  std::array<RayCounts, aim_count> counts{};
  std::vector<Measure> measures;
  std::vector<Check> checks;
  std::vector<DisputedRay> disputed;  ///< some of the rays whose verdict is not `right`
  std::vector<std::string> notes;

  RayCounts total() const;
  bool holds() const;  ///< no check is broken
  /// NaN if there is no such measure, or nothing was measured
  double largest(std::string_view measure, std::string_view unit) const;
};

/// Limits for the results of a comparison. Lengths are in `unit`, which depends on the kind of
/// data.
struct Limits {
  const char* unit;  ///< "cells" or "box"
  double depth = 0;  ///< in addition to a hit's own bound
  double normal_deg = 0;
  const char* why_none_wrong;  ///< missed, false, elsewhere
  const char* why_depth;
  const char* why_normal;
};

/// Adds counts, measures and checks of all rounds to a report that already describes the reference.
void fill(Report& report, const Rounds& rounds, const Limits& limits);

/// Quantiles of one number of Finding over all of these shots.
Measure measure(std::string name, std::string unit, const Shots& shots, double Finding::*number);

Json json_of(const Report& report);

}  // namespace rhoray::tools::validate

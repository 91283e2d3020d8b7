#pragma once

#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/validate/rays.h"

namespace rhoray::tools::validate {

using Json = nlohmann::ordered_json;

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// What a comparison says of one ray.
enum class Verdict {
  right,
  missed,     ///< the surface is there, and no hit was reported
  false_hit,  ///< a hit, and no surface
  elsewhere,  ///< a hit, but not where the ray first crosses the surface
  grazes,     ///< right for a ray moved by rounding: it passes the surface's outline so closely
  undecided   ///< the reference is not exact enough to tell (grids)
};
std::string_view name_of(Verdict verdict);

/// A ray and what was found about the renderer's answer. Distances come in cells and in diagonals of the data's box;
/// NaN where there is nothing to measure.
struct Finding {
  Verdict verdict = Verdict::right;
  bool was_redecided = false;
  bool is_hit = false;  ///< by the reference
  double t_reference = not_measured;
  double depth_cells = not_measured, depth_box = not_measured;        ///< along the ray, from the reference's crossing
  double bound_cells = not_measured, bound_box = not_measured;        ///< of the depth error, as the method states it
  double distance_cells = not_measured, distance_box = not_measured;  ///< from the hit to the reference surface
  double normal_deg = not_measured;
  double moved_box = not_measured;  ///< of a ray that grazes, how far it was moved
  bool is_above = false;            ///< the hit lies where values are larger than at the reference surface
};

struct Quantiles {
  std::uint64_t count = 0;
  double p50 = 0, p90 = 0, p99 = 0, p999 = 0, largest = 0;
};
/// Of the values that are not NaN.
Quantiles quantiles_of(std::vector<double> values);

struct Measure {
  std::string name;
  std::string unit;
  Quantiles quantiles;
};

/// A number held against its limit.
struct Check {
  std::string name;
  double found = 0, limit = 0;
  std::string reason;  ///< why this limit

  bool holds() const { return found <= limit; }  // written so that a NaN does not hold
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
  std::string reference;  ///< what the renderer was compared with, a sentence
  std::uint64_t straddling_cells = 0, triangles = 0;
  std::array<RayCounts, aim_count> counts{};
  std::vector<Measure> measures;
  std::vector<Check> checks;
  std::vector<DisputedRay> disputed;  ///< some of the rays whose verdict is not `right`
  std::vector<std::string> notes;

  RayCounts total() const;
  bool holds() const;
  double largest(std::string_view measure, std::string_view unit) const;  ///< NaN when there is no such measure
  /// What a method that proves its hits allows itself; 0 for one that does not.
  double largest_bound(std::string_view unit) const;
};

/// What was asked of a comparison.
struct Question {
  double isovalue = 0;
  std::uint64_t samples = 100'000;
  std::uint64_t seed = 1;
  double max_depth_error = 0;              ///< beyond a hit's own bound; 0 = the default of the kind
  std::vector<render::Ray> camera_rays{};  ///< of the picture, if one is wanted
};

/// Rays with their answers, and what was found of each; all three have one entry per ray.
struct Shots {
  std::vector<AimedRay> rays;
  std::vector<render::Hit> hits;
  std::vector<Finding> findings;
};

/// Sends the rays through the tracer; findings are still to be made.
Shots shoot(const Tracer& tracer, std::vector<AimedRay> rays);

/// What a comparison found, and the rays of the picture.
struct Comparison {
  Report report;
  Shots picture;
};

/// Adds the counts of these shots, and the first of those in dispute.
void count(const Shots& shots, Report& report);

/// Calls act(shot) for every shot, on all threads; progress goes from `begin` to `end`.
void for_each_shot(std::size_t count, const Thousandths& progress, std::uint64_t begin, std::uint64_t end,
                   const std::function<void(std::size_t shot)>& act);

/// Adds the bounds that the method states, where it states any.
void add_bounds(const Shots& shots, Report& report);

/// Quantiles of one of Finding's numbers, over all of these shots.
Measure measure(std::string name, std::string unit, const Shots& shots, double Finding::*number);

Json json_of(const Report& report);

}  // namespace rhoray::tools::validate

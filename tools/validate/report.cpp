#include "tools/validate/report.h"

#include <algorithm>
#include <cmath>

#include "formats/base/text.h"

namespace rhoray::tools::validate {

namespace {

constexpr std::size_t disputed_rays_kept = 100;
constexpr const char* bounds_name = "bound stated by the method";
constexpr const char* near_bounds_name = "bound, surface to renderer";

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

/// Names in the JSON.
constexpr std::pair<const char*, std::uint64_t RayCounts::*> count_names[] = {
    {"rays", &RayCounts::rays},           {"hits", &RayCounts::hits},           {"missed", &RayCounts::missed},
    {"false", &RayCounts::false_hits},    {"elsewhere", &RayCounts::elsewhere}, {"grazes", &RayCounts::grazes},
    {"undecided", &RayCounts::undecided}, {"redecided", &RayCounts::redecided}};

Json json_of(std::string_view name, const RayCounts& counts) {
  Json json{{"aim", name}};
  for (const auto& [key, count] : count_names) json[key] = counts.*count;
  return json;
}

Json json_of(const Measure& measure) {
  const Quantiles& q = measure.quantiles;
  return {{"measure", measure.name},  {"unit", measure.unit},        {"count", q.count},
          {"50 %", number(q.p50)},    {"90 %", number(q.p90)},       {"99 %", number(q.p99)},
          {"99.9 %", number(q.p999)}, {"largest", number(q.largest)}};
}

Json json_of(const Check& check) {
  return {{"check", check.name},
          {"found", number(check.found)},
          {"limit", check.limit},
          {"holds", check.is_measured() ? Json(!check.is_broken()) : Json()},
          {"reason", check.reason}};
}

Json json_of(const DisputedRay& ray) {
  return {{"verdict", name_of(ray.verdict)},
          {"aim", name_of(ray.ray.aim)},
          {"origin", rhoray::json_of(ray.ray.ray.origin)},
          {"direction", rhoray::json_of(ray.ray.ray.direction)},
          {"t_renderer", number(ray.t_renderer)},
          {"t_reference", number(ray.t_reference)}};
}

}  // namespace

Quantiles quantiles_of(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  std::sort(values.begin(), values.end());
  if (values.empty()) return {};
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size()))) - 1];
  };
  return {values.size(), at(0.5), at(0.9), at(0.99), at(0.999), values.back()};
}

RayCounts Report::total() const {
  RayCounts sum;
  for (const RayCounts& of_aim : counts)
    for (const auto& [key, count] : count_names) sum.*count += of_aim.*count;
  return sum;
}

bool Report::holds() const {
  return std::none_of(checks.begin(), checks.end(), [](const Check& check) { return check.is_broken(); });
}

double Report::largest(std::string_view name, std::string_view unit) const {
  for (const Measure& each : measures)
    if (each.name == name && each.unit == unit) return each.quantiles.largest;
  return not_measured;
}

Measure measure(std::string name, std::string unit, const Shots& shots, double Finding::*number_of) {
  std::vector<double> values;
  for (const Finding& finding : shots.findings) values.push_back(finding.*number_of);
  return {std::move(name), std::move(unit), quantiles_of(std::move(values))};
}

namespace {

/// The count of a verdict that is not `right`.
std::uint64_t RayCounts::*count_of(Verdict verdict) {
  for (const auto& [key, count] : count_names)
    if (name_of(verdict) == key) return count;
  return nullptr;
}

void count(const Shots& shots, Report& report) {
  for (std::size_t r = 0; r < shots.rays.size(); ++r) {
    const Finding& finding = shots.findings[r];
    RayCounts& counts = report.counts[static_cast<std::size_t>(shots.rays[r].aim)];
    ++counts.rays;
    counts.hits += finding.is_hit;
    counts.redecided += finding.was_redecided;
    if (finding.verdict != Verdict::right) ++(counts.*count_of(finding.verdict));
    if (finding.verdict != Verdict::right && report.disputed.size() < disputed_rays_kept)
      report.disputed.push_back({.ray = shots.rays[r],
                                 .verdict = finding.verdict,
                                 .t_renderer = shots.hits[r].t,
                                 .t_reference = finding.t_reference});
  }
}

void add_measures(const Rounds& rounds, Report& report) {
  const auto add = [&](const char* name, const Shots& shots, double Finding::*cells, double Finding::*box) {
    report.measures.push_back(measure(name, "cells", shots, cells));
    report.measures.push_back(measure(name, "box", shots, box));
  };
  add("depth", rounds.far, &Finding::depth_cells, &Finding::depth_box);
  add("renderer to surface", rounds.far, &Finding::distance_cells, &Finding::distance_box);
  add("surface to renderer", rounds.near, &Finding::depth_cells, &Finding::depth_box);
  report.measures.push_back(measure("normal", "degrees", rounds.far, &Finding::normal_deg));
  for (const auto& [name, shots] : {std::pair{bounds_name, &rounds.far}, {near_bounds_name, &rounds.near}})
    if (measure(name, "box", *shots, &Finding::bound_box).quantiles.count > 0)
      add(name, *shots, &Finding::bound_cells, &Finding::bound_box);
}

/// The largest bound of a method that proves its hits; 0 for one that does not.
double largest_bound(const Report& report, std::string_view name, std::string_view unit) {
  const double bound = report.largest(name, unit);
  return std::isnan(bound) ? 0 : bound;
}

void add_checks(const Limits& limits, Report& report) {
  const RayCounts all = report.total();
  for (const auto& [name, count] :
       {std::pair{"missed", all.missed}, {"false", all.false_hits}, {"elsewhere", all.elsewhere}})
    report.checks.push_back({name, static_cast<double>(count), 0, limits.why_none_wrong});
  for (const auto& [name, measure, bound] : {std::tuple{"largest depth error", "depth", bounds_name},
                                             {"renderer to surface", "renderer to surface", bounds_name},
                                             {"surface to renderer", "surface to renderer", near_bounds_name}})
    report.checks.push_back({concat(name, ", ", limits.unit), report.largest(measure, limits.unit),
                             limits.depth + largest_bound(report, bound, limits.unit), limits.why_depth});
  report.checks.push_back(
      {"largest normal error, degrees", report.largest("normal", "degrees"), limits.normal_deg, limits.why_normal});
}

}  // namespace

void fill(Report& report, const Rounds& rounds, const Limits& limits) {
  for (const Shots* shots : {&rounds.far, &rounds.near, &rounds.camera}) count(*shots, report);
  add_measures(rounds, report);
  add_checks(limits, report);
}

Json json_of(const Report& report) {
  Json json{
      {"reference", report.reference}, {"straddling_cells", report.straddling_cells}, {"triangles", report.triangles}};
  json["rays"] = Json::array();
  for (std::size_t aim = 0; aim < aim_count; ++aim)
    if (report.counts[aim].rays > 0)
      json["rays"].push_back(json_of(name_of(static_cast<Aim>(aim)), report.counts[aim]));
  json["rays"].push_back(json_of("all", report.total()));
  json["measures"] = Json::array();
  for (const Measure& each : report.measures) json["measures"].push_back(json_of(each));
  json["hausdorff"] = Json::array();
  for (const char* way : {"renderer to surface", "surface to renderer"})
    json["hausdorff"].push_back(
        {{"way", way}, {"cells", number(report.largest(way, "cells"))}, {"box", number(report.largest(way, "box"))}});
  json["checks"] = Json::array();
  for (const Check& each : report.checks) json["checks"].push_back(json_of(each));
  json["holds"] = report.holds();
  json["disputed"] = Json::array();
  for (const DisputedRay& each : report.disputed) json["disputed"].push_back(json_of(each));
  json["notes"] = report.notes;
  return json;
}

}  // namespace rhoray::tools::validate

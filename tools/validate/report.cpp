#include "tools/validate/report.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace rhoray::tools::validate {

namespace {

constexpr std::size_t disputed_rays_kept = 100;
constexpr const char* bounds_name = "bound stated by the method";

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json json_of(const Vec3& v) {
  return Json::array({v.x, v.y, v.z});
}

Json json_of(std::string_view name, const RayCounts& counts) {
  return {{"aim", name},
          {"rays", counts.rays},
          {"hits", counts.hits},
          {"missed", counts.missed},
          {"false", counts.false_hits},
          {"elsewhere", counts.elsewhere},
          {"grazes", counts.grazes},
          {"undecided", counts.undecided},
          {"redecided", counts.redecided}};
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
          {"holds", check.holds()},
          {"reason", check.reason}};
}

Json json_of(const DisputedRay& ray) {
  return {{"verdict", name_of(ray.verdict)},       {"aim", name_of(ray.ray.aim)},
          {"origin", json_of(ray.ray.ray.origin)}, {"direction", json_of(ray.ray.ray.direction)},
          {"t_renderer", number(ray.t_renderer)},  {"t_reference", number(ray.t_reference)}};
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  constexpr std::string_view names[] = {"right", "missed", "false", "elsewhere", "grazes", "undecided"};
  return names[static_cast<std::size_t>(verdict)];
}

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
  for (const RayCounts& c : counts) {
    sum.rays += c.rays;
    sum.hits += c.hits;
    sum.missed += c.missed;
    sum.false_hits += c.false_hits;
    sum.elsewhere += c.elsewhere;
    sum.grazes += c.grazes;
    sum.undecided += c.undecided;
    sum.redecided += c.redecided;
  }
  return sum;
}

bool Report::holds() const {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.holds(); });
}

double Report::largest(std::string_view name, std::string_view unit) const {
  for (const Measure& each : measures)
    if (each.name == name && each.unit == unit) return each.quantiles.largest;
  return not_measured;
}

double Report::largest_bound(std::string_view unit) const {
  const double bound = largest(bounds_name, unit);
  return std::isnan(bound) ? 0 : bound;
}

void add_bounds(const Shots& shots, Report& report) {
  Measure in_cells = measure(bounds_name, "cells", shots, &Finding::bound_cells);
  if (in_cells.quantiles.count == 0) return;
  report.measures.push_back(std::move(in_cells));
  report.measures.push_back(measure(bounds_name, "box", shots, &Finding::bound_box));
}

void for_each_shot(std::size_t count, const Thousandths& progress, std::uint64_t begin, std::uint64_t end,
                   const std::function<void(std::size_t shot)>& act) {
  std::atomic<std::size_t> done = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 64), [&](const auto& range) {
    for (std::size_t r = range.begin(); r != range.end(); ++r) act(r);
    progress(begin + (end - begin) * (done += range.size()) / count);
  });
}

Shots shoot(const Tracer& tracer, std::vector<AimedRay> rays) {
  Shots shots{.rays = std::move(rays), .hits = {}, .findings = {}};
  std::vector<render::Ray> bare;
  for (const AimedRay& aimed : shots.rays) bare.push_back(aimed.ray);
  shots.hits.resize(bare.size());
  shots.findings.resize(bare.size());
  tracer(bare, shots.hits);
  return shots;
}

void count(const Shots& shots, Report& report) {
  for (std::size_t r = 0; r < shots.rays.size(); ++r) {
    const Finding& finding = shots.findings[r];
    RayCounts& counts = report.counts[static_cast<std::size_t>(shots.rays[r].aim)];
    ++counts.rays;
    counts.hits += finding.is_hit;
    counts.redecided += finding.was_redecided;
    counts.missed += finding.verdict == Verdict::missed;
    counts.false_hits += finding.verdict == Verdict::false_hit;
    counts.elsewhere += finding.verdict == Verdict::elsewhere;
    counts.grazes += finding.verdict == Verdict::grazes;
    counts.undecided += finding.verdict == Verdict::undecided;
    if (finding.verdict != Verdict::right && report.disputed.size() < disputed_rays_kept)
      report.disputed.push_back({.ray = shots.rays[r],
                                 .verdict = finding.verdict,
                                 .t_renderer = shots.hits[r].t,
                                 .t_reference = finding.t_reference});
  }
}

Measure measure(std::string name, std::string unit, const Shots& shots, double Finding::*number_of) {
  std::vector<double> values;
  for (const Finding& finding : shots.findings) values.push_back(finding.*number_of);
  return {std::move(name), std::move(unit), quantiles_of(std::move(values))};
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

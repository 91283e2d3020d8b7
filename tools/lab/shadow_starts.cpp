#include "tools/lab/shadow_starts.h"

#include <algorithm>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/number_text.h"

namespace rhoray::study {

namespace {

using render::Hit;
using render::Ray;

Vec3 in_single_precision(const Vec3& p) {
  const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
  return {rounded(p.x), rounded(p.y), rounded(p.z)};
}

}  // namespace

const char* name_of(Start start) {
  switch (start) {
    case Start::along_ray:
      return "moved along the ray";
    case Start::along_normal:
      return "moved along the normal";
    case Start::knows_side:
      break;
  }
  return "knows its side";
}

ShadowStarts::ShadowStarts(const render::Dataset& dataset, double isovalue, const render::Truth& truth,
                           const Vec3& towards_light)
    : dataset_(dataset), isovalue_(isovalue) {
  const render::CellLengths lengths(dataset_);
  const Affine& world = render::world_from_ray_frame(dataset_);
  const Affine frame = world.inverse();
  light_ = frame.vector(towards_light.normalized());
  for (std::size_t i = 0; i < truth.hits.size(); ++i) {
    const Hit& hit = truth.hits[i];
    const Vec3 gradient = world.gradient(hit.gradient);
    if (hit.is_miss() || !(gradient.length() > 0)) continue;
    const Ray& seen = truth.rays[i];
    const bool rises = hit.gradient.dot(seen.direction) > 0;
    const Vec3 normal = (rises ? -gradient : gradient).normalized();
    if (!(normal.dot(towards_light) > 0)) continue;
    Case found{.seen = seen, .t = hit.t, .cells_per_t = truth.cells_per_t[i], .normal = frame.vector(normal)};
    const auto cells_along = [&](const Vec3& direction) {
      return lengths.cells_per_t({.origin = seen.at(hit.t), .direction = direction}, Hit{.t = 0, .tet = hit.tet});
    };
    found.cells_along_normal = cells_along(found.normal);
    found.cells_along_light = cells_along(light_);
    found.side = rises ? render::StartSide::outside : render::StartSide::inside;
    cases_.push_back(found);
  }
  decide();
  if (cases_.empty())
    throw Error(ErrorCode::usage, concat("no pixel shows a lit side of the isosurface ", isovalue_, "; expected some"));
}

std::vector<Ray> ShadowStarts::off_surface(double cells) const {
  std::vector<Ray> rays;
  for (const Case& at : cases_)
    rays.push_back({.origin = at.seen.at(at.t) + (cells / at.cells_along_normal) * at.normal, .direction = light_});
  return rays;
}

void ShadowStarts::decide() {
  const render::TraceSpec judge{
      .dataset = dataset_, .isovalue = isovalue_, .method = render::method_of(render::Accuracy::exact)};
  const std::vector<Hit> near = render::trace_rays(judge, off_surface(1e-7)),
                         far = render::trace_rays(judge, off_surface(1e-5));
  std::vector<Case> known;
  for (std::size_t i = 0; i < cases_.size(); ++i) {
    if (near[i].is_miss() != far[i].is_miss()) {
      ++undecided_;
      continue;
    }
    known.push_back(cases_[i]);
    known.back().is_dark = !near[i].is_miss();
  }
  cases_ = std::move(known);
}

std::uint64_t ShadowStarts::dark() const {
  return static_cast<std::uint64_t>(
      std::count_if(cases_.begin(), cases_.end(), [](const Case& at) { return at.is_dark; }));
}

StartCounts ShadowStarts::count(const StartSettings& setting) const {
  std::vector<Ray> seen;
  for (const Case& at : cases_) seen.push_back(at.seen);
  const std::vector<Hit> hits =
      render::trace_rays({.dataset = dataset_, .isovalue = isovalue_, .method = setting.method}, seen);
  std::vector<Ray> rays;
  std::vector<bool> is_dark;
  for (std::size_t i = 0; i < cases_.size(); ++i) {
    const Case& at = cases_[i];
    constexpr double same_place_cells = 0.01;
    // This also skips rays that hit nothing.
    if (!(std::abs(hits[i].t - at.t) * at.cells_per_t < same_place_cells)) continue;
    const Vec3 place = at.seen.at(hits[i].t);
    Ray ray{.origin = setting.is_rounded ? in_single_precision(place) : place, .direction = light_};
    if (setting.start == Start::along_ray)
      ray.origin = ray.origin + (setting.epsilon_cells / at.cells_along_light) * light_;
    if (setting.start == Start::along_normal)
      ray.origin = ray.origin + (setting.epsilon_cells / at.cells_along_normal) * at.normal;
    if (setting.start == Start::knows_side) ray.start_side = at.side;
    rays.push_back(ray);
    is_dark.push_back(at.is_dark);
  }
  const render::Method method = setting.start == Start::knows_side ? setting.method : render::Method{};
  const std::vector<Hit> met = render::trace_rays({.dataset = dataset_, .isovalue = isovalue_, .method = method}, rays);
  StartCounts counts{.rays = rays.size()};
  for (std::size_t i = 0; i < rays.size(); ++i) {
    counts.dark += is_dark[i];
    counts.acne += !is_dark[i] && !met[i].is_miss();
    counts.leaks += is_dark[i] && met[i].is_miss();
  }
  return counts;
}

}  // namespace rhoray::study

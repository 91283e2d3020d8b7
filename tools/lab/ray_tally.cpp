#include "tools/lab/ray_tally.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <span>

namespace rhoray::study {

namespace {

using render::Hit;
using render::Method;
using render::Ray;
using render::RayCaster;

constexpr double elsewhere_cells = 0.01;
constexpr double suspicious_cells = 1e-6;
constexpr double gap_cells = 1e-3;
constexpr std::size_t rays_per_float_ray = 8;

/// CPU time of this thread, so that other work does not count.
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<Hit> answers(RayCaster& asked, std::span<const Ray> rays, RayTally::OfMethod& method) {
  std::vector<Hit> hits(rays.size());
  const double begin = cpu_seconds();
  asked.first_crossings(rays, hits);
  method.cpu_s += cpu_seconds() - begin;
  method.rays += rays.size();
  return hits;
}

/// All queries for the rays of one scene.
class Inquiry {
 public:
  explicit Inquiry(const ClosedScene& scene)
      : scene_(scene),
        single_(scene.dataset, scene.isovalue, {.precision = Method::Precision::float32}),
        float64_(scene.dataset, scene.isovalue, {}),
        certified_(scene.dataset, scene.isovalue, {.algorithm = Method::Algorithm::certified}),
        follower_(scene.dataset, scene.isovalue, {.algorithm = Method::Algorithm::certified}),
        follower_in_double_(scene.dataset, scene.isovalue, {}),
        judge_(scene.dataset, scene.isovalue, {.algorithm = Method::Algorithm::exact}) {}

  RayTally tally(const std::vector<Ray>& rays, Dice& dice, std::uint64_t sample_every);

 private:
  double cells(const Ray& ray, double t) const { return t * ray.direction.length() / scene_.cell_edge; }

  /// For each ray, whether it changes side an odd number of times. The first change is given;
  /// double finds the others.
  std::vector<bool> odd_ones(std::vector<Ray> rays, const std::vector<Hit>& first);
  Ray behind(Ray ray, const Hit& hit) const {
    ray.t_min = hit.t + hit.error + gap_cells * scene_.cell_edge / ray.direction.length();
    return ray;
  }

  bool is_suspicious(const Ray& ray, const Hit& certified, const Hit& float64) const;
  static bool agree(const Hit& certified, const Hit& judged);
  bool follows_judge(Ray ray);
  Hit redecided(const Ray& ray, const Hit& certified, RayTally& tally);
  void count(RayTally::OfMethod& method, const Ray& ray, const Hit& hit, const Hit& truth, bool touches) const;

  const ClosedScene& scene_;
  RayCaster single_, float64_, certified_, follower_, follower_in_double_, judge_;
};

std::string in_full(const Ray& ray) {
  char text[240];
  std::snprintf(text, sizeof text, "%a %a %a + t %a %a %a, t_min %a", ray.origin.x, ray.origin.y, ray.origin.z,
                ray.direction.x, ray.direction.y, ray.direction.z, ray.t_min);
  return text;
}

constexpr std::size_t most_complaints = 20;

void complain(RayTally& tally, const std::string& what, const Ray& ray) {
  if (tally.complaints.size() < most_complaints) tally.complaints.push_back(concat(what, ": ", in_full(ray)));
}

std::vector<bool> Inquiry::odd_ones(std::vector<Ray> rays, const std::vector<Hit>& first) {
  std::vector<bool> odd(rays.size(), false);
  std::vector<std::size_t> going;
  std::vector<Ray> next;
  const auto go_on = [&](std::size_t ray, const Hit& hit) {
    if (hit.is_miss()) return;
    odd[ray] = !odd[ray];
    rays[ray] = behind(rays[ray], hit);
    going.push_back(ray);
    next.push_back(rays[ray]);
  };
  for (std::size_t r = 0; r < rays.size(); ++r) go_on(r, first[r]);
  std::vector<Hit> hits;
  while (!going.empty()) {
    hits.assign(going.size(), {});
    follower_in_double_.first_crossings(next, hits);
    const std::vector<std::size_t> before = std::move(going);
    going.clear();
    next.clear();
    for (std::size_t n = 0; n < before.size(); ++n) go_on(before[n], hits[n]);
  }
  return odd;
}

bool Inquiry::is_suspicious(const Ray& ray, const Hit& certified, const Hit& float64) const {
  if (float64.is_miss() || certified.is_miss()) return float64.is_miss() != certified.is_miss();
  return !(cells(ray, std::abs(float64.t - certified.t) - certified.error) <= suspicious_cells);
}

bool Inquiry::agree(const Hit& certified, const Hit& judged) {
  if (certified.is_miss() || judged.is_miss()) return certified.is_miss() == judged.is_miss();
  return std::abs(certified.t - judged.t) <= certified.error + judged.error;
}

/// True when exact arithmetic finds the same changes of side along the whole ray.
bool Inquiry::follows_judge(Ray ray) {
  for (;;) {
    const Hit hit = follower_.first_crossing(ray);
    if (!agree(hit, judge_.first_crossing(ray))) return false;
    if (hit.is_miss()) return true;
    ray = behind(ray, hit);
  }
}

Hit Inquiry::redecided(const Ray& ray, const Hit& certified, RayTally& tally) {
  const Hit truth = judge_.first_crossing(ray);
  ++tally.redecided;
  if (agree(certified, truth)) return truth;
  if (certified.is_miss() == truth.is_miss()) ++tally.bound_broken;
  complain(tally,
           certified.is_miss() ? "certified missed"
           : truth.is_miss()   ? "certified saw too much"
                               : "certified broke its bound",
           ray);
  return truth;
}

void Inquiry::count(RayTally::OfMethod& method, const Ray& ray, const Hit& hit, const Hit& truth, bool touches) const {
  if (truth.is_miss()) {
    method.extra += !hit.is_miss();
    return;
  }
  const double away = hit.is_miss() ? HUGE_VAL : cells(ray, std::abs(hit.t - truth.t));
  if (away <= elsewhere_cells)
    method.largest_error = std::max(method.largest_error, away);
  else if (!touches)
    ++(hit.is_miss() ? method.missed : method.elsewhere);
}

RayTally Inquiry::tally(const std::vector<Ray>& rays, Dice& dice, std::uint64_t sample_every) {
  RayTally tally;
  const std::span<const Ray> for_float(rays.data(), (rays.size() + rays_per_float_ray - 1) / rays_per_float_ray);
  const std::vector<Hit> single = answers(single_, for_float, tally.single);
  const std::vector<Hit> float64 = answers(float64_, rays, tally.float64);
  const std::vector<Hit> certified = answers(certified_, rays, tally.certified);
  tally.redone = certified_.counters().rays_redone;
  tally.judged = certified_.counters().rays_exact;
  const std::vector<bool> odd = odd_ones(rays, certified);

  for (std::size_t r = 0; r < rays.size(); ++r) {
    ++tally.rays;
    Hit truth = certified[r];
    bool touches = false;
    const bool is_sampled = static_cast<std::uint64_t>(dice.unit() * static_cast<double>(sample_every)) == 0;
    if (is_sampled || odd[r] || is_suspicious(rays[r], certified[r], float64[r])) {
      const std::uint64_t touches_before = judge_.counters().touches;
      truth = redecided(rays[r], certified[r], tally);
      touches = judge_.counters().touches > touches_before;
    }
    if (odd[r]) {
      ++tally.odd;
      if (!follows_judge(rays[r])) {
        ++tally.miscounted;
        complain(tally, "certified is not the judge along the ray", rays[r]);
      }
    }
    tally.hits += !truth.is_miss();
    tally.touches += touches;
    if (!certified[r].is_miss())
      tally.largest_bound = std::max(tally.largest_bound, cells(rays[r], certified[r].error));
    if (r < single.size()) count(tally.single, rays[r], single[r], truth, touches);
    count(tally.float64, rays[r], float64[r], truth, touches);
    count(tally.certified, rays[r], certified[r], truth, false);
  }
  return tally;
}

void add_method(RayTally::OfMethod& to, const RayTally::OfMethod& part) {
  to.rays += part.rays, to.missed += part.missed, to.extra += part.extra, to.elsewhere += part.elsewhere;
  to.largest_error = std::max(to.largest_error, part.largest_error);
  to.cpu_s += part.cpu_s;
}

}  // namespace

void RayTally::add(const RayTally& other) {
  rays += other.rays, hits += other.hits;
  add_method(single, other.single);
  add_method(float64, other.float64);
  add_method(certified, other.certified);
  touches += other.touches, redone += other.redone, judged += other.judged;
  odd += other.odd, miscounted += other.miscounted, redecided += other.redecided;
  bound_broken += other.bound_broken;
  largest_bound = std::max(largest_bound, other.largest_bound);
  for (const std::string& complaint : other.complaints)
    if (complaints.size() < most_complaints) complaints.push_back(complaint);
}

RayTally tally_rays(const ClosedScene& scene, Aim aim, std::uint64_t ray_count, std::uint64_t seed,
                    std::uint64_t sample_every) {
  Dice dice(seed);
  std::vector<Ray> rays(ray_count);
  for (Ray& ray : rays) ray = ray_at(scene, aim, dice);
  return Inquiry(scene).tally(rays, dice, sample_every);
}

}  // namespace rhoray::study

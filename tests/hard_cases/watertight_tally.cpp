#include "tests/hard_cases/watertight_tally.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "formats/base/text.h"
#include "render/dataset/loaded_dataset.h"
#include "render/method.h"
#include "render/query/all_hits.h"
#include "render/query/intersectors.h"
#include "render/render.h"
#include "tests/render/support/ask.h"

namespace rhoray::tests {

namespace {

using render::Accuracy;
using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;
using study::ClosedScene;

/// How far a method may deviate from the given field and ray.
struct Rounding {
  double value;  ///< in largest differences along an edge
  double cells;  ///< of a crossing's position
};
/// A position in a cell is off by 2^-20 cells (render/KERNELS.md). With three axes, the
/// value there is off by 3 times as much of the largest difference. Values and weights are rounded
/// to 2^-24, some ten times.
constexpr Rounding of_float{0x1p-18, 0x1p-17};
/// Rays start up to 1e4 diagonals away, 2^18 cells: positions are rounded by 2^-35 cells, a few
/// times.
constexpr Rounding of_double{0x1p-31, 0x1p-31};

struct Asked {
  const char* name;
  Method method;
  Machine machine;
  Rounding rounding;
};

std::array<Asked, WatertightTally::method_count> asked_methods(const render::Dataset& dataset) {
  const Machine machine = render::chosen_machine();
  constexpr Method certified = render::method_of(Accuracy::certified), single = render::method_of(Accuracy::float32);
  return {{{"certified", certified, machine, {}},
           {"default", render::default_method(dataset, render::Mode::isosurface), machine, of_float},
           {"double", render::method_of(Accuracy::float64), Machine::scalar, of_double},
           {"scalar float", single, Machine::scalar, of_float},
           {"scalar certified", certified, Machine::scalar, {}}}};
}

/// A kernel for queries of one volume.
class Caster {
 public:
  Caster(const render::Dataset& dataset, const Method& method, Machine machine)
      : volume_(dataset.implementation()),
        method_(method),
        kernels_(choose_intersectors(volume_, {.method = method}, machine)) {
    scratch_.queue.reserve(kernels_.queue_entries);
  }

  std::vector<Hit> first_crossings(std::span<const Ray> rays, double isovalue) {
    std::vector<Hit> hits(rays.size());
    ask(kernels_.first_hit, volume_, {.isovalue = isovalue, .method = method_}, rays, hits, scratch_);
    return hits;
  }
  Hit first_crossing(const Ray& ray, double isovalue) { return first_crossings({&ray, 1}, isovalue).front(); }

  const render::KernelCounters& counters() const { return scratch_.counters; }

 private:
  const render::LoadedDataset& volume_;
  Method method_;
  render::Intersectors kernels_;
  render::KernelScratch scratch_;
};

constexpr std::size_t most_complaints = 20;
// Float finds positions to 2^-20 cells where the ray meets the surface at a right angle.
constexpr double gap_cells = 1e-3;

/// The crossings of a ray, in order.
using Chain = std::vector<Hit>;

/// The parts of a ray that lie inside, given its changes of side.
class Sides {
 public:
  Sides(bool starts_inside, std::vector<double> changes) : starts_inside_(starts_inside), t_(std::move(changes)) {}

  bool at(double t) const {
    const auto before = std::upper_bound(t_.begin(), t_.end(), t) - t_.begin();
    return starts_inside_ != (before % 2 != 0);
  }
  const std::vector<double>& changes() const { return t_; }

 private:
  bool starts_inside_;
  std::vector<double> t_;
};

class Inquiry {
 public:
  Inquiry(const ClosedScene& scene, bool is_thorough, std::uint64_t sample_every)
      : scene_(scene),
        method_count_(is_thorough ? WatertightTally::method_count : WatertightTally::wide_count),
        is_thorough_(is_thorough),
        sample_every_(sample_every),
        asked_(asked_methods(scene.dataset)),
        judge_(scene.dataset, render::method_of(Accuracy::exact), Machine::scalar) {
    for (const Asked& asked : asked_) casters_.emplace_back(scene.dataset, asked.method, asked.machine);
    for (const auto& [a, b] : scene.edges)
      largest_step_ = std::max(largest_step_, std::abs(scene.values[a] - scene.values[b]));
  }

  void ask_about(const std::vector<Ray>& rays, bool start_inside, study::Dice& dice);
  void ask_past(const std::vector<Ray>& rays);
  WatertightTally tally();

 private:
  double t_of(const Ray& ray, double cells) const { return cells * scene_.cell_edge / ray.direction.length(); }

  /// The continuation of a ray behind a crossing. The field there determines the side on which it
  /// begins.
  Ray behind(Ray ray, const Hit& hit) const {
    ray.t_min = hit.t + (std::isnan(hit.error) ? 0 : hit.error) + t_of(ray, gap_cells);
    return ray;
  }

  std::vector<Chain> chains(std::size_t method, std::vector<Ray> rays, bool only_first);
  bool chain_is_right(const Ray& ray, bool starts_inside, const Chain& chain, const Rounding& rounding);
  bool side_is_certain(const Ray& ray, bool starts_inside, double t, const Rounding& rounding);
  bool hit_is_right(const Ray& ray, const Hit& hit, const Rounding& rounding);
  std::vector<double> exact_changes(Ray ray, double isovalue);
  bool sides_are_right(const Ray& ray, bool starts_inside, const std::vector<double>& changes);
  void ask_for_all(const std::vector<Ray>& rays, bool start_inside, const std::vector<bool>& sampled);
  bool is_other(const Ray& ray, const Chain& chain, const Chain& certified) const;
  bool is_same(const Ray& ray, const Chain& chain, const Chain& certified, const Rounding& rounding) const;
  void complain(const std::string& what, const Ray& ray);

  const ClosedScene& scene_;
  std::size_t method_count_;  ///< number of leading entries of asked_ in use
  bool is_thorough_;
  std::uint64_t sample_every_;
  std::array<Asked, WatertightTally::method_count> asked_;
  std::vector<Caster> casters_;
  Caster judge_;
  render::Scratch all_hits_scratch_;
  double largest_step_ = 0;
  WatertightTally tally_;
};

void Inquiry::complain(const std::string& what, const Ray& ray) {
  char text[240];
  std::snprintf(text, sizeof text, "%a %a %a + t %a %a %a", ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
                ray.direction.y, ray.direction.z);
  if (tally_.complaints.size() < most_complaints) tally_.complaints.push_back(concat(what, ": ", text));
}

std::vector<Chain> Inquiry::chains(std::size_t method, std::vector<Ray> rays, bool only_first) {
  std::vector<Chain> found(rays.size());
  std::vector<std::size_t> going(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) going[r] = r;
  while (!going.empty()) {
    const std::vector<Hit> hits = casters_[method].first_crossings(rays, scene_.isovalue);
    std::vector<std::size_t> going_on;
    std::vector<Ray> next;
    for (std::size_t n = 0; n < going.size(); ++n) {
      if (hits[n].is_miss()) continue;
      found[going[n]].push_back(hits[n]);
      going_on.push_back(going[n]);
      next.push_back(behind(rays[n], hits[n]));
    }
    if (only_first) break;
    going = std::move(going_on);
    rays = std::move(next);
  }
  return found;
}

/// Computed with exact arithmetic. Two changes closer than 1e-8 cells are not told apart. No part
/// of the field has been made to have this isovalue, so the field is this close to it between two
/// changes with a probability of 1e-16.
std::vector<double> Inquiry::exact_changes(Ray ray, double isovalue) {
  std::vector<double> changes;
  for (;;) {
    const Hit hit = judge_.first_crossing(ray, isovalue);
    if (hit.is_miss()) return changes;
    changes.push_back(hit.t);
    ray.t_min = hit.t + hit.error + t_of(ray, 1e-8);
  }
}

/// True when some field that differs from the given one by rounding has these sides, at positions
/// that differ by rounding. Two kinds of ties are accepted. Two changes at one position: the ray
/// passes through the common edge or vertex of facets, and the order of the facets is lost. And
/// rays that nearly touch the surface.
bool Inquiry::sides_are_right(const Ray& ray, bool starts_inside, const std::vector<double>& changes) {
  const Sides claimed(starts_inside, changes);
  const double step = t_of(ray, of_float.cells), margin = of_float.value * largest_step_;
  for (std::size_t k = 1; k < changes.size(); ++k)
    if (changes[k] - changes[k - 1] <= step) return true;
  const std::array<Sides, 2> exact{Sides(starts_inside, exact_changes(ray, scene_.isovalue - margin)),
                                   Sides(starts_inside, exact_changes(ray, scene_.isovalue + margin))};
  if (exact[0].changes().size() != exact[1].changes().size()) return true;
  for (const bool inside : {false, true}) {
    const Sides& certain = exact[inside ? 1 : 0];
    // Check each part of the ray that certainly lies on this side: at its beginning, and at each
    // claimed change in it.
    std::vector<double> places = certain.changes();
    places.insert(places.begin(), ray.t_min);
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (certain.at(places[p]) != inside) continue;
      const double low = places[p] + (p == 0 ? 0 : step);
      const double high = p + 1 < places.size() ? places[p + 1] - step : HUGE_VAL;
      if (low > high) continue;
      if (claimed.at(low) != inside) return false;
      for (const double t : claimed.changes())
        if (t > low && t < high && claimed.at(std::nextafter(t, HUGE_VAL)) != inside) return false;
    }
  }
  return true;
}

/// A method with proofs must keep its bound. For a method that rounds, the crossing must lie
/// between the exact ones for a slightly lower and a slightly higher isovalue.
bool Inquiry::hit_is_right(const Ray& ray, const Hit& hit, const Rounding& rounding) {
  const Hit truth = judge_.first_crossing(ray, scene_.isovalue);
  if (hit.is_miss() && truth.is_miss()) return true;
  if (rounding.value == 0) return std::abs(truth.t - hit.t) <= truth.error + hit.error;
  const double step = t_of(ray, rounding.cells), margin = rounding.value * largest_step_;
  if (std::abs(hit.t - truth.t) <= step) return true;
  const double below = judge_.first_crossing(ray, scene_.isovalue - margin).t,
               above = judge_.first_crossing(ray, scene_.isovalue + margin).t;
  return hit.t >= std::min({truth.t, below, above}) - step && hit.t <= std::max({truth.t, below, above}) + step;
}

/// True when rounding leaves no doubt about the side of a position on the ray.
bool Inquiry::side_is_certain(const Ray& ray, bool starts_inside, double t, const Rounding& rounding) {
  const double margin = rounding.value * largest_step_;
  return Sides(starts_inside, exact_changes(ray, scene_.isovalue - margin)).at(t) ==
         Sides(starts_inside, exact_changes(ray, scene_.isovalue + margin)).at(t);
}

/// Checks every crossing that was found, and that there is none behind the last. Each is checked
/// for the continuation that the method traced. For a method that rounds, a failure counts only if
/// the side at the continuation's start is certain.
bool Inquiry::chain_is_right(const Ray& ray, bool starts_inside, const Chain& chain, const Rounding& rounding) {
  Ray rest = ray;
  for (std::size_t k = 0; k <= chain.size() && (is_thorough_ || k == 0); ++k) {
    const Hit hit = k < chain.size() ? chain[k] : Hit();
    if (!hit_is_right(rest, hit, rounding))
      return rounding.value > 0 && k > 0 && !side_is_certain(ray, starts_inside, rest.t_min, rounding);
    rest = behind(rest, hit);
  }
  return true;
}

bool Inquiry::is_other(const Ray& ray, const Chain& chain, const Chain& certified) const {
  if (chain.empty() || certified.empty()) return chain.empty() != certified.empty();
  return !(std::abs(chain[0].t - certified[0].t) <= certified[0].error + t_of(ray, gap_cells));
}

bool Inquiry::is_same(const Ray& ray, const Chain& chain, const Chain& certified, const Rounding& rounding) const {
  const auto is_close = [&](const Hit& a, const Hit& b) {
    return std::abs(a.t - b.t) <= t_of(ray, rounding.cells) + b.error + (std::isnan(a.error) ? 0 : a.error);
  };
  return std::equal(chain.begin(), chain.end(), certified.begin(), certified.end(), is_close);
}

void Inquiry::ask_about(const std::vector<Ray>& rays, bool start_inside, study::Dice& dice) {
  tally_.rays += rays.size();
  std::vector<bool> sampled(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r)
    sampled[r] = static_cast<std::uint64_t>(dice.unit() * static_cast<double>(sample_every_)) == 0;
  std::array<std::vector<Chain>, WatertightTally::method_count> found;
  for (std::size_t m = 0; m < method_count_; ++m) found[m] = chains(m, rays, !is_thorough_);

  std::vector<bool> is_redecided = sampled, confirmed(rays.size(), false);
  for (std::size_t m = 0; m < method_count_; ++m) {
    const bool is_proven = proves(asked_[m].method);
    WatertightTally::OfMethod& count = tally_.of_method[m];
    for (std::size_t r = 0; r < rays.size(); ++r) {
      const Chain& chain = found[m][r];
      ++count.rays, count.hits += !chain.empty(), count.crossings += chain.size();
      const bool parity = is_thorough_ && (chain.size() % 2 != 0) != start_inside;
      const bool other = is_other(rays[r], is_proven ? found[1][r] : chain, is_proven ? chain : found[0][r]);
      count.parity += parity, count.other += other;
      if (!parity && !other && !sampled[r]) continue;
      // Where exact arithmetic has confirmed the certified answer, the same answer from another
      // method is right, too.
      const bool is_confirmed = m > 0 && confirmed[r] && is_same(rays[r], chain, found[0][r], asked_[m].rounding);
      const bool is_right = is_confirmed || chain_is_right(rays[r], start_inside, chain, asked_[m].rounding);
      is_redecided[r] = true;
      if (m == 0) confirmed[r] = is_right;
      if (is_right) {
        count.ties += parity || other;
        continue;
      }
      ++count.wrong;
      complain(concat(asked_[m].name, start_inside ? ", from inside" : "", ", ", chain.size(), " crossings"), rays[r]);
    }
  }
  ask_for_all(rays, start_inside, sampled);
  tally_.redecided += static_cast<std::uint64_t>(std::count(is_redecided.begin(), is_redecided.end(), true));
}

void Inquiry::ask_for_all(const std::vector<Ray>& rays, bool start_inside, const std::vector<bool>& sampled) {
  const std::vector<AllCrossings> found = all_crossings(scene_, rays, render::chosen_machine(), all_hits_scratch_);
  for (std::size_t r = 0; r < found.size(); ++r) {
    if (!found[r].is_complete) continue;
    const std::vector<double>& changes = found[r].t;
    const bool parity = (changes.size() % 2 != 0) != start_inside;
    ++tally_.all.rays, tally_.all.hits += !changes.empty(), tally_.all.crossings += changes.size();
    tally_.all.parity += parity;
    if (!parity && !sampled[r]) continue;
    const bool is_right = sides_are_right(rays[r], start_inside, changes);
    tally_.all.ties += is_right && parity;
    tally_.all.wrong += !is_right;
    if (parity || !is_right)
      complain(
          concat("all crossings", start_inside ? ", from inside" : "", ", ", changes.size(), is_right ? ", a tie" : ""),
          rays[r]);
  }
}

void Inquiry::ask_past(const std::vector<Ray>& rays) {
  tally_.rays += rays.size();
  for (std::size_t m = 0; m < method_count_; ++m) {
    const std::vector<Hit> hits = casters_[m].first_crossings(rays, scene_.isovalue);
    tally_.of_method[m].rays += rays.size();
    for (std::size_t r = 0; r < rays.size(); ++r) {
      if (hits[r].is_miss()) continue;
      ++tally_.of_method[m].met_past;
      complain(concat(asked_[m].name, ", past the surface"), rays[r]);
    }
  }
}

WatertightTally Inquiry::tally() {
  for (std::size_t m = 0; m < method_count_; ++m) tally_.of_method[m].wide = casters_[m].counters().rays_wide;
  return tally_;
}

}  // namespace

std::vector<AllCrossings> all_crossings(const ClosedScene& scene, std::span<const Ray> rays, Machine machine,
                                        render::Scratch& scratch) {
  const render::LoadedDataset& dataset = scene.dataset.implementation();
  const render::AllHitsKernel kernel =
      render::choose_intersectors(dataset, {.isovalue = scene.isovalue, .method = render::method_of(Accuracy::float32)},
                                  machine)
          .all_hits;
  if (kernel == nullptr) return {};
  const render::TransparentSurface surface{.isovalue = scene.isovalue};
  render::RayBatch batch(rays.size());
  render::HitBatch first(rays.size());
  render::CrossingList list(rays.size());
  list.put_first_into(first);
  render::CrossingList* const lists = &list;
  std::vector<std::uint8_t> complete(rays.size());
  batch.count = rays.size();
  for (std::size_t r = 0; r < rays.size(); ++r) batch.set(r, rays[r]);
  render::KernelCounters counters;
  kernel(dataset, {.surfaces = {&surface, 1}}, batch, {&lists, 1}, complete.data(), scratch, counters);
  std::vector<AllCrossings> found(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) {
    found[r].is_complete = complete[r] != 0;
    for (std::size_t k = 0; k < list.count[r]; ++k) found[r].t.push_back(list.hits(k)[r].t);
  }
  return found;
}

const char* WatertightTally::name(std::size_t method) {
  constexpr std::array names{"certified", "default", "double", "scalar float", "scalar certified"};
  return names[method];
}

void WatertightTally::add(const WatertightTally& part) {
  rays += part.rays, redecided += part.redecided;
  const auto add_method = [](OfMethod& to, const OfMethod& from) {
    to.rays += from.rays, to.hits += from.hits, to.crossings += from.crossings, to.wide += from.wide;
    to.parity += from.parity, to.other += from.other, to.ties += from.ties, to.wrong += from.wrong;
    to.met_past += from.met_past;
  };
  for (std::size_t m = 0; m < method_count; ++m) add_method(of_method[m], part.of_method[m]);
  add_method(all, part.all);
  for (const std::string& complaint : part.complaints)
    if (complaints.size() < most_complaints) complaints.push_back(complaint);
}

WatertightTally tally_watertight(const ClosedScene& scene, study::Aim aim, std::size_t count, std::uint64_t seed,
                                 bool is_thorough, std::uint64_t sample_every) {
  study::Dice dice(seed);
  const WatertightRays rays = watertight_rays(scene, aim, count, dice);
  Inquiry inquiry(scene, is_thorough, sample_every);
  inquiry.ask_about(rays.through, false, dice);
  inquiry.ask_about(rays.from_inside, true, dice);
  inquiry.ask_past(rays.past);
  return inquiry.tally();
}

}  // namespace rhoray::tests

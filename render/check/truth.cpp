#include "render/truth.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numeric>
#include <random>

#include "formats/base/checks.h"
#include "formats/base/floating_point.h"
#include "formats/base/parallel.h"
#include "formats/base/stopping.h"

namespace rhoray::render {

namespace {

/// Rays that a thread takes at a time; a stop request waits for them. Kernels answer groups of up
/// to 64, but a ray in exact arithmetic can take milliseconds.
std::size_t piece_for(const Method& method) {
  return method.algorithm == Method::Algorithm::exact ? 4 : 512;
}

/// Calls act(range) for pieces of the rays.
template <class Act>
void for_each_piece(const TraceSpec& spec, std::size_t count, const Act& act) {
  ProgressMeter meter(spec.watch.progress, "tracing (rays)", count);
  const auto act_unless_stopped = [&](const IndexRange& part) {
    if (spec.watch.stop.stop_requested()) return;
    act(part);
    meter.add(part.size());
  };
  parallel_for(count, piece_for(spec.method), act_unless_stopped, spec.threads);
  end_if_stopped(spec.watch.stop);
}

void trace_crossings(const TraceSpec& spec, std::span<const Ray> rays, std::span<Hit> hits) {
  const Machine machine = spec.machine.value_or(chosen_machine());
  const RayCaster queries(spec.dataset, spec.isovalue, spec.method, 1, machine, spec.watch);
  if (!rays.empty()) queries.prepare_first_crossings(machine, spec.threads, spec.watch);
  PerWorker<RayCaster::Scratch> scratch([&] { return RayCaster::Scratch(machine); });
  for_each_piece(spec, rays.size(), [&](const IndexRange& part) {
    queries.first_crossings(rays.subspan(part.begin(), part.size()), hits.subspan(part.begin(), part.size()),
                            scratch.of(part));
  });
}

/// Each thread has its own RayCaster, because the search keeps data from ray to ray. The results do
/// not depend on them.
void trace_largest(const TraceSpec& spec, std::span<const Ray> rays, std::span<Hit> hits) {
  if (proves(spec.method)) spec.dataset.prove_ranges(spec.threads, spec.watch);
  PerWorker<RayCaster> queries(
      [&] { return RayCaster(spec.dataset, spec.isovalue, spec.method, 1, spec.machine, spec.watch.stop); });
  for_each_piece(spec, rays.size(), [&](const IndexRange& part) {
    queries.of(part).largest_values(rays.subspan(part.begin(), part.size()), hits.subspan(part.begin(), part.size()));
  });
}

std::vector<Hit> trace_whole(const TraceSpec& spec, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  if (spec.mode == Mode::mip)
    trace_largest(spec, rays, hits);
  else
    trace_crossings(spec, rays, hits);
  return hits;
}

/// Interval of t in which a ray in world axes is inside a clip region's half spaces; empty if
/// `from` is above `to`.
Interval<double> span_in(const std::vector<HalfSpace>& halves, const Ray& ray) {
  Interval<double> span{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const HalfSpace& half : halves) {
    const double slope = half.normal.dot(ray.direction), height = half.normal.dot(half.point - ray.origin);
    if (slope > 0)
      span.lo = std::max(span.lo, height / slope);
    else if (slope < 0)
      span.hi = std::min(span.hi, height / slope);
    else if (height > 0)
      span.hi = -std::numeric_limits<double>::infinity();
  }
  return span;
}

/// Traces the parts of rays that the clip region keeps: the first part of each ray, and with
/// cuts_away also the second part behind the gap. Empty parts are not traced.
std::vector<Hit> trace_clipped(const TraceSpec& spec, std::span<const Ray> rays) {
  const std::vector<HalfSpace> halves = half_spaces_of(*spec.clip);
  const Affine& world_from_rays = world_from_ray_frame(spec.dataset);
  std::vector<Hit> hits(rays.size());
  for (const int part : {0, 1}) {
    if (part == 1 && !spec.clip->cuts_away) break;
    std::vector<std::size_t> asked;
    std::vector<Ray> parts;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      Ray ray = rays[i];
      const Ray in_world{world_from_rays.point(ray.origin), world_from_rays.vector(ray.direction)};
      const Interval<double> span = span_in(halves, in_world);
      const bool passes_by = !(span.lo <= span.hi);
      if (!spec.clip->cuts_away) {
        ray.t_min = std::max(ray.t_min, span.lo);
        ray.t_max = std::min(ray.t_max, span.hi);
      } else if (part == 0 && !passes_by) {
        ray.t_max = std::min(ray.t_max, span.lo);
      } else if (part == 1) {
        ray.t_min = passes_by ? std::numeric_limits<double>::infinity() : std::max(ray.t_min, span.hi);
      }
      const bool is_decided = part == 1 && spec.mode != Mode::mip && !hits[i].is_miss();
      if (is_decided || !(ray.t_min < ray.t_max)) continue;
      asked.push_back(i);
      parts.push_back(ray);
    }
    const std::vector<Hit> found = trace_whole(spec, parts);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      Hit& hit = hits[asked[i]];
      if (hit.is_miss() || (!found[i].is_miss() && found[i].value > hit.value)) hit = found[i];
    }
  }
  return hits;
}

/// All pixels in random order. The standard defines the generator's numbers, so a seed gives the
/// same order everywhere.
std::vector<std::uint32_t> shuffled_pixels(std::uint64_t count, std::uint64_t seed) {
  RHORAY_CHECK(count <= std::numeric_limits<std::uint32_t>::max());
  std::vector<std::uint32_t> pixels(count);
  std::iota(pixels.begin(), pixels.end(), 0U);
  std::mt19937_64 random(seed);
  for (std::size_t left = pixels.size(); left > 1; --left) std::swap(pixels[left - 1], pixels[random() % left]);
  return pixels;
}

}  // namespace

const Clip* clip_of(const Scene& scene, const Layer& layer) {
  return scene.clip && layer.clipped ? &*scene.clip : nullptr;
}

std::vector<Hit> trace_rays(const TraceSpec& spec, std::span<const Ray> rays) {
  const DefaultFloatingPoint default_floating_point;
  if (spec.clip != nullptr) return trace_clipped(spec, rays);
  return trace_whole(spec, rays);
}

std::uint64_t Truth::hit_count() const {
  return static_cast<std::uint64_t>(
      std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return !hit.is_miss(); }));
}

Truth find_truth(const TruthSpec& spec) {
  const DefaultFloatingPoint default_floating_point;
  Truth truth{.size = spec.size};
  std::vector<std::uint32_t> order = shuffled_pixels(truth.pixel_count(), spec.seed);
  order.resize(std::min<std::size_t>(order.size(), spec.most_pixels));
  const Layer& layer = spec.scene.layers[0];
  const TraceSpec exact{.dataset = spec.dataset,
                        .mode = layer.mode,
                        .isovalue = layer.isovalue,
                        .method = method_of(Accuracy::exact),
                        .clip = clip_of(spec.scene, layer),
                        .threads = spec.threads,
                        .watch = spec.watch.stop};
  spec.dataset.prove_ranges(spec.threads, spec.watch);
  const CellLengths lengths(spec.dataset);
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu_begin = std::clock();  // of all threads of this process
  const auto is_in_time = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < spec.seconds;
  };
  constexpr std::size_t rays_at_a_time = 256;
  ProgressMeter meter(spec.watch.progress, "tracing in exact arithmetic (rays)", order.size());
  std::vector<Ray> rays;  // in that order, as the hits
  std::vector<Hit> hits;
  while (hits.size() < order.size() && (hits.empty() || is_in_time())) {
    const std::size_t count = std::min(rays_at_a_time, order.size() - hits.size());
    const std::vector<Ray> some = camera_rays(spec.dataset, spec.scene.camera, spec.size.width, spec.size.height,
                                              std::span(order).subspan(hits.size(), count));
    const std::vector<Hit> found = trace_rays(exact, some);
    rays.insert(rays.end(), some.begin(), some.end());
    hits.insert(hits.end(), found.begin(), found.end());
    meter.add(count);
  }
  truth.cpu_s = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  std::vector<std::size_t> rising(hits.size());
  std::iota(rising.begin(), rising.end(), std::size_t{0});
  std::sort(rising.begin(), rising.end(), [&](std::size_t a, std::size_t b) { return order[a] < order[b]; });
  for (const std::size_t i : rising) {
    truth.pixels.push_back(order[i]);
    truth.rays.push_back(rays[i]);
    truth.hits.push_back(hits[i]);
    truth.cells_per_t.push_back(hits[i].is_miss() ? 0 : lengths.cells_per_t(truth.rays.back(), hits[i]));
  }
  return truth;
}

ErrorList errors_against(const Truth& truth, Mode mode, std::span<const Hit> hits) {
  RHORAY_CHECK(hits.size() == truth.hits.size());
  ErrorList list;
  list.errors.reserve(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Hit &is = truth.hits[i], &said = hits[i];
    if (is.is_miss() || said.is_miss()) {
      list.errors.push_back(is.is_miss() && said.is_miss() ? nothing_there : is.is_miss() ? is_false : is_missed);
    } else if (mode == Mode::mip) {
      list.value_errors.push_back(std::abs(said.value - is.value));
      list.errors.push_back(static_cast<float>(list.value_errors.back()));
    } else {
      list.errors.push_back(static_cast<float>(std::abs(said.t - is.t) * truth.cells_per_t[i]));
    }
  }
  return list;
}

}  // namespace rhoray::render

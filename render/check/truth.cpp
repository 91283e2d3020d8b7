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

constexpr std::size_t rays_at_a_time = 256;  // a stop request waits for so many

void trace_crossings(const TraceSpec& spec, std::span<const Ray> rays, std::span<Hit> hits) {
  RayCaster queries(spec.dataset, spec.isovalue, spec.method, spec.threads, spec.machine, spec.stop);
  for (std::size_t first = 0; first < rays.size(); first += rays_at_a_time) {
    end_if_stopped(spec.stop);
    const std::size_t count = std::min(rays_at_a_time, rays.size() - first);
    queries.first_crossings(rays.subspan(first, count), hits.subspan(first, count));
  }
}

/// Each thread has its own RayCaster, because the search keeps data from ray to ray. The results do
/// not depend on them.
void trace_largest(const TraceSpec& spec, std::span<const Ray> rays, std::span<Hit> hits) {
  constexpr std::size_t piece = 512;
  PerWorker<RayCaster> queries(
      [&] { return RayCaster(spec.dataset, spec.isovalue, spec.method, 1, spec.machine, spec.stop); });
  const auto answer = [&](const IndexRange& part) {
    if (spec.stop.stop_requested()) return;
    queries.of(part).largest_values(rays.subspan(part.begin(), part.size()), hits.subspan(part.begin(), part.size()));
  };
  parallel_for(rays.size(), piece, answer, spec.threads);
  end_if_stopped(spec.stop);
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

std::vector<Ray> pixel_rays(const Dataset& dataset, const Camera& camera, const PictureSize& size,
                            std::span<const std::uint32_t> pixels) {
  std::vector<Ray> all = camera_rays(dataset, camera, size.width, size.height);
  if (pixels.size() == all.size()) return all;
  std::vector<Ray> rays;
  rays.reserve(pixels.size());
  for (const std::uint32_t pixel : pixels) rays.push_back(all[pixel]);
  return rays;
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
                        .stop = spec.stop};
  const CellLengths lengths(spec.dataset);
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu_begin = std::clock();  // of all threads of this process
  const auto is_in_time = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < spec.seconds;
  };
  std::vector<Hit> hits;  // in that order
  const std::vector<Ray> rays = pixel_rays(spec.dataset, spec.scene.camera, spec.size, order);
  // Then pixel_rays returns all rays in the picture's order.
  const bool is_ordered = order.size() == truth.pixel_count();
  std::size_t done = 0;
  std::vector<Ray> some;
  while (done < order.size() && (done == 0 || is_in_time())) {
    const std::size_t count = std::min(rays_at_a_time, order.size() - done);
    some.clear();
    for (std::size_t i = done; i < done + count; ++i) some.push_back(is_ordered ? rays[order[i]] : rays[i]);
    const std::vector<Hit> found = trace_rays(exact, some);
    hits.insert(hits.end(), found.begin(), found.end());
    done += count;
  }
  truth.cpu_s = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  std::vector<std::size_t> rising(done);
  std::iota(rising.begin(), rising.end(), std::size_t{0});
  std::sort(rising.begin(), rising.end(), [&](std::size_t a, std::size_t b) { return order[a] < order[b]; });
  for (const std::size_t i : rising) {
    truth.pixels.push_back(order[i]);
    truth.rays.push_back(is_ordered ? rays[order[i]] : rays[i]);
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

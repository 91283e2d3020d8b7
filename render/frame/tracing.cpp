#include "render/frame/tracing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/frame/lighting.h"
#include "render/march/ticks.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Less of the light behind than this is not looked for.
constexpr float least_light = 1.0F / 1024;

void ask_layer(const FrameLayer& layer, const PixelRays& rays, const Tile& tile, bool ends_at_nearest, Worker& worker,
               LayerWork& work) {
  if (work.rays_begun_by != &rays) rays.begin(work.rays);
  work.rays_begun_by = &rays;
  rays.fill(tile, work.rays);
  if (ends_at_nearest) std::copy_n(worker.nearest.data(), work.rays.count, work.rays.t_max.data());
  work.scratch.last_t.reset();
  layer.kernel(layer.volume, layer.question, work.rays, work.hits, work.scratch);
}

/// Of surfaces at the same t the one whose layer comes first.
void keep_nearest(const LayerWork& work, std::uint8_t layer, Worker& worker) {
  const double* t = work.hits.t.data();
  double* nearest = worker.nearest.data();
  for (std::size_t r = 0; r < work.rays.count; ++r) {
    const bool is_nearer = t[r] < nearest[r];
    nearest[r] = is_nearer ? t[r] : nearest[r];
    worker.shown.of[r] = is_nearer ? layer : worker.shown.of[r];
  }
}

/// The clear layer whose surface each ray meets next, into `next`.
/// @return  false where no ray meets any
bool find_next(const Frame& frame, const Worker& worker, std::size_t ray_count, LayerOfRays& next) {
  bool any = false;
  for (std::size_t r = 0; r < ray_count; ++r) {
    double t = infinity;
    next.of[r] = LayerOfRays::none;
    for (std::size_t l = 0; l < frame.layers.size(); ++l) {
      if (frame.layers[l].part != Part::clear || !(worker.layers[l].hits.t[r] < t)) continue;
      t = worker.layers[l].hits.t[r];
      next.of[r] = static_cast<std::uint8_t>(l);
    }
    any |= next.of[r] != LayerOfRays::none;
  }
  return any;
}

/// The ray behind its crossing. Where two crossings were met at one t the next is looked for behind it, so that
/// surfaces folded into each other come to an end.
/// @param is_field  the crossing is a field's, whose sides take turns; triangles may face any way
Ray behind(const Ray& ray, const Hit& hit, bool is_field) {
  Ray rest = ray;
  rest.t_min = hit.t > ray.t_min ? hit.t : std::nextafter(hit.t, infinity);
  if (ray.start_side == StartSide::unknown || !is_field)
    rest.start_side = hit.gradient.dot(ray.direction) > 0 ? StartSide::inside : StartSide::outside;
  else
    rest.start_side = ray.start_side == StartSide::inside ? StartSide::outside : StartSide::inside;
  return rest;
}

/// Makes the rays that show a layer's crossing go on behind it.
void leave_crossings(const FrameLayer& layer, std::uint8_t index, const LayerOfRays& shown, LayerWork& work) {
  const bool is_field = layer.look.layer.mode != Mode::triangles;
  for (std::size_t r = 0; r < work.rays.count; ++r)
    if (shown.of[r] == index) work.rays.set(r, behind(work.rays[r], work.hits[r], is_field));
}

constexpr double not_asked = -1;  // where a ray would end

/// Writes the rays of a group that go on, each in its own place, where neighbours in the picture share what they meet.
/// Of those through which no light would be seen there is no next hit.
/// @param place  of the group among the worker's few rays
/// @return       how many go on
std::size_t write_group(LayerWork& work, std::uint8_t index, const LayerOfRays& shown, std::size_t first,
                        std::size_t place, Worker& worker) {
  std::size_t count = 0;
  Ray not_going = work.rays[first];
  not_going.t_max = not_asked;
  for (std::size_t i = 0; i < RayBatch::group_size; ++i) {
    const std::size_t r = first + i;
    const bool is_left = r < work.rays.count && shown.of[r] == index;
    const bool goes_on = is_left && !(worker.front.alpha[r] < least_light);
    if (is_left && !goes_on) work.hits.t[r] = infinity;
    worker.few_rays.set(place + i, goes_on ? work.rays[r] : not_going);
    count += goes_on;
  }
  return count;
}

/// Asks for what these rays meet next, where light from there would be seen.
void go_on(const FrameLayer& layer, std::uint8_t index, const LayerOfRays& shown, Worker& worker) {
  LayerWork& work = worker.layers[index];
  worker.few.clear();
  for (std::size_t first = 0; first < work.rays.count; first += RayBatch::group_size) {
    const std::size_t place = worker.few.size() * RayBatch::group_size;
    const std::size_t going = write_group(work, index, shown, first, place, worker);
    if (going != 0) worker.few.push_back(static_cast<std::uint32_t>(first));
    worker.counts.rays_through += going;
  }
  if (worker.few.empty()) return;
  worker.few_rays.count = worker.few.size() * RayBatch::group_size;
  const std::uint64_t start = ticks_now();
  layer.kernel_through(layer.volume, layer.question_through, worker.few_rays, worker.few_hits, work.scratch);
  worker.counts.shading_ticks -= ticks_now() - start;  // rays are no shading, within which this is called
  for (std::size_t g = 0; g < worker.few.size(); ++g)
    for (std::size_t i = 0; i < RayBatch::group_size; ++i)
      if (const std::size_t at = g * RayBatch::group_size + i; worker.few_rays.t_max[at] >= 0)
        work.hits.set(worker.few[g] + i, worker.few_hits[at]);
}

}  // namespace

void trace_layers(const Frame& frame, const LatticeRays& rays, const Tile& tile, Worker& worker) {
  if (frame.has_one_layer()) {
    ask_layer(frame.layers[0], rays.of_layers[0], tile, false, worker, worker.layers[0]);
    return;
  }
  std::fill_n(worker.nearest.data(), tile_capacity, infinity);
  std::fill_n(worker.shown.of, tile_capacity, LayerOfRays::none);
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    LayerWork& work = worker.layers[l];
    ask_layer(frame.layers[l], rays.of_layers[l], tile, true, worker, work);
    if (frame.layers[l].part == Part::opaque) keep_nearest(work, static_cast<std::uint8_t>(l), worker);
  }
}

void peel_clear_layers(const Frame& frame, Worker& worker) {
  const std::size_t ray_count = worker.layers[0].rays.count;
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    if (frame.layers[l].part != Part::clear) continue;
    RayBatch& rays = worker.layers[l].rays;
    rays.has_start_sides = true;
    std::fill_n(rays.start_side.data(), ray_count, StartSide::unknown);
  }
  LayerOfRays next;
  while (find_next(frame, worker, ray_count, next))
    for (std::size_t l = 0; l < frame.layers.size(); ++l) {
      if (frame.layers[l].part != Part::clear) continue;
      const auto index = static_cast<std::uint8_t>(l);
      receive_light(frame, index, &next, worker);
      leave_crossings(frame.layers[l], index, next, worker.layers[l]);
      shade_clear(frame.layers[l].look, worker.layers[l], next, index, worker.received, worker.counts, worker.front);
      go_on(frame.layers[l], index, next, worker);
    }
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    if (frame.layers[l].part != Part::clear) continue;
    RayBatch& rays = worker.layers[l].rays;
    rays.has_start_sides = false;
    std::fill_n(rays.t_min.data(), ray_count, 0.0);
  }
}

}  // namespace rhoray::render

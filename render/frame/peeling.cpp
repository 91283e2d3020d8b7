#include "render/frame/peeling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "render/frame/clip_gap.h"
#include "render/frame/lighting.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Finds the transparent layer whose surface each ray hits next.
/// @return  false if no ray hits any
bool find_next(const Frame& frame, const Worker& worker, std::size_t ray_count, LayerOfRays& next) {
  bool any = false;
  for (std::size_t r = 0; r < ray_count; ++r) {
    double t = infinity;
    next.of[r] = LayerOfRays::none;
    for (std::size_t l = 0; l < frame.layers.size(); ++l) {
      if (frame.layers[l].blend != Blend::transparent || !(worker.layers[l].hits.t[r] < t)) continue;
      t = worker.layers[l].hits.t[r];
      next.of[r] = static_cast<std::uint8_t>(l);
    }
    any |= next.of[r] != LayerOfRays::none;
  }
  return any;
}

}  // namespace

Ray behind(const Ray& ray, const Hit& hit, bool is_field) {
  Ray rest = ray;
  rest.t_min = hit.t > ray.t_min ? hit.t : std::nextafter(hit.t, infinity);
  if (ray.start_side == StartSide::unknown || !is_field)
    rest.start_side = hit.gradient.dot(ray.direction) > 0 ? StartSide::inside : StartSide::outside;
  else
    rest.start_side = ray.start_side == StartSide::inside ? StartSide::outside : StartSide::inside;
  return rest;
}

namespace {

/// Moves the rays that show a layer's crossing to behind it.
void leave_crossings(const FrameLayer& layer, std::uint8_t index, const LayerOfRays& shown, LayerWork& work) {
  const bool is_field = layer.shading.layer.mode != Mode::triangles;
  for (std::size_t r = 0; r < work.rays.count; ++r)
    if (shown.of[r] == index) work.rays.set(r, behind(work.rays[r], work.hits[r], is_field));
}

constexpr double not_asked = -1;  // t_max of a ray that is not traced

/// Writes the rays of a group that go on, each in its own lane, because neighbours in the picture
/// share cells. Rays through which no light would be visible get no next hit.
/// @param place  first ray of the group among the worker's few rays
/// @return       number of rays that go on
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

/// Finds the next hits of these rays, where light from there would be visible.
void go_on(const Frame& frame, std::uint8_t index, const LayerOfRays& shown, Worker& worker) {
  const FrameLayer& layer = frame.layers[index];
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
  layer.continuation->first_hit(layer.dataset, layer.continuation_query, worker.few_rays, worker.few_hits,
                                work.scratch);
  // Called during shading, but tracing does not count as shading.
  worker.counts.shading_ticks -= ticks_now() - start;
  const bool may_be_behind_cut = layer.clipped && frame.clip->cuts_away();
  if (may_be_behind_cut) worker.world->cut.clear();
  for (std::size_t g = 0; g < worker.few.size(); ++g)
    for (std::size_t i = 0; i < RayBatch::group_size; ++i) {
      const std::size_t at = g * RayBatch::group_size + i;
      if (!(worker.few_rays.t_max[at] >= 0)) continue;
      const std::uint32_t r = worker.few[g] + static_cast<std::uint32_t>(i);
      work.hits.set(r, worker.few_hits[at]);
      if (may_be_behind_cut && work.hits.t[r] == infinity && work.rays.t_min[r] < worker.world->kept.again[r])
        worker.world->cut.push_back(r);
    }
  if (may_be_behind_cut)
    trace_after_clip_gap(layer, layer.continuation->first_hit, layer.continuation_query, worker.nearest.data(), worker,
                         work);
}

/// A ray meets a slice only once.
void leave_slices(std::uint8_t index, const LayerOfRays& shown, LayerWork& work) {
  for (std::size_t r = 0; r < work.rays.count; ++r)
    if (shown.of[r] == index) work.hits.t[r] = infinity;
}

/// Gives the rays of transparent layers start sides, unknown at first, until
/// end_rays_from_crossings.
void begin_rays_from_crossings(const Frame& frame, Worker& worker) {
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    if (frame.layers[l].blend != Blend::transparent) continue;
    RayBatch& rays = worker.layers[l].rays;
    rays.has_start_sides = true;
    std::fill_n(rays.start_side.data(), rays.count, StartSide::unknown);
  }
}

void end_rays_from_crossings(const Frame& frame, Worker& worker) {
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    if (frame.layers[l].blend != Blend::transparent) continue;
    RayBatch& rays = worker.layers[l].rays;
    rays.has_start_sides = false;
    std::fill_n(rays.t_min.data(), rays.count, 0.0);
  }
}

/// Shows the nearest of the layers' hits and continues behind it until no hits are left.
void peel(const Frame& frame, Worker& worker) {
  const std::size_t ray_count = worker.layers[0].rays.count;
  LayerOfRays next;
  while (find_next(frame, worker, ray_count, next))
    for (std::size_t l = 0; l < frame.layers.size(); ++l) {
      if (frame.layers[l].blend != Blend::transparent) continue;
      const auto index = static_cast<std::uint8_t>(l);
      receive_light(frame, index, &next, worker);
      if (!frame.layers[l].slice) leave_crossings(frame.layers[l], index, next, worker.layers[l]);
      worker.counts.clear_crossings += static_cast<std::uint64_t>(std::count(next.of, next.of + ray_count, index));
      shade_clear(frame.layers[l].shading, worker.layers[l], next, index, worker.received, worker.counts, worker.front);
      if (frame.layers[l].slice)
        leave_slices(index, next, worker.layers[l]);
      else
        go_on(frame, index, next, worker);
    }
}

}  // namespace

void peel_clear_layers(const Frame& frame, Worker& worker) {
  begin_rays_from_crossings(frame, worker);
  peel(frame, worker);
  end_rays_from_crossings(frame, worker);
}

void peel_further(const Frame& frame, const std::uint8_t* goes_on, std::span<const LastCrossing> last, Worker& worker) {
  begin_rays_from_crossings(frame, worker);
  LayerOfRays going;
  for (const LastCrossing& crossing : last) worker.layers[crossing.layer].rays.set(crossing.ray, crossing.behind);
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    if (frame.layers[l].blend != Blend::transparent) continue;
    LayerWork& work = worker.layers[l];
    const auto index = static_cast<std::uint8_t>(l);
    for (std::size_t r = 0; r < work.rays.count; ++r) going.of[r] = goes_on[r] != 0 ? index : LayerOfRays::none;
    std::fill_n(work.hits.t.data(), work.rays.count, infinity);
    go_on(frame, index, going, worker);
  }
  peel(frame, worker);
  end_rays_from_crossings(frame, worker);
}

}  // namespace rhoray::render

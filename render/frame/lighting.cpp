#include "render/frame/lighting.h"

#include <algorithm>
#include <limits>

#include "render/march/ticks.h"

namespace rhoray::render {

namespace {

/// The side of its surface from which a ray has met it; unknown where the field has no gradient.
StartSide side_of_eye(const Ray& ray, const Hit& hit) {
  if (ray.start_side != StartSide::unknown) return ray.start_side;
  const double along = hit.gradient.dot(ray.direction);
  if (along > 0) return StartSide::outside;
  return along < 0 ? StartSide::inside : StartSide::unknown;
}

/// The unit normal towards that side, world axes. A hit without a gradient faces the eye.
Vec3 normal_towards(StartSide side, const Ray& ray, const Hit& hit, const FrameLayer& layer) {
  const Vec3 normal = layer.look.facing.normal(hit.gradient, ray.direction);
  if (normal == Vec3(0, 0, 0)) return -layer.look.lights.world_from_volume.vector(ray.direction).normalized();
  const bool is_turned =
      side != StartSide::unknown && (hit.gradient.dot(ray.direction) > 0) != (side == StartSide::outside);
  return is_turned ? -normal : normal;
}

void find_lit_hits(const FrameLayer& layer, std::uint8_t index, const LayerOfRays* shown, Worker& worker) {
  const LayerWork& work = worker.layers[index];
  worker.lit_hits.clear();
  for (std::uint32_t r = 0; r < work.rays.count; ++r) {
    const bool is_shown =
        shown != nullptr ? shown->of[r] == index : work.hits.t[r] < std::numeric_limits<double>::infinity();
    if (!is_shown) continue;
    const Ray ray = work.rays[r];
    const Hit hit = work.hits[r];
    const StartSide side = side_of_eye(ray, hit);
    worker.lit_hits.push_back({.ray = r, .t = hit.t, .side = side, .normal = normal_towards(side, ray, hit, layer)});
  }
}

/// On which side of a layer's surface a hit of another one lies. What is known of its own surface is known of every one
/// of the same field: at the hit the field has the hit's isovalue.
StartSide side_for(const FrameLayer& layer, const FrameLayer& of_hit, StartSide side) {
  if (&layer.volume != &of_hit.volume) return StartSide::unknown;
  const double isovalue = layer.question.isovalue, of_field = of_hit.question.isovalue;
  if (isovalue == of_field) return side;
  return of_field > isovalue ? StartSide::inside : StartSide::outside;
}

/// Leaves of Worker::light_rays those that no surface holds back.
void drop_blocked(const Frame& frame, const FrameLayer& of_hits, Worker& worker) {
  std::vector<LightRay>& asked = worker.light_rays;
  for (std::size_t l = 0; l < frame.layers.size() && !asked.empty(); ++l) {
    const FrameLayer& layer = frame.layers[l];
    if (!holds_light_back(layer.look.layer)) continue;
    LayerWork& work = worker.layers[l];
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const LightRay& ray = asked[i];
      worker.few_rays.set(i, {.origin = work.rays[ray.from.ray].at(ray.from.t),
                              .direction = layer.volume_from_world.vector(ray.direction),
                              .t_max = ray.t_max,
                              .start_side = side_for(layer, of_hits, ray.from.side)});
    }
    worker.few_rays.count = asked.size();
    layer.kernel_through(layer.volume, layer.question_through, worker.few_rays, worker.few_hits, work.scratch);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < asked.size(); ++i)
      if (!(worker.few_hits.t[i] < std::numeric_limits<double>::infinity())) asked[kept++] = asked[i];
    asked.resize(kept);
  }
}

void receive_from(const Frame& frame, std::uint8_t index, std::size_t light_index, Worker& worker) {
  const FrameLayer& layer = frame.layers[index];
  const LayerLights& lights = layer.look.lights;
  const LayerLights::One& light = lights.lights[light_index];
  float* shares = worker.received.of_lights[light_index].data();
  worker.light_rays.clear();
  for (const LitHit& hit : worker.lit_hits) {
    shares[hit.ray] = 0;
    const WayToLight way = way_to_light(light, lights.world_from_volume, worker.layers[index].rays[hit.ray].at(hit.t));
    if (way.direction.dot(hit.normal) > 0)
      worker.light_rays.push_back({.from = hit, .direction = way.direction, .t_max = way.distance});
  }
  worker.counts.shadow_rays += worker.light_rays.size();
  drop_blocked(frame, layer, worker);
  for (const LightRay& ray : worker.light_rays) shares[ray.from.ray] = 1;
}

void receive_from_surroundings(const Frame& frame, std::uint8_t index, Worker& worker) {
  const Occlusion& occlusion = frame.occlusion;
  float* shares = worker.received.ambient.data();
  for (const LitHit& hit : worker.lit_hits) shares[hit.ray] = 0;
  const float share = 1 / static_cast<float>(occlusion.samples);
  for (int sample = 0; sample < occlusion.samples; ++sample) {
    worker.light_rays.clear();
    for (const LitHit& hit : worker.lit_hits)
      worker.light_rays.push_back(
          {.from = hit, .direction = worker.pixels[hit.ray].about(hit.normal, sample), .t_max = occlusion.radius});
    worker.counts.occlusion_rays += worker.light_rays.size();
    drop_blocked(frame, frame.layers[index], worker);
    for (const LightRay& ray : worker.light_rays) shares[ray.from.ray] += share;
  }
}

}  // namespace

void number_pixels(const PixelLattice& lattice, const Tile& tile, Worker& worker) {
  worker.pixels.clear();
  for_each_run(tile, [&](const Run& run) {
    for (int i = 0; i < run.count; ++i)
      worker.pixels.emplace_back(static_cast<std::uint32_t>(lattice.x_first + (run.x + i) * lattice.spacing),
                                 static_cast<std::uint32_t>(lattice.y_first + run.y * lattice.spacing));
  });
}

void receive_light(const Frame& frame, std::uint8_t layer, const LayerOfRays* shown, Worker& worker) {
  const FrameLayer& of_hits = frame.layers[layer];
  const EffectSet& effects = of_hits.look.effects;
  if (!effects.shadows && !effects.occlusion) return;
  const std::uint64_t start = ticks_now();
  find_lit_hits(of_hits, layer, shown, worker);
  for (std::size_t l = 0; l < of_hits.look.lights.lights.size(); ++l)
    if (effects.shadows && of_hits.look.lights.lights[l].casts_shadows) receive_from(frame, layer, l, worker);
  if (effects.occlusion) receive_from_surroundings(frame, layer, worker);
  // Rays are no shading, within which this is called.
  worker.counts.shading_ticks -= ticks_now() - start;
}

}  // namespace rhoray::render

#include "render/frame/lighting.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "formats/base/error.h"
#include "render/frame/light_rays.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;
constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t whole_groups(std::size_t count) {
  return (count + group_size - 1) / group_size * group_size;
}

void find_shown(const LayerWork& work, std::uint8_t layer, const LayerOfRays* shown, LightRays& light) {
  const std::size_t count = work.rays.count;
  std::uint8_t* is_shown = light.is_shown.data();
  if (shown == nullptr)
    for (std::size_t r = 0; r < count; ++r) is_shown[r] = work.hits.t[r] < infinity;
  else
    for (std::size_t r = 0; r < count; ++r) is_shown[r] = shown->of[r] == layer;
  std::fill(is_shown + count, is_shown + whole_groups(count), std::uint8_t{0});
  find_shown_groups(count, light);
}

/// Calls act(ray of the batch) for the rays of groups that have shown hits.
template <class Act>
void for_each_near_shown(const LightRays& light, std::size_t count, const Act& act) {
  for (const std::size_t first : light.shown)
    for (std::size_t r = first; r < std::min(first + group_size, count); ++r) act(r);
}

/// Finds the side of its surface from which each ray arrived; unknown where the field has no
/// gradient.
/// @param is_field  sides alternate along a ray; triangles may face any way
void find_sides(Machine machine, const LayerWork& work, bool is_field, LightRays& light) {
  find_sides_by_gradient(machine, work, light);
  if (!work.rays.has_start_sides || !is_field) return;
  for_each_near_shown(light, work.rays.count, [&](std::size_t r) {
    if (work.rays.start_side[r] != StartSide::unknown) light.side[r] = work.rays.start_side[r];
  });
}

/// Unit vector from a ray's hit towards the eye, world axes.
Vec3 to_eye(const LayerLights& lights, const Ray& ray) {
  return -lights.world_from_data.vector(ray.direction).normalized();
}

/// The unit normal on the side that the eye sees. A hit without a gradient faces the eye.
Vec3 eye_normal(const LayerShading& shading, const Ray& ray, const Vec3& gradient, StartSide side) {
  const Vec3 normal = shading.facing.normal(gradient, ray.direction);
  if (side == StartSide::unknown || normal == Vec3(0, 0, 0)) return to_eye(shading.lights, ray);
  return (gradient.dot(ray.direction) > 0) == (side == StartSide::outside) ? normal : -normal;
}

/// Side of a layer's surface on which a hit of another layer lies. At the hit the field has the
/// hit's isovalue, so the side is known for all surfaces of the same field.
StartSide side_for(const FrameLayer& layer, const FrameLayer& of_hit, StartSide side) {
  if (&layer.dataset != &of_hit.dataset || of_hit.slice) return StartSide::unknown;
  const double isovalue = layer.query.isovalue, of_field = of_hit.query.isovalue;
  if (isovalue == of_field) return side;
  return of_field > isovalue ? StartSide::inside : StartSide::outside;
}

/// The same for rays that start outside, unknown, inside.
std::array<StartSide, 3> sides_for(const FrameLayer& layer, const FrameLayer& of_hit) {
  return {side_for(layer, of_hit, StartSide::outside), side_for(layer, of_hit, StartSide::unknown),
          side_for(layer, of_hit, StartSide::inside)};
}

/// Finds the interval of t in which the rays of a group are inside the clip region's half spaces.
void find_spans(const ClipRegion& clip, const LightRays& light, std::size_t first, const LayerWork& hit_work,
                WorldRays& world) {
  RayBatch& rays = world.light_rays;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < group_size; ++i) {
      const double t = light.t_max[first + i] >= 0 ? hit_work.hits.t[first + i] : 0;
      rays.origin[axis][i] = world.rays.origin[axis][first + i] + t * world.rays.direction[axis][first + i];
      rays.direction[axis][i] = light.direction[axis][first + i];
    }
  rays.count = group_size;
  clip.find_spans(rays, world.span_from.data(), world.span_to.data());
}

/// Ends a group of rays where one of the parts kept by the clip region ends.
/// @param part      0, or 1 for the part behind the gap
/// @param of_kept   their hits lie in the kept part, whatever rounding says
/// @param place     first ray of the group in the batch
void shorten_group(const ClipRegion& clip, int part, bool of_kept, const WorldRays& world, RayBatch& rays,
                   std::size_t place) {
  for (std::size_t i = 0; i < group_size; ++i) {
    const double from = world.span_from[i], to = world.span_to[i];
    const bool is_met = from <= to && to >= 0, starts_in = from <= 0;
    double &t_min = rays.t_min[place + i], &t_max = rays.t_max[place + i];
    double begin = 0;
    if (!clip.cuts_away()) {
      begin = starts_in || of_kept ? 0 : from;
      t_max = is_met || of_kept ? std::min(t_max, to) : not_asked;
    } else if (part == 0) {
      const bool stays = !is_met || (starts_in && of_kept);
      t_max = stays ? t_max : starts_in ? not_asked : std::min(t_max, from);
    } else {
      begin = to;
      t_max = is_met && !(starts_in && of_kept) && to <= t_max ? t_max : not_asked;
    }
    if (!(t_max >= 0)) continue;
    t_min = begin;
    if (begin > 0) rays.start_side[place + i] = StartSide::unknown;
  }
}

void end_rays(std::uint64_t rays, double* t_max) {
  for (; rays != 0; rays &= rays - 1) t_max[std::countr_zero(rays)] = not_asked;
}

/// Traces the groups in the worker's few rays, and ends the rays that are occluded.
void drop_blocked_groups(const FrameLayer& layer, const wide::Occluders* occluders, LayerWork& work, Worker& worker) {
  LightRays& light = *worker.light_rays;
  if (light.groups.empty()) return;
  worker.few_rays.count = light.groups.size() * group_size;
  if (layer.continuation->any_hit != nullptr) {
    std::uint64_t crossed[tile_capacity / group_size];
    layer.continuation->any_hit(layer.dataset, layer.continuation_query, occluders, worker.few_rays, crossed,
                                work.scratch);
    for (std::size_t g = 0; g < light.groups.size(); ++g) end_rays(crossed[g], light.t_max.data() + light.groups[g]);
    return;
  }
  layer.continuation->first_hit(layer.dataset, layer.continuation_query, worker.few_rays, worker.few_hits,
                                work.scratch);
  for (std::size_t g = 0; g < light.groups.size(); ++g) {
    const double* t = worker.few_hits.t.data() + g * group_size;
    double* t_max = light.t_max.data() + light.groups[g];
    for (std::size_t i = 0; i < group_size; ++i) t_max[i] = t[i] < infinity ? not_asked : t_max[i];
  }
}

/// Null if a stop request ended the search for them. Then the rest of the tile is tested against
/// the whole surface.
const wide::Occluders* find_occluders(const wide::LightOccluders& of_light, StartSide side,
                                      const std::stop_token& stop) {
  try {
    return &of_light.of(side, stop);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::interrupted) throw;
    return nullptr;
  }
}

constexpr std::size_t no_light = ~std::size_t{0};

/// Ends the rays that a layer's surface occludes (LightRays::t_max).
/// @param part         as for shorten_group
/// @param light_index  the light that the rays go to; no_light: rays in all directions
/// @return             false if no ray was left to trace
bool drop_blocked_by(const Frame& frame, std::size_t index, int part, const FrameLayer& of_hits,
                     const LayerWork& hit_work, std::size_t light_index, Worker& worker) {
  LightRays& light = *worker.light_rays;
  const FrameLayer& layer = frame.layers[index];
  LayerWork& work = worker.layers[index];
  RaysBySide asked[tile_capacity / group_size];
  const Machine machine = layer.shading.machine;
  find_asked(machine, light, asked);
  const std::array<StartSide, 3> sides = sides_for(layer, of_hits);
  bool any = false;
  // Rays that start on a known side are tested against the occluders of that side, the others
  // against everything.
  const wide::LightOccluders* of_light =
      light_index < layer.occluders.size() ? layer.occluders[light_index].get() : nullptr;
  for (const StartSide side : {StartSide::unknown, StartSide::outside, StartSide::inside}) {
    if (side != StartSide::unknown && of_light == nullptr) break;
    const wide::Occluders* occluders = nullptr;
    light.groups.clear();
    for (std::size_t g = 0; g < light.shown.size(); ++g) {
      std::uint64_t chosen = 0;
      for (std::size_t i = 0; i < sides.size(); ++i)
        if (of_light == nullptr || sides[i] == side) chosen |= asked[g][i];
      if (chosen == 0) continue;
      any = true;
      if (of_light != nullptr && side != StartSide::unknown && occluders == nullptr)
        occluders = find_occluders(*of_light, side, frame.stop);
      const std::size_t first = light.shown[g], place = light.groups.size() * group_size;
      write_light_rays(machine, light, {first, chosen, place, sides}, layer.data_from_world, hit_work.hits, work.rays,
                       worker.few_rays);
      if (occluders != nullptr && occluders->heights) {
        const auto [below, in_shadow] = occluders->heights->know(machine, worker.few_rays, place, chosen);
        end_rays(in_shadow, light.t_max.data() + first);
        if (below == 0) continue;
        chosen = below;
        for (std::size_t i = 0; i < group_size; ++i)
          if ((chosen >> i & 1) == 0) worker.few_rays.t_max[place + i] = not_asked;
      }
      if (layer.clipped) {
        find_spans(*frame.clip, light, first, hit_work, *worker.world);
        shorten_group(*frame.clip, part, of_hits.clipped, *worker.world, worker.few_rays, place);
      }
      light.groups.push_back(first);
    }
    drop_blocked_groups(layer, occluders, work, worker);
  }
  return any;
}

/// Ends the rays that any surface occludes.
/// @param light_index  as for drop_blocked_by
void drop_blocked(const Frame& frame, const FrameLayer& of_hits, const LayerWork& hit_work, std::size_t light_index,
                  Worker& worker) {
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    const FrameLayer& layer = frame.layers[l];
    if (!holds_light_back(layer.shading.layer)) continue;
    const int parts = layer.clipped && frame.clip->cuts_away() ? 2 : 1;
    for (int part = 0; part < parts; ++part)
      if (!drop_blocked_by(frame, l, part, of_hits, hit_work, light_index, worker)) return;
  }
}

/// Aims the rays of all hits at a light.
void aim_at(const LayerLights::One& light, const LayerShading& shading, const LayerWork& work, LightRays& rays) {
  if (light.kind == Light::Kind::directional) return aim_all(light.place, rays);
  for_each_near_shown(rays, work.rays.count, [&](std::size_t r) {
    const WayToLight way = way_to_light(light, shading.lights.world_from_data, work.rays[r].at(work.hits.t[r]));
    for (int axis = 0; axis < 3; ++axis) rays.direction[axis][r] = way.direction[axis];
    rays.t_max[r] = way.distance;
  });
}

void keep_those_before_surfaces(const LayerShading& shading, const Affine& data_from_world, const LayerWork& work,
                                LightRays& light) {
  if (!ask_before_surfaces(shading.machine, data_from_world, work, light)) return;
  // Without a gradient a hit faces the eye.
  for_each_near_shown(light, work.rays.count, [&](std::size_t r) {
    const Vec3 direction(light.direction[0][r], light.direction[1][r], light.direction[2][r]);
    if (light.side[r] == StartSide::unknown && !(to_eye(shading.lights, work.rays[r]).dot(direction) > 0))
      light.t_max[r] = not_asked;
  });
}

/// Aims the rays of the lit hits at a point of an area light. For a light with a position, a ray
/// ends where it is nearest to the light's centre.
void aim_at_point_of(const LayerLights::One& light, const LayerShading& shading, const LayerWork& work,
                     const std::vector<SpreadDirections>& pixels, int sample, LightRays& rays) {
  for (std::size_t r = 0; r < work.rays.count; ++r) {
    rays.t_max[r] = not_asked;
    if (rays.is_lit[r] == 0) continue;
    const WayToLight way = way_to_light(light, shading.lights.world_from_data, work.rays[r].at(work.hits.t[r]));
    const double cap_height = cap_height_of(light, way.distance);
    const Vec3 direction = pixels[r].within(way.direction, cap_height, sample);
    for (int axis = 0; axis < 3; ++axis) rays.direction[axis][r] = direction[axis];
    rays.t_max[r] = way.distance < infinity ? way.distance * direction.dot(way.direction) : infinity;
  }
}

/// Computes the share of a light's points that each hit sees, among those in front of its surface.
void receive_from_points(const Frame& frame, const FrameLayer& layer, const LayerWork& work, std::size_t light_index,
                         Worker& worker) {
  const LayerLights::One& of_light = layer.shading.lights.lights[light_index];
  float* shares = worker.received.of_lights[light_index].data();
  LightRays& light = *worker.light_rays;
  const std::size_t count = work.rays.count;
  std::fill_n(light.is_lit.data(), count, std::uint8_t{0});
  for_each_near_shown(light, count, [&](std::size_t r) { light.is_lit[r] = light.t_max[r] >= 0; });
  std::fill_n(light.asked.data(), count, 0.0F), std::fill_n(light.free.data(), count, 0.0F);
  for (int sample = 0; sample < of_light.rays; ++sample) {
    std::fill_n(light.t_max.data(), whole_groups(count), not_asked);
    aim_at_point_of(of_light, layer.shading, work, worker.pixels, sample, light);
    keep_those_before_surfaces(layer.shading, layer.data_from_world, work, light);
    worker.counts.shadow_rays += asked_count(layer.shading.machine, light);
    for (std::size_t r = 0; r < count; ++r) light.asked[r] += light.t_max[r] >= 0 ? 1.0F : 0.0F;
    drop_blocked(frame, layer, work, light_index, worker);
    for (std::size_t r = 0; r < count; ++r) light.free[r] += light.t_max[r] >= 0 ? 1.0F : 0.0F;
  }
  for (std::size_t r = 0; r < count; ++r)
    shares[r] = light.asked[r] > 0 ? light.free[r] / light.asked[r] : static_cast<float>(light.is_lit[r]);
}

void receive_from(const Frame& frame, std::uint8_t index, std::size_t light_index, Worker& worker) {
  const FrameLayer& layer = frame.layers[index];
  const LayerWork& work = worker.layers[index];
  const LayerLights::One& of_light = layer.shading.lights.lights[light_index];
  LightRays& light = *worker.light_rays;
  aim_at(of_light, layer.shading, work, light);
  keep_those_before_surfaces(layer.shading, layer.data_from_world, work, light);
  if (of_light.extent > 0) return receive_from_points(frame, layer, work, light_index, worker);
  worker.counts.shadow_rays += asked_count(layer.shading.machine, light);
  drop_blocked(frame, layer, work, light_index, worker);
  share_of_asked(layer.shading.machine, light, worker.received.of_lights[light_index].data());
}

void receive_from_surroundings(const Frame& frame, std::uint8_t index, Worker& worker) {
  const FrameLayer& layer = frame.layers[index];
  const LayerWork& work = worker.layers[index];
  LightRays& light = *worker.light_rays;
  float* shares = worker.received.ambient.data();
  const std::size_t count = work.rays.count;
  for (std::size_t r = 0; r < count; ++r)
    if (light.is_shown[r] != 0)
      worker.eye_normals[r] = eye_normal(layer.shading, work.rays[r], work.hits[r].gradient, light.side[r]);
  std::fill_n(shares, count, 0.0F);
  const float share = 1 / static_cast<float>(frame.occlusion.samples);
  for (int sample = 0; sample < frame.occlusion.samples; ++sample) {
    std::fill_n(light.t_max.data(), whole_groups(count), not_asked);
    for (std::size_t r = 0; r < count; ++r) {
      if (light.is_shown[r] == 0) continue;
      const Vec3 direction = worker.pixels[r].about(worker.eye_normals[r], sample);
      for (int axis = 0; axis < 3; ++axis) light.direction[axis][r] = direction[axis];
      light.t_max[r] = frame.occlusion.radius;
    }
    worker.counts.occlusion_rays += asked_count(layer.shading.machine, light);
    drop_blocked(frame, layer, work, no_light, worker);
    for (std::size_t r = 0; r < count; ++r) shares[r] += light.t_max[r] >= 0 ? share : 0;
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

bool asks_for_light(const FrameLayer& layer) {
  return layer.shading.effects.shadows || layer.shading.effects.occlusion;
}

void receive_light(const Frame& frame, std::uint8_t layer, const LayerOfRays* shown, Worker& worker) {
  const FrameLayer& of_hits = frame.layers[layer];
  const EffectSet& effects = of_hits.shading.effects;
  if (!asks_for_light(of_hits)) return;
  const std::uint64_t start = ticks_now();
  find_shown(worker.layers[layer], layer, shown, *worker.light_rays);
  find_sides(of_hits.shading.machine, worker.layers[layer], of_hits.shading.layer.mode != Mode::triangles,
             *worker.light_rays);
  for (std::size_t l = 0; l < of_hits.shading.lights.lights.size(); ++l)
    if (effects.shadows && of_hits.shading.lights.lights[l].casts_shadows) receive_from(frame, layer, l, worker);
  if (effects.occlusion) receive_from_surroundings(frame, layer, worker);
  // This is called during shading, but tracing does not count as shading.
  worker.counts.shading_ticks -= ticks_now() - start;
}

}  // namespace rhoray::render

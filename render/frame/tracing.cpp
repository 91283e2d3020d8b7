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

/// Makes the tile's rays in world axes, and finds what the clip region leaves of them.
void clip_rays(const Frame& frame, const PixelRays& rays, const Tile& tile, Worker& worker) {
  WorldRays& world = *worker.world;
  if (world.begun_by != &rays) rays.begin(world.rays);
  world.begun_by = &rays;
  rays.fill(tile, world.rays);
  if (!frame.clip) return;
  frame.clip->find_kept(world.rays, world.kept);
  const double *t_min = world.kept.t_min.data(), *t_max = world.kept.t_max.data(), *again = world.kept.again.data();
  std::uint64_t clipped = 0, clipped_away = 0;
  for (std::size_t r = 0; r < world.rays.count; ++r) {
    clipped += t_min[r] > 0 || t_max[r] < infinity;
    clipped_away += t_max[r] < t_min[r] && again[r] == infinity;
  }
  worker.counts.rays_clipped += clipped;
  worker.counts.rays_clipped_away += clipped_away;
}

/// Ends a layer's rays where the first part that the clip region leaves of them ends, and at `ends` where given.
void shorten(const KeptParts& kept, const double* ends, RayBatch& rays) {
  const double* kept_end = kept.t_max.data();
  double* t_max = rays.t_max.data();
  std::copy_n(kept.t_min.data(), rays.count, rays.t_min.data());
  if (ends == nullptr)
    std::copy_n(kept_end, rays.count, t_max);
  else
    for (std::size_t r = 0; r < rays.count; ++r) t_max[r] = kept_end[r] < ends[r] ? kept_end[r] : ends[r];
}

/// Of two parts of a ray: the first surface, or the largest value, of equal ones the first.
Hit joined(const Hit& before, const Hit& behind, bool is_projection) {
  Hit hit = !before.is_miss() && (!is_projection || behind.is_miss() || before.value >= behind.value) ? before : behind;
  if (is_projection && !before.is_miss() && !behind.is_miss()) hit.error = std::max(before.error, behind.error);
  hit.cost = before.cost + behind.cost;
  return hit;
}

/// Asks about the parts of rays behind what the clip region cuts away, WorldRays::cut.
/// @param ends  of all rays of the tile; null: they do not end
void ask_behind_cut(const FrameLayer& layer, Kernel kernel, const Question& question, const double* ends,
                    Worker& worker, LayerWork& work) {
  const bool is_projection = layer.look.layer.mode == Mode::mip;
  const WorldRays& world = *worker.world;
  worker.few.clear();
  for (const std::uint32_t r : world.cut) {
    Ray rest = work.rays[r];
    rest.t_min = world.kept.again[r];
    rest.t_max = ends != nullptr ? ends[r] : infinity;
    rest.start_side = StartSide::unknown;
    if (!(rest.t_min <= rest.t_max) || rest.t_min == infinity) continue;
    if (!is_projection) work.rays.set(r, rest);
    worker.few_rays.set(worker.few.size(), rest);
    worker.few.push_back(r);
  }
  if (worker.few.empty()) return;
  worker.few_rays.count = worker.few.size();
  kernel(layer.volume, question, worker.few_rays, worker.few_hits, work.scratch);
  for (std::size_t i = 0; i < worker.few.size(); ++i) {
    const std::size_t r = worker.few[i];
    work.hits.set(r, joined(work.hits[r], worker.few_hits[i], is_projection));
  }
}

/// @param ends  of all rays of the tile; null: they do not end
void ask_slice(const Frame& frame, const FrameLayer& layer, const double* ends, Worker& worker, LayerWork& work) {
  const WorldRays& world = *worker.world;
  const bool is_cut = layer.clipped && frame.clip->cuts_away();
  worker.counts.slice_places += layer.slice->ask(
      work.rays, world.rays, {.begin = is_cut ? world.kept.again.data() : nullptr, .end = ends}, work.hits);
  for (std::size_t r = 0; r < work.rays.count; ++r) work.scratch.counters.cells_visited += work.hits.cost[r];
}

/// @param ends  of all rays of the tile; null: they do not end
void ask_layer(const Frame& frame, const FrameLayer& layer, const PixelRays& rays, const Tile& tile, const double* ends,
               Worker& worker, LayerWork& work) {
  if (work.rays_begun_by != &rays) rays.begin(work.rays);
  work.rays_begun_by = &rays;
  rays.fill(tile, work.rays);
  if (layer.clipped)
    shorten(worker.world->kept, ends, work.rays);
  else if (ends != nullptr)
    std::copy_n(ends, work.rays.count, work.rays.t_max.data());
  if (layer.slice) return ask_slice(frame, layer, ends, worker, work);
  work.scratch.last_t.reset();
  layer.kernel(layer.volume, layer.question, work.rays, work.hits, work.scratch);
  if (!layer.clipped || !frame.clip->cuts_away()) return;
  worker.world->cut.clear();
  for (std::uint32_t r = 0; r < work.rays.count; ++r)
    if (work.hits.t[r] == infinity || layer.look.layer.mode == Mode::mip) worker.world->cut.push_back(r);
  work.scratch.last_t.reset();
  ask_behind_cut(layer, layer.kernel, layer.question, ends, worker, work);
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
  layer.kernel_through(layer.volume, layer.question_through, worker.few_rays, worker.few_hits, work.scratch);
  worker.counts.shading_ticks -= ticks_now() - start;  // rays are no shading, within which this is called
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
    ask_behind_cut(layer, layer.kernel_through, layer.question_through, worker.nearest.data(), worker, work);
}

/// Where the nearest is a slice, what is not opaque is only seen before it.
void end_before_slices(const Frame& frame, Worker& worker) {
  for (std::size_t r = 0; r < worker.layers[0].rays.count; ++r) {
    const std::uint8_t shown = worker.shown.of[r];
    if (shown != LayerOfRays::none && frame.layers[shown].slice && worker.layers[shown].hits.t[r] == worker.nearest[r])
      worker.nearest[r] = std::nextafter(worker.nearest[r], -infinity);
  }
}

/// A slice is met once.
void leave_slices(std::uint8_t index, const LayerOfRays& shown, LayerWork& work) {
  for (std::size_t r = 0; r < work.rays.count; ++r)
    if (shown.of[r] == index) work.hits.t[r] = infinity;
}

}  // namespace

void trace_layers(const Frame& frame, const LatticeRays& rays, const Tile& tile, Worker& worker) {
  if (rays.in_world) clip_rays(frame, *rays.in_world, tile, worker);
  if (frame.has_one_layer()) {
    ask_layer(frame, frame.layers[0], rays.of_layers[0], tile, nullptr, worker, worker.layers[0]);
    return;
  }
  std::fill_n(worker.nearest.data(), tile_capacity, infinity);
  std::fill_n(worker.shown.of, tile_capacity, LayerOfRays::none);
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    LayerWork& work = worker.layers[l];
    if (frame.layers[0].slice && l > 0 && frame.layers[l].part != frame.layers[l - 1].part)
      end_before_slices(frame, worker);
    ask_layer(frame, frame.layers[l], rays.of_layers[l], tile, worker.nearest.data(), worker, work);
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
      if (!frame.layers[l].slice) leave_crossings(frame.layers[l], index, next, worker.layers[l]);
      shade_clear(frame.layers[l].look, worker.layers[l], next, index, worker.received, worker.counts, worker.front);
      if (frame.layers[l].slice)
        leave_slices(index, next, worker.layers[l]);
      else
        go_on(frame, index, next, worker);
    }
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    if (frame.layers[l].part != Part::clear) continue;
    RayBatch& rays = worker.layers[l].rays;
    rays.has_start_sides = false;
    std::fill_n(rays.t_min.data(), ray_count, 0.0);
  }
}

}  // namespace rhoray::render

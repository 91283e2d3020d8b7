#include "render/frame/tracing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "render/frame/all_hits.h"
#include "render/frame/clip_gap.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Makes the tile's rays in world axes, and finds the parts that the clip region keeps.
void clip_rays(const Frame& frame, const PixelRays& rays, const Tile& tile, Worker& worker) {
  WorldRays& world = *worker.world;
  if (!std::exchange(world.are_begun, true)) rays.begin(world.rays);
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

/// Ends a layer's rays where the first part kept by the clip region ends, and at `ends` if given.
void shorten(const KeptParts& kept, const double* ends, RayBatch& rays) {
  const double* kept_end = kept.t_max.data();
  double* t_max = rays.t_max.data();
  std::copy_n(kept.t_min.data(), rays.count, rays.t_min.data());
  if (ends == nullptr)
    std::copy_n(kept_end, rays.count, t_max);
  else
    for (std::size_t r = 0; r < rays.count; ++r) t_max[r] = kept_end[r] < ends[r] ? kept_end[r] : ends[r];
}

/// @param ends  end of each ray of the tile; null: the rays do not end
void ask_slice(const Frame& frame, const FrameLayer& layer, const double* ends, Worker& worker, LayerWork& work) {
  const WorldRays& world = *worker.world;
  const bool is_cut = layer.clipped && frame.clip->cuts_away();
  worker.counts.slice_places += layer.slice->ask(
      work.rays, world.rays, {.begin = is_cut ? world.kept.again.data() : nullptr, .end = ends}, work.hits);
  for (std::size_t r = 0; r < work.rays.count; ++r) work.scratch.counters.cells_visited += work.hits.cost[r];
}

/// Makes the tile's rays in the frame of a layer's dataset.
/// @param ends  end of each ray of the tile; null: the rays do not end
void make_rays(const FrameLayer& layer, const PixelRays& rays, const Tile& tile, const double* ends,
               const Worker& worker, LayerWork& work) {
  if (!std::exchange(work.rays_are_begun, true)) rays.begin(work.rays);
  rays.fill(tile, work.rays);
  if (layer.clipped)
    shorten(worker.world->kept, ends, work.rays);
  else if (ends != nullptr)
    std::copy_n(ends, work.rays.count, work.rays.t_max.data());
}

/// @param ends  end of each ray of the tile; null: the rays do not end
void ask_layer(const Frame& frame, const FrameLayer& layer, const PixelRays& rays, const Tile& tile, const double* ends,
               Worker& worker, LayerWork& work) {
  make_rays(layer, rays, tile, ends, worker, work);
  if (layer.slice) return ask_slice(frame, layer, ends, worker, work);
  work.scratch.last_t.reset();
  layer.kernel(layer.dataset, layer.query, work.rays, work.hits, work.scratch);
  if (!layer.clipped || !frame.clip->cuts_away()) return;
  worker.world->cut.clear();
  for (std::uint32_t r = 0; r < work.rays.count; ++r)
    if (work.hits.t[r] == infinity || layer.shading.layer.mode == Mode::mip) worker.world->cut.push_back(r);
  work.scratch.last_t.reset();
  trace_after_clip_gap(layer, layer.kernel, layer.query, ends, worker, work);
}

/// Keeps the nearest surface; at equal t, the one whose layer comes first.
void keep_nearest(const LayerWork& work, std::uint8_t layer, Worker& worker) {
  const double* t = work.hits.t.data();
  double* nearest = worker.nearest.data();
  for (std::size_t r = 0; r < work.rays.count; ++r) {
    const bool is_nearer = t[r] < nearest[r];
    nearest[r] = is_nearer ? t[r] : nearest[r];
    worker.shown.of[r] = is_nearer ? layer : worker.shown.of[r];
  }
}

/// Where the nearest surface is a slice, transparent and additive layers are visible only in front
/// of it.
void end_before_slices(const Frame& frame, Worker& worker) {
  for (std::size_t r = 0; r < worker.layers[0].rays.count; ++r) {
    const std::uint8_t shown = worker.shown.of[r];
    if (shown != LayerOfRays::none && frame.layers[shown].slice && worker.layers[shown].hits.t[r] == worker.nearest[r])
      worker.nearest[r] = std::nextafter(worker.nearest[r], -infinity);
  }
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
    if (frame.layers[0].slice && l > 0 && frame.layers[l].blend != frame.layers[l - 1].blend)
      end_before_slices(frame, worker);
    if (frame.layers[l].blend == Blend::transparent && !frame.all_hits_groups.empty()) {
      make_rays(frame.layers[l], rays.of_layers[l], tile, worker.nearest.data(), worker, work);
      continue;
    }
    ask_layer(frame, frame.layers[l], rays.of_layers[l], tile, worker.nearest.data(), worker, work);
    if (frame.layers[l].blend == Blend::opaque) keep_nearest(work, static_cast<std::uint8_t>(l), worker);
  }
  if (!frame.all_hits_groups.empty()) find_all_hits(frame, worker);
}

}  // namespace rhoray::render

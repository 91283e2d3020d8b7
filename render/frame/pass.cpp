#include "render/frame/pass.h"

#include <limits>

#include "render/frame/all_hits.h"
#include "render/frame/block_mask.h"
#include "render/frame/lighting.h"
#include "render/frame/peeling.h"
#include "render/frame/streaming.h"
#include "render/frame/tracing.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Returns nothing if every ray must be traced.
std::optional<BlockMask> mask_of(const Frame& frame, const PixelLattice& lattice) {
  BlockMask mask(lattice);
  for (const FrameLayer& layer : frame.layers) {
    if (!layer.boxes) return std::nullopt;
    const LoadedDataset& dataset = layer.dataset;
    const BoxProjection projection(frame.camera_rays, layer.data_from_world, dataset.world_from_data,
                                   dataset.bounds_data);
    if (!projection.is_certain()) return std::nullopt;
    std::optional<ClipRegion::InFrame> clip;
    if (layer.clipped) clip.emplace(*frame.clip, dataset.world_from_data, *layer.boxes);
    add_blocks_that_may_meet(*layer.boxes, projection, lattice, mask, frame.machine, clip ? &*clip : nullptr);
  }
  return mask;
}

/// At equal t, slices come first.
bool comes_before(const Frame& frame, const Worker& worker, std::size_t ray, std::size_t layer, std::size_t other) {
  const double t = worker.layers[layer].hits.t[ray], other_t = worker.layers[other].hits.t[ray];
  return t < other_t || (t == other_t && t < infinity && frame.layers[layer].slice && !frame.layers[other].slice);
}

/// Stores the hit of each ray's first surface, opaque or transparent, in Worker::first_hits. Where
/// there are no surfaces, it is the hit of the largest value.
void gather_first(const Frame& frame, Worker& worker) {
  for (std::size_t r = 0; r < worker.layers[0].rays.count; ++r) {
    std::size_t first = 0;
    for (std::size_t l = 0; l < frame.layers.size(); ++l)
      if (frame.layers[l].blend != Blend::additive && comes_before(frame, worker, r, l, first)) first = l;
    worker.first.of[r] = static_cast<std::uint8_t>(first);
    worker.first_hits.set(r, worker.layers[first].hits[r]);
  }
}

/// Finds the normals of the first hits: towards the eye, world axes.
void find_normals(const Frame& frame, Worker& worker) {
  const bool has_one_layer = frame.has_one_layer();
  const HitBatch& hits = has_one_layer ? worker.layers[0].hits : worker.first_hits;
  for (std::size_t r = 0; r < worker.layers[0].rays.count; ++r) {
    const std::size_t layer = has_one_layer ? 0 : worker.first.of[r];
    const Hit hit = hits[r];
    worker.normals[r] = frame.layers[layer].shading.facing.normal(hit.gradient, worker.layers[layer].rays[r].direction);
  }
}

/// Writes the first layer of every pixel in a tile's traced blocks to the frame's array.
void write_first_layers(const Frame& frame, const PixelLattice& lattice, const Tile& tile, const Worker& worker) {
  for_each_run(tile, [&](const Run& run) {
    for (int i = 0; i < run.count; ++i) {
      const int x = lattice.x_first + (run.x + i) * lattice.spacing, y = lattice.y_first + run.y * lattice.spacing;
      frame.first_layers[static_cast<std::size_t>(y) * static_cast<std::size_t>(lattice.width) +
                         static_cast<std::size_t>(x)] = worker.first.of[run.first + static_cast<std::size_t>(i)];
    }
  });
}

}  // namespace

void shade_layers(const Frame& frame, Worker& worker) {
  const std::size_t count = worker.layers[0].rays.count;
  fill_background(frame.background, count, worker.colors);
  if (frame.has_one_layer()) {
    receive_light(frame, 0, nullptr, worker);
    shade_hits(frame.layers[0].shading, worker.layers[0], worker.received, worker.counts, worker.colors);
  } else {
    bool has_transparent = false;
    for (std::size_t l = 0; l < frame.layers.size(); ++l) {
      const FrameLayer& layer = frame.layers[l];
      const auto index = static_cast<std::uint8_t>(l);
      if (layer.blend == Blend::opaque) {
        receive_light(frame, index, &worker.shown, worker);
        shade_shown(layer.shading, worker.layers[l], worker.shown, index, worker.received, worker.counts,
                    worker.colors);
      }
      has_transparent |= layer.blend == Blend::transparent;
    }
    if (has_transparent) {
      begin_front(count, worker.front);
      if (frame.all_hits_groups.empty())
        peel_clear_layers(frame, worker);
      else
        composite_all_hits(frame, worker);
      put_in_front(worker.front, count, worker.colors);
    }
    for (std::size_t l = 0; l < frame.layers.size(); ++l)
      if (frame.layers[l].blend == Blend::additive)
        composite_mip(frame.layers[l].shading, worker.layers[l], worker.received, worker.counts, worker.colors);
  }
  for (std::size_t r = 0; r < count; ++r) worker.counts.hits += worker.colors.alpha[r] > 0;
}

namespace {

/// @return  number of rays traced
std::size_t trace_blocks(const Frame& frame, const LatticeRays& rays, const Tile& tile, Worker& worker,
                         Framebuffer& out) {
  trace_layers(frame, rays, tile, worker);
  if (frame.needs.spread_directions) number_pixels(rays.lattice, tile, worker);

  const std::uint64_t shading_start = ticks_now();
  const bool has_one_layer = frame.has_one_layer();
  if (frame.keeps_channels && !has_one_layer) gather_first(frame, worker);
  shade_layers(frame, worker);
  write_colors(rays.lattice, tile, worker.colors, out, frame.machine);
  if (frame.keeps_channels) {
    if (!out.normal.empty()) find_normals(frame, worker);
    if (frame.first_layers != nullptr) write_first_layers(frame, rays.lattice, tile, worker);
    write_channels(rays.lattice, tile, has_one_layer ? worker.layers[0].hits : worker.first_hits, worker.normals.data(),
                   out);
  }
  worker.counts.shading_ticks += ticks_now() - shading_start;
  return worker.layers[0].rays.count;
}

/// Whether pixels of a tile, or the squares that they fill, are in the window.
bool touches(const PixelRect& window, const PixelLattice& lattice, const Tile& tile) {
  const auto overlap = [&](int first, int begin, int end, int from, int count) {
    return first + (end - 1) * lattice.spacing + lattice.extent > from &&
           first + begin * lattice.spacing < from + count;
  };
  return overlap(lattice.x_first, tile.x_begin, tile.x_end, window.x, window.width) &&
         overlap(lattice.y_first, tile.y_begin, tile.y_end, window.y, window.height);
}

}  // namespace

void Pass::add(const Frame& frame, const PixelLattice& lattice) {
  if (lattice.columns() <= 0 || lattice.rows() <= 0) return;
  const std::optional<BlockMask> mask = mask_of(frame, lattice);
  for (Tile tile : tiles_in_order(lattice.columns(), lattice.rows())) {
    if (!touches(frame.window, lattice, tile)) continue;
    if (mask) tile.blocks = mask->of_tile(tile);
    tiles_.push_back({rays_.size(), tile});
  }
  LatticeRays& rays = rays_.emplace_back(LatticeRays{lattice, {}});
  for (const FrameLayer& layer : frame.layers)
    rays.of_layers.emplace_back(frame.camera_rays, layer.data_from_world, lattice, frame.machine);
  if (frame.needs.world_rays) rays.in_world.emplace(frame.camera_rays, Affine(), lattice, frame.machine);
}

void Pass::trace_tile(const Frame& frame, std::size_t index, Worker& worker, Framebuffer& out) const {
  const auto& [rays_index, tile] = tiles_[index];
  const LatticeRays& rays = rays_[rays_index];
  WorkerCounts& counts = worker.counts;
  const std::uint64_t start = ticks_now();
  write_background(frame.background, rays.lattice, tile, out);
  counts.shading_ticks += ticks_now() - start;
  const std::size_t traced = tile.blocks != 0 ? trace_blocks(frame, rays, tile, worker, out) : 0;
  end_streaming();
  counts.rays += tile.count();
  counts.rays_ruled_out += tile.count() - traced;
  counts.tile_ticks += ticks_now() - start;
}

}  // namespace rhoray::render

#pragma once

#include <cstdint>
#include <optional>

#include "render/frame/tiles.h"
#include "render/kernels/kernels.h"

namespace rhoray::render {

/// A tile's pixels as they are to be seen, in the order of its batch.
struct TileColors {
  alignas(64) float red[tile_capacity], green[tile_capacity], blue[tile_capacity], alpha[tile_capacity];
};

/// Memory and counts of one thread; on cache lines of its own.
struct alignas(128) Worker {
  RayBatch rays{tile_capacity};
  HitBatch hits{tile_capacity};
  TileColors colors;
  KernelScratch scratch;
  const void* rays_begun_by = nullptr;  ///< whose numbers the rays have that all rays share
  std::uint64_t ray_count = 0, hit_count = 0, highlights = 0, smooth_normals = 0, field_values = 0;
  std::uint64_t tile_ticks = 0, shading_ticks = 0;
  double largest_error = 0;

  /// Forgets everything but memory. Kernels know by themselves of which volume and isovalue they keep something.
  void begin_frame(std::size_t queue_entries) {
    scratch.queue.reserve(queue_entries);
    scratch.last_t.reset();
    scratch.counters = {};
    rays_begun_by = nullptr;
    ray_count = hit_count = highlights = smooth_normals = field_values = tile_ticks = shading_ticks = 0;
    largest_error = 0;
  }
};

}  // namespace rhoray::render

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/frame/tiles.h"
#include "render/kernels/kernels.h"

namespace rhoray::render {

/// A tile's pixels as they are to be seen, in the order of its batch.
struct TileColors {
  alignas(64) float red[tile_capacity], green[tile_capacity], blue[tile_capacity], alpha[tile_capacity];
};

/// A tile's rays in the frame of one layer's volume, and what they met of that layer.
struct LayerWork {
  RayBatch rays{tile_capacity};
  HitBatch hits{tile_capacity};
  KernelScratch scratch;
  const void* rays_begun_by = nullptr;  ///< whose numbers the rays have that all rays share
};

/// Of each ray a layer, by its place in the frame.
struct LayerOfRays {
  static constexpr std::uint8_t none = 255;
  alignas(64) std::uint8_t of[tile_capacity];
};

/// What a thread has traced and shaded.
struct WorkerCounts {
  std::uint64_t rays = 0, rays_ruled_out = 0, rays_through = 0, hits = 0;
  std::uint64_t highlights = 0, smooth_normals = 0, field_values = 0;
  std::uint64_t tile_ticks = 0, shading_ticks = 0;
  std::uint64_t tracing_ticks = 0;  ///< while shading: of rays that go on
  double largest_error = 0;
};

/// Memory and counts of one thread; on cache lines of its own.
struct alignas(128) Worker {
  std::vector<LayerWork> layers;
  TileColors colors;
  LayerOfRays shown;  ///< the nearest opaque surface; only in frames of several layers
  LayerOfRays first;  ///< the first surface, opaque or not, where channels ask for it
  HitBatch first_hits{tile_capacity};
  std::vector<Vec3> normals = std::vector<Vec3>(tile_capacity);  ///< of the first hits, where channels ask for them
  LaneArray<double> nearest{tile_capacity};                      ///< t of the nearest opaque surface
  TileColors front;                  ///< of clear surfaces: light, and in alpha how much they let through
  RayBatch few_rays{tile_capacity};  ///< of one layer, asked again behind its last crossing
  HitBatch few_hits{tile_capacity};
  std::vector<std::uint32_t> few;  ///< which rays these are
  WorkerCounts counts;

  Worker() { few.reserve(tile_capacity); }

  /// Forgets everything but memory. Kernels know by themselves of which volume and isovalue they keep something.
  void begin_frame(std::size_t layer_count, std::size_t queue_entries) {
    layers.resize(layer_count);
    for (LayerWork& layer : layers) {
      layer.scratch.queue.reserve(queue_entries);
      layer.scratch.last_t.reset();
      layer.scratch.counters = {};
      layer.rays_begun_by = nullptr;
    }
    counts = {};
  }
};

}  // namespace rhoray::render

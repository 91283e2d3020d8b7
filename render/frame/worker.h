#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "render/frame/clip_region.h"
#include "render/frame/tiles.h"
#include "render/query/all_hits.h"
#include "render/query/kernels.h"
#include "render/shade/received.h"
#include "render/shade/spread_directions.h"

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
  bool rays_are_begun = false;  ///< in this frame: they have the numbers that all rays of a layer share
};

/// Of each ray a layer, by its place in the frame.
struct LayerOfRays {
  static constexpr std::uint8_t none = 255;
  alignas(64) std::uint8_t of[tile_capacity];
};

/// Rays from hits towards where light may come from, in the places of the tile's rays that met these.
struct LightRays {
  LaneArray<std::uint8_t> is_shown{tile_capacity};  ///< whether there is a hit that light may reach
  std::vector<std::size_t> shown;                   ///< where groups begin that have any; nothing is said of others
  LaneArray<StartSide> side{tile_capacity};         ///< of its surface: the one that the eye sees
  LaneArray<double> direction[3]{LaneArray<double>(tile_capacity), LaneArray<double>(tile_capacity),
                                 LaneArray<double>(tile_capacity)};  ///< unit length, world axes
  LaneArray<double> t_max{tile_capacity};                            ///< below 0: nothing is asked
  LaneArray<std::uint8_t> is_lit{tile_capacity};                     ///< hits before which a wide light's middle stands
  LaneArray<float> asked{tile_capacity}, free{tile_capacity};        ///< rays to a wide light, and those not held back
  std::vector<std::size_t> groups;                                   ///< of the tile's, that are asked about

  LightRays() {
    shown.reserve(tile_capacity / RayBatch::group_size);
    groups.reserve(tile_capacity / RayBatch::group_size);
  }
};

/// Rays of a tile in world axes, and what a clip region leaves of them.
struct WorldRays {
  RayBatch rays{tile_capacity};
  bool are_begun = false;  ///< as LayerWork::rays_are_begun
  KeptParts kept{tile_capacity};
  std::vector<std::uint32_t> cut;                                      ///< rays that are asked about behind the cut
  LaneArray<double> span_from{tile_capacity}, span_to{tile_capacity};  ///< of rays towards lights, in the region
  RayBatch light_rays{tile_capacity};                                  ///< these rays

  WorldRays() { cut.reserve(tile_capacity); }
};

/// What a tile's rays meet of one layer of a AllHitsGroup.
struct AllHitsWork {
  CrossingList crossings;
  /// Of the k-th crossings the share of light that is theirs; 0: not shown.
  std::array<LaneArray<float>, CrossingList::most> share;

  AllHitsWork() : crossings(tile_capacity) {
    for (auto& shares : share) shares = LaneArray<float>(tile_capacity);
  }
};

/// What frames ask for beside rays of the camera.
struct WorkerNeeds {
  std::size_t layer_count = 1, queue_entries = 0;
  std::size_t light_count = 0;  ///< as far as shadows are cast
  bool occlusion = false;
  bool spread_directions = false;  ///< of the pixels: occlusion, or lights that are not points
  bool world_rays = false;
  std::vector<std::uint8_t> transparent_layers{};  ///< those crossed in one pass
  std::size_t all_hits_groups = 0;
};

/// Light that is added up in an order of its own.
struct LightSums {
  explicit LightSums(std::size_t capacity) : red(capacity), green(capacity), blue(capacity) {}

  LaneArray<double> red, green, blue;
};

/// Crossings of clear surfaces as one walk along each ray finds them.
struct AllHitsGroups {
  /// @param of_layers  whose hits are the first crossings
  void begin_frame(std::vector<LayerWork>& of_layers, const WorkerNeeds& needs) {
    if (layers.size() < of_layers.size()) layers.resize(of_layers.size());
    for (const std::uint8_t l : needs.transparent_layers) {
      if (!layers[l]) layers[l] = std::make_unique<AllHitsWork>();
      layers[l]->crossings.put_first_into(of_layers[l].hits);
    }
    if (memory.size() < needs.all_hits_groups) memory.resize(needs.all_hits_groups);
    while (complete.size() < needs.all_hits_groups) complete.emplace_back(tile_capacity);
  }

  std::vector<std::unique_ptr<AllHitsWork>> layers;  ///< by layer; none of others than in groups
  std::vector<AllHitsScratch> memory;                ///< by group
  std::vector<LaneArray<std::uint8_t>> complete;     ///< by group
  LaneArray<std::uint8_t> goes_on{tile_capacity};    ///< rays to be asked about behind what is noted
  LightSums light{tile_capacity};                    ///< of what is shown
};

/// What a thread has traced and shaded.
struct WorkerCounts {
  std::uint64_t rays = 0, rays_ruled_out = 0, clear_crossings = 0, rays_through = 0, hits = 0;
  std::uint64_t shadow_rays = 0, occlusion_rays = 0;
  std::uint64_t rays_clipped = 0, rays_clipped_away = 0;
  std::uint64_t slice_places = 0;
  std::uint64_t edge_pixels = 0, edge_samples = 0;
  std::uint64_t highlights = 0, smooth_normals = 0, field_values = 0, texture_lookups = 0;
  std::uint64_t tile_ticks = 0, shading_ticks = 0;
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
  std::vector<std::uint32_t> few;  ///< where the groups begin that these are
  // Where effects ask for the light that reaches hits.
  std::unique_ptr<LightRays> light_rays;
  std::vector<Vec3> eye_normals;  ///< of the hits: unit length, world axes, towards the eye
  ReceivedLight received;
  std::vector<SpreadDirections> pixels;  ///< of the tile's rays
  std::unique_ptr<WorldRays> world;      ///< where layers are clipped
  AllHitsGroups all_hits;                ///< where clear surfaces are crossed in one pass
  WorkerCounts counts;

  Worker() {
    few.reserve(tile_capacity / RayBatch::group_size);
    few_rays.has_start_sides = true;
  }

  /// Forgets everything but memory. Kernels know by themselves of which volume and isovalue they keep something.
  void begin_frame(const WorkerNeeds& needs) {
    layers.resize(needs.layer_count);
    for (LayerWork& layer : layers) {
      layer.scratch.queue.reserve(needs.queue_entries);
      layer.scratch.last_t.reset();
      layer.scratch.counters = {};
      layer.rays_are_begun = false;
    }
    if (needs.light_count > 0 || needs.occlusion) {
      if (!light_rays) light_rays = std::make_unique<LightRays>();
      while (received.of_lights.size() < needs.light_count) received.of_lights.emplace_back(tile_capacity);
    }
    if (needs.spread_directions) pixels.reserve(tile_capacity);
    if (needs.occlusion) {
      eye_normals.resize(tile_capacity);
      if (received.ambient.data() == nullptr) received.ambient = LaneArray<float>(tile_capacity);
    }
    if (needs.world_rays) {
      if (!world) world = std::make_unique<WorldRays>();
      world->are_begun = false;
    }
    all_hits.begin_frame(layers, needs);
    counts = {};
  }
};

}  // namespace rhoray::render

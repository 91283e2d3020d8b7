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

/// Colours of a tile's pixels, in the order of its batch.
struct TileColors {
  alignas(64) float red[tile_capacity], green[tile_capacity], blue[tile_capacity], alpha[tile_capacity];
};

/// A tile's rays in the frame of one layer's dataset, and their hits on that layer.
struct LayerWork {
  RayBatch rays{tile_capacity};
  HitBatch hits{tile_capacity};
  KernelScratch scratch;
  /// In this frame: the numbers that all rays of a layer share are written.
  bool rays_are_begun = false;
};

/// For each ray the index of a layer in Frame::layers.
struct LayerOfRays {
  static constexpr std::uint8_t none = 255;
  alignas(64) std::uint8_t of[tile_capacity];
};

/// Rays from hits towards light sources. Each has the slot of the tile's ray that made the hit.
struct LightRays {
  LaneArray<std::uint8_t> is_shown{tile_capacity};  ///< whether there is a hit that light may reach
  /// First rays of the groups that have shown hits; other groups are undefined.
  std::vector<std::size_t> shown;
  LaneArray<StartSide> side{tile_capacity};  ///< side of the hit's surface that faces the eye
  LaneArray<double> direction[3]{LaneArray<double>(tile_capacity), LaneArray<double>(tile_capacity),
                                 LaneArray<double>(tile_capacity)};  ///< unit length, world axes
  /// Below 0: the ray is not traced.
  LaneArray<double> t_max{tile_capacity};
  /// Hits whose surface faces the centre of an area light.
  LaneArray<std::uint8_t> is_lit{tile_capacity};
  /// Rays traced to an area light, and those not occluded.
  LaneArray<float> asked{tile_capacity}, free{tile_capacity};
  std::vector<std::size_t> groups;  ///< first rays of the tile's groups that are traced

  LightRays() {
    shown.reserve(tile_capacity / RayBatch::group_size);
    groups.reserve(tile_capacity / RayBatch::group_size);
  }
};

/// A tile's rays in world axes, and the parts of them that a clip region keeps.
struct WorldRays {
  RayBatch rays{tile_capacity};
  bool are_begun = false;  ///< as LayerWork::rays_are_begun
  KeptParts kept{tile_capacity};
  std::vector<std::uint32_t> cut;  ///< rays to be continued behind the clip gap
  /// Part of each light ray inside the clip region's half spaces.
  LaneArray<double> span_from{tile_capacity}, span_to{tile_capacity};
  RayBatch light_rays{tile_capacity};  ///< rays towards lights

  WorldRays() { cut.reserve(tile_capacity); }
};

/// Crossings of a tile's rays with one layer of an AllHitsGroup.
struct AllHitsWork {
  CrossingList crossings;
  /// For the k-th crossings the share of the light that they show; 0: not shown.
  std::array<LaneArray<float>, CrossingList::most> share;

  AllHitsWork() : crossings(tile_capacity) {
    for (auto& shares : share) shares = LaneArray<float>(tile_capacity);
  }
};

/// What a frame needs of its workers besides camera rays.
struct WorkerNeeds {
  std::size_t layer_count = 1, queue_entries = 0;
  std::size_t light_count = 0;  ///< 0 unless shadows are cast
  bool occlusion = false;
  bool spread_directions = false;  ///< needed for occlusion and area lights
  bool world_rays = false;
  std::vector<std::uint8_t> transparent_layers{};  ///< layers whose crossings one pass finds
  std::size_t all_hits_groups = 0;
};

/// Sums of light that do not follow the order along the ray.
struct LightSums {
  explicit LightSums(std::size_t capacity) : red(capacity), green(capacity), blue(capacity) {}

  LaneArray<double> red, green, blue;
};

/// Crossings with transparent surfaces, found by one walk along each ray.
struct AllHitsGroups {
  /// @param of_layers  their hits receive the first crossings
  void begin_frame(std::vector<LayerWork>& of_layers, const WorkerNeeds& needs) {
    if (layers.size() < of_layers.size()) layers.resize(of_layers.size());
    for (const std::uint8_t l : needs.transparent_layers) {
      if (!layers[l]) layers[l] = std::make_unique<AllHitsWork>();
      layers[l]->crossings.put_first_into(of_layers[l].hits);
    }
    if (scratch.size() < needs.all_hits_groups) scratch.resize(needs.all_hits_groups);
    while (complete.size() < needs.all_hits_groups) complete.emplace_back(tile_capacity);
  }

  /// By layer; null for layers outside the groups.
  std::vector<std::unique_ptr<AllHitsWork>> layers;
  std::vector<Scratch> scratch;                   ///< by group
  std::vector<LaneArray<std::uint8_t>> complete;  ///< by group
  /// Rays to be continued behind their noted crossings.
  LaneArray<std::uint8_t> goes_on{tile_capacity};
  LightSums light{tile_capacity};  ///< sum over the crossings shown
};

/// Counts of what a thread has traced and shaded.
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

/// Memory and counts of one thread, aligned to avoid false sharing.
struct alignas(128) Worker {
  std::vector<LayerWork> layers;
  TileColors colors;
  LayerOfRays shown;  ///< nearest opaque surface; only in frames of several layers
  LayerOfRays first;  ///< first surface, opaque or transparent; only if channels need it
  HitBatch first_hits{tile_capacity};
  /// Of the first hits; only if channels need them.
  std::vector<Vec3> normals = std::vector<Vec3>(tile_capacity);
  LaneArray<double> nearest{tile_capacity};  ///< t of the nearest opaque surface
  /// Transparent surfaces: their light, and in alpha the transmittance.
  TileColors front;
  /// Rays of one layer, continued behind their last crossing.
  RayBatch few_rays{tile_capacity};
  HitBatch few_hits{tile_capacity};
  std::vector<std::uint32_t> few;  ///< first rays of the groups that few_rays holds
  // The next members are used where effects need the light that reaches hits.
  std::unique_ptr<LightRays> light_rays;
  std::vector<Vec3> eye_normals;  ///< unit normals of the hits towards the eye, world axes
  ReceivedLight received;
  std::vector<SpreadDirections> pixels;  ///< for the tile's rays
  std::unique_ptr<WorldRays> world;      ///< null unless layers are clipped
  AllHitsGroups all_hits;                ///< used where one pass finds transparent surfaces
  WorkerCounts counts;

  Worker() {
    few.reserve(tile_capacity / RayBatch::group_size);
    few_rays.has_start_sides = true;
  }

  /// Resets everything but the memory. Kernels track which dataset and isovalue their scratch
  /// belongs to.
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

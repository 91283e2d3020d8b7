#include "render/render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "formats/base/floating_point.h"
#include "formats/base/stopping.h"
#include "formats/intact.h"
#include "render/frame/all_hits.h"
#include "render/frame/antialiasing.h"
#include "render/frame/block_mask.h"
#include "render/frame/check_request.h"
#include "render/frame/pass.h"
#include "render/frame/render_context.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

namespace {

Blend blend_of(const Layer& layer, const Scene& scene) {
  if (layer.mode == Mode::mip) return scene.layers.size() == 1 ? Blend::opaque : Blend::additive;
  return layer.material.opacity < 1 ? Blend::transparent : Blend::opaque;
}

/// Lookup of the attributes that a layer's effects need besides the hits; null if they need none.
std::shared_ptr<const HitLookup> choose_lookup(const Dataset& dataset, const Layer& layer, unsigned threads,
                                               const Frame& frame) {
  const EffectSet effects = effects_called_for(layer);
  HitAttributes attributes{.smooth_gradients = effects.smooth_normals, .field = {}};
  if (effects.field_color) attributes.field = layer.material.color_by->field;
  if (layer.mode == Mode::slice || attributes.none()) return nullptr;
  return std::make_shared<const HitLookup>(dataset.implementation(), attributes, threads, frame.machine, frame.stop);
}

std::shared_ptr<const TextureLookup> choose_texture(const Dataset& dataset, const Layer& layer, Machine machine) {
  if (!effects_called_for(layer).texture) return nullptr;
  const Texture& texture = *layer.material.texture;
  return std::make_shared<const TextureLookup>(
      texture.grid(), composed(texture.world_from_texels().inverse(), dataset.implementation().world_from_data),
      machine);
}

/// True if a layer may occlude light that some layer's effects trace.
bool may_shade_others(const Layer& layer, const Scene& scene) {
  return holds_light_back(layer) && std::any_of(scene.layers.begin(), scene.layers.end(), [&](const Layer& any) {
           const EffectSet effects = effects_called_for(scene, any);
           return effects.shadows || effects.occlusion;
         });
}

/// True if rays that start at hits are traced through a layer.
bool meets_rays_from_crossings(const Layer& layer, Blend blend, const Scene& scene) {
  return layer.mode != Mode::slice && (blend == Blend::transparent || may_shade_others(layer, scene));
}

FrameLayer choose_layer(const Dataset& dataset, const Layer& layer, Blend blend, const Scene& scene,
                        const FrameOptions& options, const Frame& frame) {
  const LoadedDataset& implementation = dataset.implementation();
  const Machine machine = frame.machine;
  const bool is_mip = layer.mode == Mode::mip;
  RayQuery query{.isovalue = layer.isovalue,
                 .field_range = implementation.field.range,
                 .method = layer.method,
                 .use_hierarchy = options.use_hierarchy,
                 .use_last_t = options.use_last_t,
                 .time_phases = options.time_phases};
  RayQuery continuation_query = query;
  continuation_query.method = default_method(dataset, is_mip ? Mode::isosurface : layer.mode);
  Intersectors intersectors = choose_intersectors(implementation, query, machine);
  if (is_mip || layer.mode == Mode::slice) intersectors.prepare = nullptr;
  std::optional<Intersectors> continuation;
  if (meets_rays_from_crossings(layer, blend, scene))
    continuation = choose_intersectors(implementation, continuation_query, machine);
  return {.dataset = implementation,
          .blend = blend,
          .query = query,
          .intersectors = intersectors,
          .kernel = is_mip ? intersectors.largest : intersectors.first_hit,
          .continuation_query = continuation_query,
          .continuation = continuation,
          .shading = {.layer = layer,
                      .effects = effects_called_for(scene, layer),
                      .facing = Facing(implementation.world_from_data),
                      .lights = lights_of(scene, implementation.world_from_data),
                      .fog = scene.fog,
                      .proves = proves(layer.method),
                      .lookup = choose_lookup(dataset, layer, options.threads, frame),
                      .texture = choose_texture(dataset, layer, machine),
                      .machine = machine},
          .data_from_world = implementation.world_from_data.inverse()};
}

void add_needs(const FrameLayer& layer, WorkerNeeds& needs) {
  const LayerShading& shading = layer.shading;
  if (shading.layer.mode == Mode::mip)
    needs.queue_entries = std::max(needs.queue_entries, layer.intersectors.queue_entries);
  needs.world_rays |= layer.clipped || layer.slice;
  if (shading.effects.shadows) needs.light_count = shading.lights.lights.size();
  needs.occlusion |= shading.effects.occlusion;
  needs.spread_directions |= shading.effects.occlusion || shading.effects.soft_shadows;
}

/// Part of a layer that the clip region keeps.
enum class Left { all, part, nothing };

Left what_is_left_of(const Dataset& dataset, const Layer& layer, const Scene& scene) {
  const Box3 whole = layer.mode == Mode::slice ? part_of_plane(layer.plane, dataset.bounds()) : dataset.bounds();
  if (!scene.clip || !layer.clipped || leaves_whole(*scene.clip, whole)) return Left::all;
  return what_is_left(*scene.clip, whole).isEmpty() ? Left::nothing : Left::part;
}

/// True if no ray through a pixel's centre can hit the dataset's box.
bool lies_outside_view(const Dataset& dataset, const CameraRays& camera_rays, const FrameOptions& options,
                       Machine machine) {
  const LoadedDataset& implementation = dataset.implementation();
  const Affine& world_from_data = implementation.world_from_data;
  const Box3& box = implementation.bounds_data;
  const BoxProjection projection(camera_rays, world_from_data.inverse(), world_from_data, box);
  if (!projection.is_certain()) return false;
  const PixelLattice lattice{.width = options.width, .height = options.height};
  BlockMask met(lattice);
  add_blocks_that_may_meet(box_around(box), projection, lattice, met, machine);
  return met.is_empty();
}

/// The pixels that are asked for, and those around them with which antialiasing compares them.
PixelRect window_to_trace(const FrameOptions& options) {
  PixelRect window = options.window.value_or(PixelRect{.width = options.width, .height = options.height});
  const int margin = options.antialiasing > 1 ? tile_edge : 0;
  window.x -= margin, window.y -= margin;
  window.width += 2 * margin, window.height += 2 * margin;
  return window;
}

Frame frame_without_layers(const Scene& scene, const FrameOptions& options, const std::stop_token& stop) {
  return {.layers = {},
          .camera_rays = CameraRays(scene.camera, options.width, options.height),
          .clip = std::nullopt,
          .background = scene.transparent_background ? Vec3(0, 0, 0) : scene.background,
          .has_transparent_background = scene.transparent_background,
          .keeps_channels = options.channels.any() || options.antialiasing > 1,
          .window = window_to_trace(options),
          .occlusion = scene.occlusion,
          .needs = {},
          .machine = options.machine.value_or(chosen_machine()),
          .stop = stop};
}

/// Omits what cannot be seen: surfaces of zero opacity, layers that are clipped away completely,
/// and layers outside the view that shade nothing. Nothing is prepared or read for these.
void choose_layers(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                   const Watch& watch, Frame& frame) {
  for (const auto& [blend, is_slice] : {std::pair{Blend::opaque, true},
                                        {Blend::opaque, false},
                                        {Blend::transparent, true},
                                        {Blend::transparent, false},
                                        {Blend::additive, false}})
    for (const Layer& layer : scene.layers) {
      if (blend_of(layer, scene) != blend || (layer.mode == Mode::slice) != is_slice) continue;
      if (layer.mode != Mode::mip && layer.material.opacity == 0) continue;
      const Dataset& dataset = datasets[layer.dataset];
      const Left left = what_is_left_of(dataset, layer, scene);
      if (left == Left::nothing) continue;
      // Antialiasing samples lie slightly beyond the outermost rays.
      if (options.antialiasing == 1 && !may_shade_others(layer, scene) &&
          lies_outside_view(dataset, frame.camera_rays, options, frame.machine))
        continue;
      if (proves(layer.method)) frame.range_proof += dataset.prove_ranges(options.threads, watch);
      frame.layers.push_back(choose_layer(dataset, layer, blend, scene, options, frame));
      if (is_slice)
        frame.layers.back().slice =
            std::make_shared<const SlicePlane>(dataset.implementation(), layer, scene.clip, frame.machine);
      if (left == Left::part) {
        frame.layers.back().clipped = true;
        if (!frame.clip) frame.clip.emplace(*scene.clip, frame.machine);
      }
      add_needs(frame.layers.back(), frame.needs);
    }
  frame.needs.layer_count = frame.layers.size();
}

/// Bounds of the part of a layer that is kept, data frame; the whole dataset's bounds where that
/// part is too small to tell.
Box3 kept_bounds(const FrameLayer& layer, const std::optional<Clip>& clip) {
  const Box3& bounds = layer.dataset.bounds_data;
  if (!layer.clipped) return bounds;
  Clip in_data{.cuts_away = clip->cuts_away};
  const Affine& map = layer.dataset.world_from_data;
  for (const HalfSpace& half : half_spaces_of(*clip))
    in_data.planes.push_back(
        {.point = layer.data_from_world.point(half.point),
         .normal = {half.normal.dot(map.x_axis), half.normal.dot(map.y_axis), half.normal.dot(map.z_axis)}});
  const Box3 kept = what_is_left(in_data, bounds);
  return !kept.isEmpty() && kept.size().length() > 0x1p-20 * bounds.size().length() ? kept : bounds;
}

bool has_extent(const Box3& box) {
  const Vec3 size = box.size();
  const double longest = std::max({size.x, size.y, size.z});
  return longest > 0 && std::isfinite(longest);
}

/// Prepares a layer and finds its bounding boxes.
/// @return  true if wide kernels were prepared
bool prepare(FrameLayer& layer, const std::optional<Clip>& clip, const FrameOptions& options,
             const std::stop_token& stop) {
  end_if_stopped(stop);
  if (layer.slice) {
    if (options.use_hierarchy) layer.boxes = layer.slice->boxes();
    return false;
  }
  if (const Preparation prepare = layer.intersectors.prepare)
    layer.boxes = prepare(layer.dataset, layer.query, options.threads, stop);
  const bool is_wide = layer.boxes.has_value();
  if (!is_wide && options.use_hierarchy && layer.intersectors.keeps_to_bounds && has_extent(layer.dataset.bounds_data))
    layer.boxes = box_around(kept_bounds(layer, clip));
  return is_wide;
}

/// Largest factor by which a map stretches vectors.
double longest_stretch(const Affine& map) {
  return std::sqrt(map.x_axis.dot(map.x_axis) + map.y_axis.dot(map.y_axis) + map.z_axis.dot(map.z_axis));
}

wide::LightPlace place_in(const FrameLayer& layer, const LayerLights::One& light) {
  const double stretch = longest_stretch(layer.data_from_world);
  if (light.kind == Light::Kind::point) return {.is_place = true, .at = light.place, .reach = light.extent * stretch};
  // Distance from the centre of a cap of this height to its rim.
  return {.at = layer.data_from_world.vector(light.place), .reach = std::sqrt(2 * light.extent) * stretch};
}

/// Finds the parts of a layer that may occlude lights that cast shadows.
void prepare_occluders(FrameLayer& layer, const FrameOptions& options, const std::stop_token& stop,
                       wide::OccluderCache& memory) {
  if (!holds_light_back(layer.shading.layer) || !layer.continuation || layer.continuation->occluders == nullptr) return;
  if (!layer.shading.effects.shadows || layer.clipped) return;
  layer.occluders.resize(layer.shading.lights.lights.size());
  for (std::size_t l = 0; l < layer.occluders.size(); ++l) {
    const LayerLights::One& light = layer.shading.lights.lights[l];
    if (!light.casts_shadows) continue;
    const wide::LightPlace place = place_in(layer, light);
    layer.occluders[l] = memory.of(*layer.continuation->occluders, layer.dataset, layer.continuation_query, place,
                                   layer.shading.machine, options.threads, stop);
  }
}

/// Calls act(); false if a stop request ended it.
template <class Act>
bool completes(const Act& act) {
  try {
    act();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::interrupted) throw;
    return false;
  }
  return true;
}

/// Refuses a picture of files that lost bytes while they were read.
void require_intact(std::span<const Dataset> datasets, const Scene& scene) {
  for (const Dataset& dataset : datasets) formats::require_intact(dataset.file());
  for (const Layer& layer : scene.layers)
    if (layer.material.texture) formats::require_intact(layer.material.texture->file());
}

/// Passes of a picture; the first one traces one pixel of first_spacing x first_spacing.
std::vector<Pass> passes_of(const Frame& frame, const FrameOptions& options, int first_spacing) {
  std::vector<Pass> passes(1);
  const PixelLattice all{.width = options.width, .height = options.height};
  const auto lattice = [&](int x_first, int y_first, int spacing, int extent) {
    PixelLattice of = all;
    of.x_first = x_first, of.y_first = y_first, of.spacing = spacing, of.extent = extent;
    return of;
  };
  passes[0].add(frame, lattice(0, 0, first_spacing, first_spacing));
  for (int half = first_spacing / 2; half >= 1; half /= 2) {
    Pass& pass = passes.emplace_back();
    pass.add(frame, lattice(half, half, 2 * half, half));
    pass.add(frame, lattice(half, 0, 2 * half, half));
    pass.add(frame, lattice(0, half, 2 * half, half));
  }
  return passes;
}

FrameStatistics statistics_of(const RenderContext::Implementation& memory, const Scene& scene, Machine machine) {
  FrameStatistics statistics;
  KernelCounters counters;
  for (const Worker* worker : memory.workers()) {
    for (const LayerWork& layer : worker->layers) counters += layer.scratch.counters;
    const WorkerCounts& counts = worker->counts;
    statistics.rays += counts.rays;
    statistics.rays_ruled_out += counts.rays_ruled_out;
    statistics.rays_clipped += counts.rays_clipped;
    statistics.rays_clipped_away += counts.rays_clipped_away;
    statistics.clear_crossings += counts.clear_crossings;
    statistics.rays_through += counts.rays_through;
    statistics.shadow_rays += counts.shadow_rays;
    statistics.occlusion_rays += counts.occlusion_rays;
    statistics.edge_pixels += counts.edge_pixels;
    statistics.edge_samples += counts.edge_samples;
    statistics.hits += counts.hits;
    statistics.slice_lookups += counts.slice_places;
    statistics.highlights_shaded += counts.highlights;
    statistics.normals_smoothed += counts.smooth_normals;
    statistics.colors_looked_up += counts.field_values;
    statistics.texture_lookups += counts.texture_lookups;
    statistics.largest_error = std::max(statistics.largest_error, counts.largest_error);
  }
  statistics.macrocells_visited = counters.macrocells_visited;
  statistics.cells_visited = counters.cells_visited;
  statistics.cells_solved = counters.cells_solved;
  statistics.samples_taken = counters.samples_taken;
  statistics.rays_redone = counters.rays_redone;
  statistics.rays_exact = counters.rays_exact;
  statistics.touches = counters.touches;
  statistics.machine = name_of(counters.rays_wide > 0 ? machine : Machine::scalar);
  if (!all_prove(scene)) statistics.largest_error = std::numeric_limits<double>::quiet_NaN();
  return statistics;
}

FrameStatistics::Phases phases_of(const RenderContext::Implementation& memory, double seconds_per_tick) {
  std::uint64_t intersection = 0, shading = 0, tiles = 0;
  for (const Worker* worker : memory.workers()) {
    for (const LayerWork& layer : worker->layers) intersection += layer.scratch.counters.intersection_ticks;
    shading += worker->counts.shading_ticks;
    tiles += worker->counts.tile_ticks;
  }
  FrameStatistics::Phases phases;
  phases.intersection = static_cast<double>(intersection) * seconds_per_tick;
  phases.shading = static_cast<double>(shading) * seconds_per_tick;
  phases.traversal = static_cast<double>(tiles) * seconds_per_tick - phases.intersection - phases.shading;
  return phases;
}

}  // namespace

void RenderContext::for_each(std::size_t count, unsigned threads,
                             const std::function<void(std::size_t, std::size_t)>& act) {
  implementation_->threads(threads).for_each_tile(count, act);
}

std::size_t RenderContext::worker_count(unsigned threads) {
  return implementation_->threads(threads).worker_count();
}

Method default_method(const Dataset& dataset, Mode mode) {
  const bool is_wide = mode != Mode::mip && answers_wide(dataset.implementation(), method_of(Accuracy::float32),
                                                         &Intersectors::first_hit, Machine::baseline);
  return method_of(is_wide ? Accuracy::float32 : Accuracy::float64);
}

RenderContext::RenderContext(Arena arena) : implementation_(std::make_unique<Implementation>(arena)) {}
RenderContext::~RenderContext() = default;
RenderContext::RenderContext(RenderContext&&) noexcept = default;
RenderContext& RenderContext::operator=(RenderContext&&) noexcept = default;

FrameStatistics render(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer) {
  RenderContext memory;
  return render(datasets, scene, options, framebuffer, memory);
}

FrameStatistics render(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer, RenderContext& memory) {
  return refine(datasets, scene, options, {.first_spacing = 1}, framebuffer, memory);
}

FrameStatistics render(const Dataset& dataset, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer) {
  return render(std::span(&dataset, 1), scene, options, framebuffer);
}

FrameStatistics render(const Dataset& dataset, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer, RenderContext& memory) {
  return render(std::span(&dataset, 1), scene, options, framebuffer, memory);
}

FrameStatistics refine(const Dataset& dataset, const Scene& scene, const FrameOptions& options,
                       const Refinement& refinement, Framebuffer& framebuffer, RenderContext& memory) {
  return refine(std::span(&dataset, 1), scene, options, refinement, framebuffer, memory);
}

FrameStatistics refine(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                       const Refinement& refinement, Framebuffer& framebuffer, RenderContext& memory) {
  const DefaultFloatingPoint default_floating_point;
  check_request(datasets, scene, options);
  check_refinement(refinement);
  const auto clock_start = std::chrono::steady_clock::now();
  const std::uint64_t ticks_start = ticks_now();

  const auto seconds_since = [](std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };

  const std::stop_token& stop = refinement.watch.stop;
  const Progress& progress = refinement.watch.progress;
  const auto preparation_start = std::chrono::steady_clock::now();
  Frame frame = frame_without_layers(scene, options, stop);
  bool is_wide = false, prepares = false;
  const bool is_prepared = completes([&] {
    choose_layers(datasets, scene, options, refinement.watch, frame);
    ProgressMeter preparing(progress, "preparing (layers)", frame.layers.size());
    for (FrameLayer& layer : frame.layers) {
      is_wide |= prepare(layer, scene.clip, options, stop);
      prepare_occluders(layer, options, stop, memory.implementation().occluders());
      prepares |= layer.intersectors.prepare != nullptr || layer.shading.lookup;
      preparing.add(1);
    }
  });
  if (!is_prepared) frame.layers.clear(), frame.needs = {};  // no tile is traced after a stop request
  choose_all_hits(options, frame);
  const double proof_s = frame.range_proof.wall_s;
  const double preparation_s = prepares ? seconds_since(preparation_start) - proof_s : 0;
  const std::vector<Pass> passes = passes_of(frame, options, refinement.first_spacing);
  std::optional<EdgeSamples> edges;
  if (options.antialiasing > 1) edges.emplace(frame, options);
  framebuffer.reshape(options.width, options.height, edges ? edges->channels() : options.channels);
  for (int c = 0; c < 3; ++c)
    framebuffer.background[static_cast<std::size_t>(c)] = static_cast<float>(frame.background[c]);
  framebuffer.is_transparent = frame.has_transparent_background;
  RenderContext::Implementation& kept = memory.implementation();
  kept.begin_frame(options.threads, frame.needs);
  int spacing = refinement.first_spacing;
  std::size_t tile_count = 0;
  for (const Pass& pass : passes) tile_count += pass.tile_count();
  ProgressMeter tracing(progress, "tracing (tiles)", tile_count);
  for (const Pass& pass : passes) {
    kept.threads().for_each_tile(pass.tile_count(), [&](std::size_t tile, std::size_t worker) {
      if (stop.stop_requested()) return;
      pass.trace_tile(frame, tile, kept.worker(worker), framebuffer);
      tracing.add(1);
    });
    if (stop.stop_requested()) break;
    if (refinement.pass_done && !refinement.pass_done(spacing)) break;
    spacing /= 2;
  }
  if (edges) {
    if (spacing == 0) edges->add_to(kept, refinement.watch, framebuffer);
    framebuffer.keep(options.channels);
  }
  require_intact(datasets, scene);

  FrameStatistics statistics = statistics_of(kept, scene, frame.machine);
  if (is_wide) statistics.machine = name_of(frame.machine);
  statistics.preparation_s = preparation_s;
  statistics.range_proof = frame.range_proof;
  const double elapsed_s = seconds_since(clock_start);
  statistics.wall_s = elapsed_s - proof_s;
  if (options.time_phases)
    statistics.phases = phases_of(kept, elapsed_s / static_cast<double>(ticks_now() - ticks_start));
  return statistics;
}

}  // namespace rhoray::render

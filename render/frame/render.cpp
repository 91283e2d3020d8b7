#include "render/render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "formats/base/text.h"
#include "formats/base/trouble.h"
#include "render/effects/effects.h"
#include "render/frame/camera_rays.h"
#include "render/frame/for_each_tile.h"
#include "render/kernels/kernels.h"
#include "render/march/ticks.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

namespace {

constexpr int tile_edge = 32;  // pixels; about a thousand tiles in a picture of a million pixels

struct Tile {
  int x_begin, x_end, y_begin, y_end;
};

/// What was chosen once for the frame; nothing here changes while tiles are traced.
struct Frame {
  const VolumeImplementation& volume;
  const Scene& scene;
  Kernel kernel;
  Question question;
  EffectSet effects;
  CameraRays camera_rays;
  Affine volume_from_world;
  int width, height;

  int tiles_across() const { return (width + tile_edge - 1) / tile_edge; }
  int tiles_down() const { return (height + tile_edge - 1) / tile_edge; }

  Tile tile(std::size_t index) const {
    const int column = static_cast<int>(index) % tiles_across(), row = static_cast<int>(index) / tiles_across();
    return {column * tile_edge, std::min(width, (column + 1) * tile_edge), row * tile_edge,
            std::min(height, (row + 1) * tile_edge)};
  }
};

/// Memory and counts of one thread; on cache lines of its own.
struct alignas(128) Worker {
  std::vector<Ray> rays_world;
  RayBatch rays;
  HitBatch hits;
  KernelScratch scratch;
  std::uint64_t ray_count = 0, hit_count = 0, highlights = 0;
  std::uint64_t tile_ticks = 0, shading_ticks = 0;
  double largest_error = 0;
};

void make_rays(const Frame& frame, const Tile& tile, Worker& worker) {
  std::size_t r = 0;
  for (int y = tile.y_begin; y < tile.y_end; ++y)
    for (int x = tile.x_begin; x < tile.x_end; ++x, ++r) {
      const Ray ray = frame.camera_rays.through_pixel(x, y);
      worker.rays_world[r] = ray;
      worker.rays.set(r, {.origin = frame.volume_from_world.point(ray.origin),
                          .direction = frame.volume_from_world.vector(ray.direction)});
    }
  worker.rays.count = r;
}

/// The unit normal towards the eye; zero where the gradient is zero or not finite.
Vec3 normal_towards_eye(const Vec3& gradient_world, const Vec3& ray_direction) {
  // Scaled first, so that squares of very large or very small gradients neither overflow nor vanish.
  const double largest = std::max({std::abs(gradient_world.x), std::abs(gradient_world.y), std::abs(gradient_world.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return {0, 0, 0};
  const Vec3 unit = (gradient_world / largest).normalized();
  return unit.dot(ray_direction) > 0 ? -unit : unit;
}

/// What a pixel took, and how sure it is.
void write_diary(std::size_t pixel, const Hit& hit, Framebuffer& out) {
  if (!out.error.empty()) out.error[pixel] = static_cast<float>(hit.error);
  if (!out.roots.empty()) out.roots[pixel] = hit.root_count;
  if (!out.iterations.empty()) out.iterations[pixel] = hit.iteration_count;
  if (!out.cost.empty()) out.cost[pixel] = hit.cost;
}

void write_pixel(const Frame& frame, std::size_t pixel, const Ray& ray_world, const Hit& hit, Framebuffer& out,
                 Worker& worker) {
  const bool is_hit = !hit.is_miss();
  Vec3 color = frame.scene.background, normal(0, 0, 0);
  if (is_hit) {
    if (frame.effects.diffuse || !out.normal.empty())
      normal = normal_towards_eye(frame.volume.world_from_volume.gradient(hit.gradient), ray_world.direction);
    color = shade(frame.scene, frame.effects, {normal, -ray_world.direction, hit.value});
    ++worker.hit_count;
    if (frame.effects.specular) ++worker.highlights;
  }
  for (int channel = 0; channel < 3; ++channel)
    out.color[4 * pixel + static_cast<std::size_t>(channel)] = static_cast<float>(color[channel]);
  out.color[4 * pixel + 3] = is_hit ? 1 : 0;
  if (!out.depth.empty()) out.depth[pixel] = static_cast<float>(hit.t);
  if (!out.normal.empty())
    for (int axis = 0; axis < 3; ++axis)
      out.normal[3 * pixel + static_cast<std::size_t>(axis)] = static_cast<float>(normal[axis]);
  if (!out.cell.empty()) out.cell[pixel] = is_hit ? hit.cell : Framebuffer::no_cell;
  if (!out.value.empty()) out.value[pixel] = is_hit ? hit.value : std::numeric_limits<double>::quiet_NaN();
  if (is_hit && hit.error > worker.largest_error) worker.largest_error = hit.error;
  write_diary(pixel, hit, out);
}

void trace_tile(const Frame& frame, const Tile& tile, Framebuffer& out, Worker& worker) {
  const std::uint64_t start = ticks_now();
  make_rays(frame, tile, worker);
  worker.scratch.last_t.reset();
  frame.kernel(frame.volume, frame.question, worker.rays, worker.hits, worker.scratch);
  worker.ray_count += worker.rays.count;

  const std::uint64_t shading_start = ticks_now();
  std::size_t r = 0;
  for (int y = tile.y_begin; y < tile.y_end; ++y)
    for (int x = tile.x_begin; x < tile.x_end; ++x, ++r) {
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(x);
      write_pixel(frame, pixel, worker.rays_world[r], worker.hits[r], out, worker);
    }
  const std::uint64_t end = ticks_now();
  worker.shading_ticks += end - shading_start;
  worker.tile_ticks += end - start;
}

void check_request(const Scene& scene, const FrameOptions& options) {
  if (options.width < 1 || options.height < 1)
    throw Error(Trouble::usage,
                concat("picture of ", options.width, " x ", options.height, " pixels; expected at least 1 x 1"));
  if (scene.mode == Mode::isosurface && !std::isfinite(scene.isovalue))
    throw Error(Trouble::usage, concat("isovalue ", scene.isovalue, "; expected a finite number"));
  if (scene.mode == Mode::mip && (scene.window.is_empty() || !std::isfinite(scene.window.hi - scene.window.lo)))
    throw Error(Trouble::usage,
                concat("window ", scene.window.lo, " to ", scene.window.hi, "; expected a finite range"));
  const Method& method = scene.method;
  if (method.way == Method::Way::sampled && !(method.step >= 1e-4 && method.step <= 1e4))
    throw Error(Trouble::usage, concat("steps of ", method.step, " cells; expected 0.0001 to 10000"));
  if (method.way == Method::Way::slack && !(method.slack >= 0 && method.slack <= 1))
    throw Error(Trouble::usage, concat("a slack of ", method.slack, "; expected 0 to 1"));
  if (options.channels.error && !proves(method))
    throw Error(Trouble::usage, "the channel 'error' needs a method that proves one: certified or exact");
}

}  // namespace

FrameStatistics render(const Volume& volume, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer) {
  check_request(scene, options);
  const auto clock_start = std::chrono::steady_clock::now();
  const std::uint64_t ticks_start = ticks_now();

  const VolumeImplementation& implementation = volume.implementation();
  const Kernels kernels = choose_kernels(implementation, scene.method);
  const bool is_mip = scene.mode == Mode::mip;
  const Frame frame{.volume = implementation,
                    .scene = scene,
                    .kernel = is_mip ? kernels.largest_value : kernels.first_crossing,
                    .question = {.isovalue = scene.isovalue,
                                 .field_range = implementation.field.range,
                                 .method = scene.method,
                                 .use_hierarchy = options.use_hierarchy,
                                 .use_last_t = options.use_last_t,
                                 .time_phases = options.time_phases},
                    .effects = effects_called_for(scene),
                    .camera_rays = CameraRays(scene.camera, options.width, options.height),
                    .volume_from_world = implementation.world_from_volume.inverse(),
                    .width = options.width,
                    .height = options.height};

  framebuffer = Framebuffer(options.width, options.height, options.channels);
  std::vector<Worker> workers(worker_count(options.threads));
  for (Worker& worker : workers) {
    worker.rays_world.resize(tile_edge * tile_edge);
    worker.rays = RayBatch(tile_edge * tile_edge);
    worker.hits = HitBatch(tile_edge * tile_edge);
    if (is_mip) worker.scratch.queue.reserve(kernels.queue_entries);
  }
  const auto tile_count = static_cast<std::size_t>(frame.tiles_across()) * static_cast<std::size_t>(frame.tiles_down());
  for_each_tile(tile_count, options.threads, [&](std::size_t tile, std::size_t worker) {
    trace_tile(frame, frame.tile(tile), framebuffer, workers[worker]);
  });

  FrameStatistics statistics;
  KernelCounters counters;
  std::uint64_t tile_ticks = 0, shading_ticks = 0;
  for (const Worker& worker : workers) {
    counters += worker.scratch.counters;
    statistics.rays += worker.ray_count;
    statistics.hits += worker.hit_count;
    statistics.highlights_shaded += worker.highlights;
    statistics.largest_error = std::max(statistics.largest_error, worker.largest_error);
    tile_ticks += worker.tile_ticks;
    shading_ticks += worker.shading_ticks;
  }
  statistics.macrocells_visited = counters.macrocells_visited;
  statistics.cells_visited = counters.cells_visited;
  statistics.cells_solved = counters.cells_solved;
  statistics.samples_taken = counters.samples_taken;
  statistics.rays_redone = counters.rays_redone;
  statistics.rays_judged = counters.rays_judged;
  statistics.touches = counters.touches;
  if (!proves(scene.method)) statistics.largest_error = std::numeric_limits<double>::quiet_NaN();
  statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - clock_start).count();
  if (options.time_phases) {
    const double seconds_per_tick = statistics.wall_s / static_cast<double>(ticks_now() - ticks_start);
    statistics.phases.intersection = static_cast<double>(counters.intersection_ticks) * seconds_per_tick;
    statistics.phases.shading = static_cast<double>(shading_ticks) * seconds_per_tick;
    statistics.phases.traversal =
        static_cast<double>(tile_ticks) * seconds_per_tick - statistics.phases.intersection - statistics.phases.shading;
  }
  return statistics;
}

}  // namespace rhoray::render

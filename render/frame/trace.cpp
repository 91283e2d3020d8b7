#include "render/trace.h"

#include <algorithm>
#include <cmath>

#include "formats/base/checks.h"
#include "formats/base/text.h"
#include "formats/base/trouble.h"
#include "render/frame/camera_rays.h"
#include "render/frame/tile_threads.h"
#include "render/kernels/kernels.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

namespace {

constexpr std::size_t batch_size = 1024;  // rays that one thread takes at a time

}  // namespace

void trace(const Volume& volume, const TraceOptions& options, std::span<const FrameRay> rays,
           std::span<FrameHit> hits) {
  RHORAY_CHECK(rays.size() == hits.size());
  if (!std::isfinite(options.isovalue))
    throw Error(Trouble::usage, concat("isovalue ", options.isovalue, "; expected a finite number"));
  const VolumeImplementation& implementation = volume.implementation();
  const Kernel first_crossing = choose_kernels(implementation, options.method).first_crossing;
  Question question;
  question.isovalue = options.isovalue;
  question.method = options.method;
  const TileThreads threads(options.threads);
  std::vector<KernelScratch> scratches(threads.worker_count());
  const std::size_t batch_count = (rays.size() + batch_size - 1) / batch_size;
  threads.for_each_tile(batch_count, [&](std::size_t batch, std::size_t worker) {
    const std::size_t first = batch * batch_size, count = std::min(batch_size, rays.size() - first);
    std::vector<Ray> asked(count);
    std::vector<Hit> answered(count);
    for (std::size_t r = 0; r < count; ++r)
      asked[r] = {.origin = rays[first + r].origin, .direction = rays[first + r].direction};
    ask(first_crossing, implementation, question, asked, answered, scratches[worker]);
    for (std::size_t r = 0; r < count; ++r)
      hits[first + r] = {answered[r].t, answered[r].cell, answered[r].gradient, answered[r].error};
  });
}

std::vector<FrameRay> camera_rays(const Volume& volume, const Camera& camera, int width, int height) {
  const CameraRays through(camera, width, height);
  const Affine volume_from_world = volume.implementation().world_from_volume.inverse();
  std::vector<FrameRay> rays;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Ray ray = through.through_pixel(x, y);
      rays.push_back({volume_from_world.point(ray.origin), volume_from_world.vector(ray.direction)});
    }
  return rays;
}

Affine world_from_frame(const Volume& volume) {
  return volume.implementation().world_from_volume;
}

}  // namespace rhoray::render

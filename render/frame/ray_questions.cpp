#include "render/ray_questions.h"

#include <algorithm>
#include <cmath>

#include "formats/base/checks.h"
#include "formats/base/text.h"
#include "formats/base/trouble.h"
#include "render/frame/camera_rays.h"
#include "render/frame/tile_threads.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

namespace {

constexpr std::size_t batch_size = 1024;  // rays that one of several threads takes at a time

double finite(double isovalue) {
  if (!std::isfinite(isovalue))
    throw Error(Trouble::usage, concat("isovalue ", isovalue, "; expected a finite number"));
  return isovalue;
}

}  // namespace

RayQuestions::RayQuestions(const Volume& volume, double isovalue, const Method& method, unsigned threads)
    : volume_(volume.implementation()),
      question_{.isovalue = finite(isovalue), .field_range = volume.field().range, .method = method},
      kernels_(choose_kernels(volume_, method)),
      threads_(threads),
      scratches_(TileThreads(threads).worker_count()) {
  scratches_.front().queue.reserve(kernels_.queue_entries);
}

void RayQuestions::first_crossings(std::span<const Ray> rays, std::span<Hit> hits) {
  RHORAY_CHECK(rays.size() == hits.size());
  if (scratches_.size() == 1 || rays.size() <= batch_size)
    return ask(kernels_.first_crossing, volume_, question_, rays, hits, scratches_.front());
  const std::size_t batch_count = (rays.size() + batch_size - 1) / batch_size;
  TileThreads(threads_).for_each_tile(batch_count, [&](std::size_t batch, std::size_t worker) {
    const std::size_t first = batch * batch_size, count = std::min(batch_size, rays.size() - first);
    ask(kernels_.first_crossing, volume_, question_, rays.subspan(first, count), hits.subspan(first, count),
        scratches_[worker]);
  });
}

Hit RayQuestions::first_crossing(const Ray& ray) {
  Hit hit;
  first_crossings(std::span(&ray, 1), std::span(&hit, 1));
  return hit;
}

void RayQuestions::largest_values(std::span<const Ray> rays, std::span<Hit> hits) {
  RHORAY_CHECK(rays.size() == hits.size());
  scratches_.front().last_t.reset();
  ask(kernels_.largest_value, volume_, question_, rays, hits, scratches_.front());
}

KernelCounters RayQuestions::counters() const {
  KernelCounters sum;
  for (const KernelScratch& scratch : scratches_) sum += scratch.counters;
  return sum;
}

std::vector<Ray> camera_rays(const Volume& volume, const Camera& camera, int width, int height) {
  const CameraRays through(camera, width, height);
  const Affine volume_from_world = volume.implementation().world_from_volume.inverse();
  std::vector<Ray> rays;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Ray ray = through.through_pixel(x, y);
      rays.push_back({volume_from_world.point(ray.origin), volume_from_world.vector(ray.direction)});
    }
  return rays;
}

const Affine& world_from_ray_frame(const Volume& volume) {
  return volume.implementation().world_from_volume;
}

}  // namespace rhoray::render

#include "render/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "formats/intact.h"
#include "render/dataset/loaded_dataset.h"
#include "render/frame/camera_rays.h"
#include "render/frame/tile_threads.h"

namespace rhoray::render {

namespace {

constexpr std::size_t batch_size = 1024;  // rays that a thread takes at a time

double finite(double isovalue) {
  if (!std::isfinite(isovalue))
    throw Error(ErrorCode::usage, concat("isovalue ", isovalue, "; expected a finite number"));
  return isovalue;
}

}  // namespace

struct RayCaster::Worker {
  RayBatch rays{batch_size};
  HitBatch hits{batch_size};
  KernelScratch scratch;

  Worker() { rays.has_start_sides = true; }
};

RayCaster::RayCaster(const Dataset& dataset, double isovalue, const Method& method, unsigned threads,
                     std::optional<Machine> machine, const Watch& watch)
    : dataset_(dataset.implementation()),
      query_{.isovalue = finite(isovalue), .field_range = dataset.field().range, .method = method},
      machine_(machine.value_or(chosen_machine())),
      intersectors_(choose_intersectors(dataset_, query_, machine_)),
      threads_(threads),
      workers_(TileThreads(threads).worker_count()) {
  if (proves(method)) range_proof_ = dataset.prove_ranges(threads, watch);
  workers_.front().scratch.queue.reserve(intersectors_.queue_entries);
}

RayCaster::~RayCaster() = default;

RayCaster::Scratch::Scratch(std::optional<Machine> machine) : worker_(std::make_unique<Worker>()), machine_(machine) {}
RayCaster::Scratch::~Scratch() = default;
RayCaster::Scratch::Scratch(Scratch&&) noexcept = default;
RayCaster::Scratch& RayCaster::Scratch::operator=(Scratch&&) noexcept = default;

Intersectors RayCaster::intersectors_for(Machine machine) const {
  return machine == machine_ ? intersectors_ : choose_intersectors(dataset_, query_, machine);
}

void RayCaster::answer(Kernel kernel, std::span<const Ray> rays, std::span<Hit> hits, Worker& worker) const {
  for (std::size_t first = 0; first < rays.size(); first += batch_size) {
    worker.rays.count = std::min(batch_size, rays.size() - first);
    for (std::size_t r = 0; r < worker.rays.count; ++r) worker.rays.set(r, rays[first + r]);
    kernel(dataset_, query_, worker.rays, worker.hits, worker.scratch);
    for (std::size_t r = 0; r < worker.rays.count; ++r) hits[first + r] = worker.hits[r];
  }
}

void RayCaster::prepare_first_crossings(Machine machine, unsigned threads, const Watch& watch) const {
  const DefaultFloatingPoint default_floating_point;
  const Intersectors intersectors = intersectors_for(machine);
  if (intersectors.prepare == nullptr) return;
  if (watch.progress) watch.progress("preparing", 0, 0);
  intersectors.prepare(dataset_, query_, threads, watch.stop);
}

void RayCaster::first_crossings(std::span<const Ray> rays, std::span<Hit> hits) {
  const DefaultFloatingPoint default_floating_point;
  RHORAY_CHECK(rays.size() == hits.size());
  if (workers_.size() == 1 || rays.size() <= batch_size) {
    answer(intersectors_.first_hit, rays, hits, workers_.front());
    return formats::require_intact(dataset_.file);
  }
  const std::size_t batch_count = (rays.size() + batch_size - 1) / batch_size;
  TileThreads(threads_).for_each_tile(batch_count, [&](std::size_t batch, std::size_t worker) {
    const std::size_t first = batch * batch_size, count = std::min(batch_size, rays.size() - first);
    answer(intersectors_.first_hit, rays.subspan(first, count), hits.subspan(first, count), workers_[worker]);
  });
  formats::require_intact(dataset_.file);
}

Hit RayCaster::first_crossing(const Ray& ray) {
  Hit hit;
  first_crossings(std::span(&ray, 1), std::span(&hit, 1));
  return hit;
}

void RayCaster::largest_values(std::span<const Ray> rays, std::span<Hit> hits) {
  const DefaultFloatingPoint default_floating_point;
  RHORAY_CHECK(rays.size() == hits.size());
  workers_.front().scratch.last_t.reset();
  answer(intersectors_.largest, rays, hits, workers_.front());
  formats::require_intact(dataset_.file);
}

void RayCaster::first_crossings(std::span<const Ray> rays, std::span<Hit> hits, Scratch& scratch) const {
  const DefaultFloatingPoint default_floating_point;
  RHORAY_CHECK(rays.size() == hits.size());
  const Intersectors intersectors = intersectors_for(scratch.machine_.value_or(machine_));
  scratch.worker_->scratch.queue.reserve(intersectors.queue_entries);
  answer(intersectors.first_hit, rays, hits, *scratch.worker_);
  formats::require_intact(dataset_.file);
}

void RayCaster::largest_values(std::span<const Ray> rays, std::span<Hit> hits, Scratch& scratch) const {
  const DefaultFloatingPoint default_floating_point;
  RHORAY_CHECK(rays.size() == hits.size());
  const Intersectors intersectors = intersectors_for(scratch.machine_.value_or(machine_));
  scratch.worker_->scratch.queue.reserve(intersectors.queue_entries);
  scratch.worker_->scratch.last_t.reset();
  answer(intersectors.largest, rays, hits, *scratch.worker_);
  formats::require_intact(dataset_.file);
}

KernelCounters RayCaster::counters() const {
  KernelCounters sum;
  for (const Worker& worker : workers_) sum += worker.scratch.counters;
  return sum;
}

std::vector<Ray> camera_rays(const Dataset& dataset, const Camera& camera, int width, int height) {
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::iota(pixels.begin(), pixels.end(), 0U);
  return camera_rays(dataset, camera, width, height, pixels);
}

std::vector<Ray> camera_rays(const Dataset& dataset, const Camera& camera, int width, int height,
                             std::span<const std::uint32_t> pixels) {
  const DefaultFloatingPoint default_floating_point;
  const CameraRays through(camera, width, height);
  const Affine data_from_world = dataset.implementation().world_from_data.inverse();
  const auto columns = static_cast<std::uint32_t>(width);
  std::vector<Ray> rays;
  rays.reserve(pixels.size());
  for (const std::uint32_t pixel : pixels) {
    const Ray ray = through.through_pixel(static_cast<int>(pixel % columns), static_cast<int>(pixel / columns));
    rays.push_back({data_from_world.point(ray.origin), data_from_world.vector(ray.direction)});
  }
  return rays;
}

const Affine& world_from_ray_frame(const Dataset& dataset) {
  return dataset.implementation().world_from_data;
}

}  // namespace rhoray::render

#include "render/frame/frame.h"

#include "render/march/ticks.h"

namespace rhoray::render {

void Pass::add(const Frame& frame, const PixelLattice& lattice) {
  if (lattice.columns() <= 0 || lattice.rows() <= 0) return;
  for (const Tile& tile : tiles_in_order(lattice.columns(), lattice.rows())) tiles_.push_back({parts_.size(), tile});
  parts_.push_back({lattice, PixelRays(frame.camera_rays, frame.volume_from_world, lattice)});
}

void Pass::trace_tile(const Frame& frame, std::size_t index, Worker& worker, Framebuffer& out) const {
  const auto& [part_index, tile] = tiles_[index];
  const auto& [lattice, rays] = parts_[part_index];
  const std::uint64_t start = ticks_now();
  if (worker.rays_begun_by != &rays) rays.begin(worker.rays);
  worker.rays_begun_by = &rays;
  rays.fill(tile, worker.rays);
  expect_tile(lattice, tile, out);
  worker.scratch.last_t.reset();
  frame.kernel(frame.volume, frame.question, worker.rays, worker.hits, worker.scratch);
  worker.ray_count += worker.rays.count;

  const std::uint64_t shading_start = ticks_now();
  shade_tile(frame.look, worker);
  write_tile(frame.look, lattice, tile, worker, out);
  const std::uint64_t end = ticks_now();
  worker.shading_ticks += end - shading_start;
  worker.tile_ticks += end - start;
}

void FrameMemory::Implementation::begin_frame(unsigned threads, std::size_t queue_entries) {
  if (!threads_ || threads_->asked_for() != threads) threads_.emplace(threads);
  places_.resize(threads_->worker_count());
  for (Place& place : places_) place.works = false;
  queue_entries_ = queue_entries;
}

Worker& FrameMemory::Implementation::worker(std::size_t index) {
  Place& place = places_[index];
  if (!place.worker) place.worker = std::make_unique<Worker>();
  if (!place.works) place.worker->begin_frame(queue_entries_);
  place.works = true;
  return *place.worker;
}

std::vector<const Worker*> FrameMemory::Implementation::workers() const {
  std::vector<const Worker*> working;
  for (const Place& place : places_)
    if (place.works) working.push_back(place.worker.get());
  return working;
}

}  // namespace rhoray::render

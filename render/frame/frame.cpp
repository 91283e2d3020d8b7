#include "render/frame/frame.h"

#include "render/frame/block_mask.h"
#include "render/march/ticks.h"

namespace rhoray::render {

namespace {

/// Nothing where every ray is to be asked about.
std::optional<BlockMask> mask_of(const Frame& frame, const PixelLattice& lattice) {
  if (!frame.boxes) return std::nullopt;
  const VolumeImplementation& volume = frame.volume;
  const BoxProjection projection(frame.camera_rays, frame.volume_from_world, volume.world_from_volume,
                                 volume.bounds_volume);
  if (!projection.is_certain()) return std::nullopt;
  return blocks_that_may_meet(*frame.boxes, projection, lattice);
}

}  // namespace

void Pass::add(const Frame& frame, const PixelLattice& lattice) {
  if (lattice.columns() <= 0 || lattice.rows() <= 0) return;
  const std::optional<BlockMask> mask = mask_of(frame, lattice);
  for (Tile tile : tiles_in_order(lattice.columns(), lattice.rows())) {
    if (mask) tile.blocks = mask->of_tile(tile);
    tiles_.push_back({parts_.size(), tile});
  }
  parts_.push_back({lattice, PixelRays(frame.camera_rays, frame.volume_from_world, lattice)});
}

void Pass::trace_tile(const Frame& frame, std::size_t index, Worker& worker, Framebuffer& out) const {
  const auto& [part_index, tile] = tiles_[index];
  const Part& part = parts_[part_index];
  const std::uint64_t start = ticks_now();
  write_background(frame.look, part.lattice, tile, out);
  worker.shading_ticks += ticks_now() - start;
  worker.rays.count = 0;
  if (tile.blocks != 0) trace_blocks(frame, part, tile, worker, out);
  worker.ray_count += tile.count();
  worker.rays_ruled_out += tile.count() - worker.rays.count;
  worker.tile_ticks += ticks_now() - start;
}

void Pass::trace_blocks(const Frame& frame, const Part& part, const Tile& tile, Worker& worker, Framebuffer& out) {
  const auto& [lattice, rays] = part;
  if (worker.rays_begun_by != &rays) rays.begin(worker.rays);
  worker.rays_begun_by = &rays;
  rays.fill(tile, worker.rays);
  expect_tile(lattice, tile, out);
  worker.scratch.last_t.reset();
  frame.kernel(frame.volume, frame.question, worker.rays, worker.hits, worker.scratch);

  const std::uint64_t shading_start = ticks_now();
  shade_tile(frame.look, worker);
  write_tile(frame.look, lattice, tile, worker, out);
  worker.shading_ticks += ticks_now() - shading_start;
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

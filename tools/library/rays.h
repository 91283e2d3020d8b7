#pragma once

#include <cmath>
#include <string_view>
#include <vector>

#include "formats/base/stopping.h"
#include "render/ray_caster.h"
#include "rhoray/rays.h"
#include "tools/library/arrays.h"
#include "tools/library/context.h"

namespace rhoray::v0_1 {

class RayScratch::Implementation {
 public:
  explicit Implementation(render::Machine machine) : caster(machine) {}

  render::RayCaster::Scratch caster;
  std::vector<render::Ray> rays;
  std::vector<render::Hit> hits;
};

namespace inside {

/// Rays that a thread takes at a time.
inline constexpr std::int64_t batch_size = 1024;

/// The caller's rays, checked, in the frame of the data.
class CheckedRays {
 public:
  /// Refuses arrays of wrong shapes, rays that are not finite or have no direction, and rays that
  /// are out of range in the frame of the data (rhoray::Rays).
  CheckedRays(const Rays& rays, const render::Dataset& dataset);

  std::int64_t count() const { return count_; }
  render::Ray operator[](std::int64_t ray) const;

 private:
  const Rays& rays_;
  rhoray::Affine data_from_world_;
  std::int64_t count_;
};

/// Calls act(first, count, scratch) for batches of rays, on the calling thread. Throws
/// ErrorCode::interrupted if stopped.
template <class Act>
void for_each_batch(std::int64_t count, RayScratch& scratch, const rhoray::Watch& watch, const Act& act) {
  ProgressMeter meter(watch.progress, "tracing (rays)", static_cast<std::uint64_t>(count));
  for (std::int64_t first = 0; first < count; first += batch_size) {
    end_if_stopped(watch.stop);
    const std::int64_t size = std::min(batch_size, count - first);
    act(first, size, scratch.implementation());
    meter.add(static_cast<std::uint64_t>(size));
  }
}

/// The same on the threads of a context.
template <class Act>
void for_each_batch(std::int64_t count, RenderContext::Implementation& context, render::RenderContext& threads,
                    const rhoray::Watch& watch, const Act& act) {
  std::vector<RayScratch> scratch;
  for (std::size_t worker = threads.worker_count(context.threads()); worker > 0; --worker)
    scratch.emplace_back(static_cast<Machine>(context.machine()));
  ProgressMeter meter(watch.progress, "tracing (rays)", static_cast<std::uint64_t>(count));
  threads.for_each(static_cast<std::size_t>((count + batch_size - 1) / batch_size), context.threads(),
                   [&](std::size_t batch, std::size_t worker) {
                     if (watch.stop.stop_requested()) return;
                     const std::int64_t first = static_cast<std::int64_t>(batch) * batch_size;
                     const std::int64_t size = std::min(batch_size, count - first);
                     act(first, size, scratch[worker].implementation());
                     meter.add(static_cast<std::uint64_t>(size));
                   });
  end_if_stopped(watch.stop);
}

/// Refuses spans of wrong lengths, and `error` if the method proves none.
void check(const Hits& hits, std::int64_t count, bool proves_errors);

/// Writes a batch of hits.
/// @param has_gradient  false: they are largest values
void write(std::span<const render::Hit> from, std::int64_t first, const rhoray::Affine& world_from_data,
           bool has_gradient, bool has_value, const Hits& hits);

}  // namespace inside

}  // namespace rhoray::v0_1

#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "formats/base/interval.h"
#include "render/dataset/loaded_dataset.h"
#include "render/method.h"
#include "render/query/batch.h"
#include "render/traverse/maximum_queue.h"

namespace rhoray::render {

struct KernelCounters {
  std::uint64_t macrocells_visited = 0;
  std::uint64_t cells_visited = 0;
  std::uint64_t cells_solved = 0;
  std::uint64_t samples_taken = 0;  ///< by the sampled methods
  std::uint64_t rays_redone = 0;    ///< certified: rays that single precision could not decide
  std::uint64_t rays_exact = 0;     ///< rays decided by exact arithmetic
  /// Exactly decided hits at which the field only touches the isovalue.
  std::uint64_t touches = 0;
  /// Rays answered by a SIMD kernel, which may leave rays or a whole frame to others.
  std::uint64_t rays_wide = 0;
  std::uint64_t intersection_ticks = 0;  ///< time spent solving; 0 unless RayQuery::time_phases

  std::uint64_t visits() const { return macrocells_visited + cells_visited; }

  KernelCounters& operator+=(const KernelCounters& other) {
    macrocells_visited += other.macrocells_visited;
    cells_visited += other.cells_visited;
    cells_solved += other.cells_solved;
    samples_taken += other.samples_taken;
    rays_redone += other.rays_redone;
    rays_exact += other.rays_exact;
    touches += other.touches;
    rays_wide += other.rays_wide;
    intersection_ticks += other.intersection_ticks;
    return *this;
  }
};

/// The query for every ray of a frame.
struct RayQuery {
  double isovalue = 0;
  /// Of the field shown; used only by certified largest values.
  Interval<double> field_range{0, 0};
  Method method{};
  bool use_hierarchy = true;
  bool use_last_t = true;
  bool time_phases = false;
};

/// Memory that a thread keeps between calls of a kernel. Only the kernel knows its type, and makes
/// it at its first call: on the thread that uses it, and only where it is used.
class Scratch {
 public:
  /// The memory of type T; made anew where the last kernel used another type.
  template <class T>
  T& as() {
    if (type_ != &type_of<T>) {
      memory_ = Memory(new T(), [](void* memory) { delete static_cast<T*>(memory); });
      type_ = &type_of<T>;
    }
    return *static_cast<T*>(memory_.get());
  }

 private:
  using Memory = std::unique_ptr<void, void (*)(void*)>;
  /// Its address stands for the type.
  template <class T>
  static constexpr char type_of = 0;

  const char* type_ = nullptr;
  Memory memory_{nullptr, [](void*) {}};
};

/// What a thread keeps from ray to ray.
struct KernelScratch {
  MaximumQueue queue;  ///< of the scalar search for the largest value
  /// Where the last largest value was found. Reset at the start of every tile, so that counts do
  /// not depend on threads.
  std::optional<double> last_t;
  KernelCounters counters;
  Scratch for_hits;  ///< of SIMD kernels for the first hit or any hit
  Scratch for_largest;
};

/// Answers a query for a batch of rays in the data's frame. `hits` must have room for as many
/// entries.
using Kernel = void (*)(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                        KernelScratch& scratch);

/// The reference kernels of one view: scalar, one ray at a time.
struct ReferenceKernels {
  Kernel first_hit, largest;
  std::size_t queue_entries;  ///< the most entries that one ray can put into the queue
};

/// Defined for every alternative of LoadedDataset::view.
template <class View>
ReferenceKernels reference_kernels(const View& view, Method::Algorithm algorithm);

}  // namespace rhoray::render

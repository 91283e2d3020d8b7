#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "render/march/maximum_queue.h"
#include "render/march/ray.h"
#include "render/scene.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

/// The answer for one ray.
struct Hit {
  double t = std::numeric_limits<double>::infinity();  ///< infinity: nothing was hit
  double value = 0;                                    ///< of the field there
  std::uint64_t cell = 0;                              ///< id of the cell
  Vec3 gradient{0, 0, 0};                              ///< of the field there, volume frame; only for first_crossing

  bool is_miss() const { return t == std::numeric_limits<double>::infinity(); }
};

struct KernelCounters {
  std::uint64_t macrocells_visited = 0;
  std::uint64_t cells_visited = 0;
  std::uint64_t cells_solved = 0;
  std::uint64_t intersection_ticks = 0;  ///< time spent solving; 0 in kernels that are not timed

  KernelCounters& operator+=(const KernelCounters& other) {
    macrocells_visited += other.macrocells_visited;
    cells_visited += other.cells_visited;
    cells_solved += other.cells_solved;
    intersection_ticks += other.intersection_ticks;
    return *this;
  }
};

/// What is asked of every ray of a frame.
struct Question {
  double isovalue = 0;
  bool use_hierarchy = true;
  bool use_last_t = true;
};

/// What a thread keeps from ray to ray: memory for the queue, and where the last largest value was found.
struct KernelScratch {
  MaximumQueue queue;
  std::optional<double> last_t;  ///< forgotten at the start of every tile, so that counts do not depend on threads
  KernelCounters counters;
};

/// A question, answered for a batch of rays in the volume's frame; hits has one entry per ray.
using Kernel = void (*)(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                        std::span<Hit> hits, KernelScratch& scratch);

/// The questions that a frame may ask of a volume (paper, section 4), each as the kernel for its kind, value type and
/// machine. Chosen once per frame.
struct Kernels {
  Kernel first_crossing;      ///< where the ray first passes from one side of the isovalue to the other
  Kernel largest_value;       ///< the largest value on the ray and the smallest t where it is reached
  std::size_t queue_entries;  ///< the most that one ray can put into the queue
};

/// @param timed  kernels that also measure the time spent in intersection
Kernels choose_kernels(const VolumeImplementation& volume, MipMethod method, bool timed);

/// Kernels of one view; defined for every alternative of VolumeImplementation::view.
template <class View>
Kernels kernels_for(const View& view, MipMethod method, bool timed);

}  // namespace rhoray::render

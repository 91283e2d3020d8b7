#pragma once

#include "render/kernels/kernels.h"
#include "render/load.h"

/// The kernels' questions for rays of any kind, for tools that measure what a method is worth.
namespace rhoray::render {

/// One question, answered for batches of rays in the volume's own frame: in a grid that of its sample positions, in a
/// mesh that of its points relative to the mesh's origin. For one thread. The volume must outlive it.
class RayQuestions {
 public:
  RayQuestions(const Volume& volume, double isovalue, const Method& method)
      : volume_(volume.implementation()),
        question_{.isovalue = isovalue, .field_range = volume.field().range, .method = method},
        kernels_(choose_kernels(volume_, method)) {
    scratch_.queue.reserve(kernels_.queue_entries);
  }

  /// One hit for each ray; a crossing's t is in lengths of its ray's direction.
  void first_crossings(std::span<const Ray> rays, std::span<Hit> hits) {
    ask(kernels_.first_crossing, volume_, question_, rays, hits, scratch_);
  }
  Hit first_crossing(const Ray& ray) {
    Hit hit;
    first_crossings(std::span(&ray, 1), std::span(&hit, 1));
    return hit;
  }

  void largest_values(std::span<const Ray> rays, std::span<Hit> hits) {
    scratch_.last_t.reset();
    ask(kernels_.largest_value, volume_, question_, rays, hits, scratch_);
  }

  /// Of all rays so far.
  const KernelCounters& counters() const { return scratch_.counters; }

 private:
  const VolumeImplementation& volume_;
  Question question_;
  Kernels kernels_;
  KernelScratch scratch_;
};

/// Out of the frame that these rays are in.
inline const Affine& world_from_ray_frame(const Volume& volume) {
  return volume.implementation().world_from_volume;
}

}  // namespace rhoray::render

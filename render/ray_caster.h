#pragma once

#include <span>
#include <vector>

#include "formats/base/affine.h"
#include "render/camera.h"
#include "render/load.h"
#include "render/method.h"
#include "render/query/kernels.h"

/// The kernels' questions for rays of any kind, for tools and tests that measure what a method is worth.
namespace rhoray::render {

/// One question about a volume and a way of answering it. Rays are in the volume's own frame: in a grid that of its
/// sample positions (0, 1, 2, ... or the axis tables'), in a mesh that of its points relative to the mesh's origin.
/// These doubles are what the kernels compute with; nothing is rounded on the way. To be asked by one thread at a time;
/// the volume must outlive it.
class RayCaster {
 public:
  /// Refuses an isovalue that is not finite (ErrorCode::usage), and a method that proves for data of which the stored
  /// ranges do not hold (Volume::prove_ranges, ErrorCode::invalid).
  /// @param threads  that answer crossings; 0 = all cores
  RayCaster(const Volume& volume, double isovalue, const Method& method, unsigned threads = 1);
  ~RayCaster();

  /// hits[i] is for rays[i], the same for any number of threads, and what `render` would say of that ray; t is in
  /// lengths of its direction.
  void first_crossings(std::span<const Ray> rays, std::span<Hit> hits);
  Hit first_crossing(const Ray& ray);

  void largest_values(std::span<const Ray> rays, std::span<Hit> hits);

  /// Of all rays so far.
  KernelCounters counters() const;

  /// What this asked before anything was answered.
  const RangeProof& range_proof() const { return range_proof_; }

 private:
  /// What a thread works with.
  struct Worker;

  void answer(Kernel kernel, std::span<const Ray> rays, std::span<Hit> hits, Worker& worker) const;

  const VolumeImplementation& volume_;
  RayQuery query_;
  Kernels kernels_;
  unsigned threads_;
  std::vector<Worker> workers_;
  RangeProof range_proof_;
};

/// The rays that `render` sends through the middles of the pixels, rows from the top; t is a distance in world units.
std::vector<Ray> camera_rays(const Volume& volume, const Camera& camera, int width, int height);

/// Out of the frame that these rays are in.
const Affine& world_from_ray_frame(const Volume& volume);

}  // namespace rhoray::render

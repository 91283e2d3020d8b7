#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/affine.h"
#include "formats/base/progress.h"
#include "render/camera.h"
#include "render/load.h"
#include "render/method.h"
#include "render/query/intersectors.h"

/// The kernels' queries for arbitrary rays, for tools and tests that measure how accurate a method
/// is.
namespace rhoray::render {

/// One query about a dataset and a method that answers it. Rays are in the data's own frame. In a
/// grid that is the frame of its sample positions (0, 1, 2, ... or those of the axis tables); in a
/// mesh, that of its points relative to the mesh's origin. The kernels compute with these doubles
/// without rounding them first. Only one thread may call at a time, except for const functions. The
/// dataset must outlive it.
class RayCaster {
  /// The state of one thread.
  struct Worker;

 public:
  /// Memory of a thread that calls const functions. One may serve several casters.
  class Scratch {
   public:
    /// @param machine  whose kernels answer; none: that of the caster
    explicit Scratch(std::optional<Machine> machine = {});
    ~Scratch();
    Scratch(Scratch&&) noexcept;
    Scratch& operator=(Scratch&&) noexcept;

   private:
    friend class RayCaster;
    std::unique_ptr<Worker> worker_;
    std::optional<Machine> machine_;
  };

  /// Refuses an isovalue that is not finite (ErrorCode::usage). For a method that proves its
  /// results it also refuses data whose stored ranges do not hold (Dataset::prove_ranges,
  /// ErrorCode::invalid).
  /// @param threads  that trace crossings; 0 = all cores
  /// @param machine  whose kernels answer; none: chosen_machine()
  RayCaster(const Dataset& dataset, double isovalue, const Method& method, unsigned threads = 1,
            std::optional<Machine> machine = {}, const Watch& watch = {});
  ~RayCaster();

  /// Prepares what first crossings need: facets, or occupied blocks. Otherwise the first ray does,
  /// on its own thread.
  /// @param machine  whose kernels will answer
  /// @param threads  0 = all cores
  /// @param watch    a stop request ends it, and the next call repeats it
  void prepare_first_crossings(Machine machine, unsigned threads, const Watch& watch) const;

  /// hits[i] belongs to rays[i]. It is the same for any number of threads, and what `render` would
  /// find for that ray. t is in lengths of the ray's direction.
  void first_crossings(std::span<const Ray> rays, std::span<Hit> hits);
  Hit first_crossing(const Ray& ray);

  void largest_values(std::span<const Ray> rays, std::span<Hit> hits);

  // The same on the calling thread only. Any number of threads may call at a time, each with a
  // scratch of its own. `counters` does not count these rays.
  void first_crossings(std::span<const Ray> rays, std::span<Hit> hits, Scratch& scratch) const;
  void largest_values(std::span<const Ray> rays, std::span<Hit> hits, Scratch& scratch) const;

  /// Counters of all rays so far.
  KernelCounters counters() const;

  /// The proof that the constructor made before any ray was traced.
  const RangeProof& range_proof() const { return range_proof_; }

 private:
  Intersectors intersectors_for(Machine machine) const;
  void answer(Kernel kernel, std::span<const Ray> rays, std::span<Hit> hits, Worker& worker) const;

  const LoadedDataset& dataset_;
  RayQuery query_;
  Machine machine_;
  Intersectors intersectors_;
  unsigned threads_;
  std::vector<Worker> workers_;
  RangeProof range_proof_;
};

/// Returns the rays that `render` sends through the pixel centres, rows from the top; t is a
/// distance in world units.
std::vector<Ray> camera_rays(const Dataset& dataset, const Camera& camera, int width, int height);

/// The same for some pixels, by their indices in the picture.
std::vector<Ray> camera_rays(const Dataset& dataset, const Camera& camera, int width, int height,
                             std::span<const std::uint32_t> pixels);

/// Maps from the frame of these rays to world space.
const Affine& world_from_ray_frame(const Dataset& dataset);

}  // namespace rhoray::render

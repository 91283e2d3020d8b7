#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "formats/base/interval.h"
#include "render/dataset/volume.h"
#include "render/method.h"
#include "render/query/batch.h"
#include "render/query/machine.h"
#include "render/traverse/maximum_queue.h"

namespace rhoray::render {

namespace wide {
struct FacetScratch;
struct IsosurfaceScratch;
struct MaximumScratch;
struct TetMaximumScratch;
}  // namespace wide

struct KernelCounters {
  std::uint64_t macrocells_visited = 0;
  std::uint64_t cells_visited = 0;
  std::uint64_t cells_solved = 0;
  std::uint64_t samples_taken = 0;       ///< by the sampled methods
  std::uint64_t rays_redone = 0;         ///< certified: what single precision could not decide
  std::uint64_t rays_exact = 0;          ///< decided by the judge
  std::uint64_t touches = 0;             ///< judged hits at which the field only touches the isovalue
  std::uint64_t rays_wide = 0;           ///< answered by a wide kernel, which may leave rays or a whole frame to others
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

/// What is asked of every ray of a frame.
struct RayQuery {
  double isovalue = 0;
  Interval<double> field_range{0, 0};  ///< of the field shown; only certified largest values ask for it
  Method method{};
  bool use_hierarchy = true;
  bool use_last_t = true;
  bool time_phases = false;
};

/// What a thread keeps from ray to ray: memory for the queue, and where the last largest value was found.
struct KernelScratch {
  MaximumQueue queue;
  std::optional<double> last_t;  ///< forgotten at the start of every tile, so that counts do not depend on threads
  KernelCounters counters;
  std::shared_ptr<wide::IsosurfaceScratch> isosurface;   ///< of the wide isosurface kernel, made when first asked
  std::shared_ptr<wide::MaximumScratch> maximum;         ///< of the wide kernel for largest values, likewise
  std::shared_ptr<wide::FacetScratch> facets;            ///< of the wide isosurface kernel of meshes, likewise
  std::shared_ptr<wide::TetMaximumScratch> tet_maximum;  ///< of the wide kernel for largest values in meshes, likewise
};

/// A question, answered for a batch of rays in the volume's frame; hits has room for as many.
using Kernel = void (*)(const VolumeImplementation& volume, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                        KernelScratch& scratch);

/// The same for rays that lie one by one; for few of them.
void ask(Kernel kernel, const VolumeImplementation& volume, const RayQuery& query, std::span<const Ray> rays,
         std::span<Hit> hits, KernelScratch& scratch);

/// Makes ready what a kernel keeps of a volume for its question, by so many threads (0: all cores).
/// @return  boxes outside of which no ray is answered; none where another kernel is left to answer
using Preparation = std::optional<SurfaceBoxes> (*)(const VolumeImplementation& volume, const RayQuery& query,
                                                    unsigned threads);

/// The questions that a frame may ask of a volume (paper, section 4), each as the kernel for its kind, value type,
/// method and machine. Chosen once per frame.
struct Kernels {
  Kernel first_crossing;      ///< where the ray first passes from one side of the isovalue to the other
  Kernel largest_value;       ///< the largest value on the ray and the smallest t where it is reached
  std::size_t queue_entries;  ///< the most that one ray can put into the queue
  Preparation prepare_first_crossing = nullptr;  ///< null: nothing to prepare. A kernel that finds it undone does it
};

/// True where a wide kernel finds first crossings in single precision, on every machine that is not `scalar`.
bool finds_crossings_wide(const VolumeImplementation& volume);

/// True where rays that pass the volume's bounds by are answered by a miss. Methods that find a tetrahedron by its
/// barycentric coordinates promise nothing of flat ones.
bool keeps_to_bounds(const VolumeImplementation& volume, const Method& method);

Kernels choose_kernels(const VolumeImplementation& volume, const Method& method, Machine machine = chosen_machine());

/// The reference kernels of one view, one ray at a time; defined for every alternative of VolumeImplementation::view.
template <class View>
Kernels kernels_for(const View& view, Method::Algorithm algorithm);

/// Of a mesh's certified first crossings: what single precision has not decided, by double precision or the judge.
/// Grids: resumed.h.
template <class View>
Kernel redoing_kernel_for(const View& view);

}  // namespace rhoray::render

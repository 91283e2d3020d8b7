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

/// What a thread keeps from ray to ray: memory for the queue, and where the last largest value was
/// found.
struct KernelScratch {
  MaximumQueue queue;
  /// Reset at the start of every tile, so that counts do not depend on threads.
  std::optional<double> last_t;
  KernelCounters counters;
  /// Of the SIMD isosurface kernel, created on first use.
  std::shared_ptr<wide::IsosurfaceScratch> isosurface;
  /// Of the SIMD kernel for largest values, created on first use.
  std::shared_ptr<wide::MaximumScratch> maximum;
  /// Of the SIMD isosurface kernel of meshes, created on first use.
  std::shared_ptr<wide::FacetScratch> facets;
  /// Of the SIMD kernel for largest values in meshes, created on first use.
  std::shared_ptr<wide::TetMaximumScratch> tet_maximum;
};

/// Answers a query for a batch of rays in the volume's frame. `hits` must have room for as many
/// entries.
using Kernel = void (*)(const VolumeImplementation& volume, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                        KernelScratch& scratch);

/// The same for an array of single rays; meant for few of them.
void ask(Kernel kernel, const VolumeImplementation& volume, const RayQuery& query, std::span<const Ray> rays,
         std::span<Hit> hits, KernelScratch& scratch);

/// Prepares what a kernel keeps of a volume for its query, with this many threads (0: all cores).
/// @return  boxes outside of which no ray has a hit; nothing where another kernel answers instead
using Preparation = std::optional<SurfaceBoxes> (*)(const VolumeImplementation& volume, const RayQuery& query,
                                                    unsigned threads);

/// The queries that a frame may make of a volume (paper, section 4). Each is the kernel for the
/// volume's kind, value type, method and machine. Chosen once per frame.
struct Kernels {
  /// Where the ray first passes from one side of the isovalue to the other.
  Kernel first_crossing;
  /// The largest value on the ray and the smallest t where it is reached.
  Kernel largest_value;
  std::size_t queue_entries;  ///< the most entries that one ray can put into the queue
  /// Null: nothing to prepare. A kernel that finds this not yet done does it itself.
  Preparation prepare_first_crossing = nullptr;
};

/// True where a SIMD kernel finds first crossings in single precision, on every machine other than
/// `scalar`.
bool finds_crossings_wide(const VolumeImplementation& volume);

/// True where every ray that passes outside the volume's bounds is a miss. Methods that find a
/// tetrahedron by its barycentric coordinates promise nothing for flat tetrahedra.
bool keeps_to_bounds(const VolumeImplementation& volume, const Method& method);

Kernels choose_kernels(const VolumeImplementation& volume, const Method& method, Machine machine = chosen_machine());

/// The reference kernels of one view, one ray at a time; defined for every alternative of
/// VolumeImplementation::view.
template <class View>
Kernels kernels_for(const View& view, Method::Algorithm algorithm);

/// For a mesh's certified first crossings: decides what single precision left undecided, in double
/// precision or by exact arithmetic. For grids see render/grid/reference/resumed.h.
template <class View>
Kernel redoing_kernel_for(const View& view);

}  // namespace rhoray::render

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>

#include "render/query/all_hits.h"
#include "render/query/kernels.h"
#include "render/query/machine.h"

namespace rhoray::render {

namespace wide {
struct Occluders;
struct OccluderSearch;
}  // namespace wide

/// Whether there is any crossing. Sets one bit for each ray of each group of the batch; rays with
/// t_max < t_min keep a clear bit.
/// @param occluders  null: the whole surface is tested; else all rays have their start side and go
///   to their light
using AnyHitKernel = void (*)(const LoadedDataset& dataset, const RayQuery& query, const wide::Occluders* occluders,
                              const RayBatch& rays, std::uint64_t* crossed, KernelScratch& scratch);

/// Prepares what a kernel keeps of a dataset for its query, with this many threads (0: all cores).
/// A stop request may end it (ErrorCode::interrupted); then nothing is kept.
/// @return  boxes outside of which no ray has a hit; nothing where another kernel answers instead
using Preparation = std::optional<SurfaceBoxes> (*)(const LoadedDataset& dataset, const RayQuery& query,
                                                    unsigned threads, const std::stop_token& stop);

/// How one dataset answers rays (paper, section 4): the kernels for its kind of data, its type of
/// values, a method and a machine. Chosen once per frame. Each kernel makes its own scratch memory,
/// so a caller holds a KernelScratch for datasets of any kind.
struct Intersectors {
  /// Where the ray first passes from one side of the isovalue to the other.
  Kernel first_hit;
  /// The largest value on the ray and the smallest t where it is reached.
  Kernel largest;
  AnyHitKernel any_hit = nullptr;  ///< null: use first_hit
  /// Null: a new ray must be traced behind each hit. Depends on the query's isovalue too, because a
  /// frame composites its transparent surfaces either in one pass or one by one.
  AllHitsKernel all_hits = nullptr;
  /// For first_hit. Null: nothing to prepare. A kernel that finds this not yet done does it itself.
  Preparation prepare = nullptr;
  const wide::OccluderSearch* occluders = nullptr;  ///< null: none are known
  std::size_t queue_entries = 0;                    ///< the most that one ray can put into KernelScratch::queue
  /// Every ray that passes outside the dataset's bounds is a miss.
  bool keeps_to_bounds = false;
};

/// The intersectors of any kind of data.
Intersectors choose_intersectors(const LoadedDataset& dataset, const RayQuery& query,
                                 Machine machine = chosen_machine());

/// True where SIMD kernels answer such queries on a machine.
/// @param kernel  which query: first_hit or largest
bool answers_wide(const LoadedDataset& dataset, const Method& method, Kernel Intersectors::*kernel, Machine machine);

}  // namespace rhoray::render

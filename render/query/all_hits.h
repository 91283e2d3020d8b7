#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "render/query/kernels.h"

/// All crossings of rays with a few surfaces of one dataset, in order along the ray, found by one
/// walk along each ray. Without this, each transparent surface that a ray crosses would need
/// another query behind it.
namespace rhoray::render {

/// A surface of a query for all crossings.
struct TransparentSurface {
  double isovalue = 0;
  float passing = 1;  ///< share of the light that each of its crossings lets through
};

/// The crossings of a batch's rays with one surface.
class CrossingList {
 public:
  static constexpr std::size_t most =
      12;  ///< per ray; chosen for surfaces of opacity 0.5, 11 of which hide what lies behind

  /// Allocates room for `capacity` rays, rounded up to whole groups.
  explicit CrossingList(std::size_t capacity) : count(RayBatch::whole_groups(capacity)) {
    for (HitBatch& hits : behind_) hits = HitBatch(capacity);
  }

  /// Sets where the first crossings, or misses, are written; the list itself keeps those behind
  /// them.
  void put_first_into(HitBatch& first) { first_ = &first; }

  /// The k-th crossings of all rays. Rays with fewer crossings keep their previous entry.
  HitBatch& hits(std::size_t k) { return k == 0 ? *first_ : behind_[k - 1]; }
  const HitBatch& hits(std::size_t k) const { return k == 0 ? *first_ : behind_[k - 1]; }

  LaneArray<std::uint8_t> count;  ///< number of recorded crossings per ray

 private:
  HitBatch* first_ = nullptr;
  std::array<HitBatch, most - 1> behind_;
};

/// The query for every ray of a batch. The crossings recorded, of each surface and of all together,
/// are those that repeated queries for first crossings, each started behind the last, would find.
struct AllHitsQuery {
  static constexpr std::size_t most_surfaces = 2;

  std::span<const TransparentSurface> surfaces;
  float least_light = 0;  ///< a ray may end where the crossings so far pass less light than this
  bool time_phases = false;
  /// Of a crossing only t and gradient are needed; the rest of a hit may keep its old value.
  bool only_places = false;
};

/// Records the crossings of rays given in the data's frame. The start side of these rays is
/// unknown.
/// @param lists     one for each surface
/// @param complete  for each ray: 1, or 0 where crossings behind the last of a full list may be
///                  missing, or where the ray must be traced by other kernels; the crossings
///                  recorded for it are right in any case
using AllHitsKernel = void (*)(const LoadedDataset& dataset, const AllHitsQuery& query, const RayBatch& rays,
                               std::span<CrossingList* const> lists, std::uint8_t* complete, Scratch& scratch,
                               KernelCounters& counters);

}  // namespace rhoray::render

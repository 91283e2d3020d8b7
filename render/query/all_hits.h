#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "render/query/kernels.h"

/// All crossings of rays with a few surfaces of one volume, in their order, by one walk along each ray: what lies
/// behind clear surfaces is not a new question for every crossing.
namespace rhoray::render {

namespace wide {
struct FacetAllHitsScratch;
struct GridAllHitsScratch;
}  // namespace wide

/// A surface that is asked about together with others.
struct TransparentSurface {
  double isovalue = 0;
  float passing = 1;  ///< the share of the light that each of its crossings lets through
};

/// The crossings of a batch's rays with one surface.
class CrossingList {
 public:
  static constexpr std::size_t most =
      12;  ///< of a ray; made for shells of opacity 0.5, of which 11 hide what is behind

  explicit CrossingList(std::size_t capacity) : count(capacity) {
    for (HitBatch& hits : behind_) hits = HitBatch(capacity);
  }

  /// Says where the first crossings go to, or misses; the list itself keeps those behind.
  void put_first_into(HitBatch& first) { first_ = &first; }

  /// The k-th crossings of all rays; of those that have fewer, what was there before.
  HitBatch& hits(std::size_t k) { return k == 0 ? *first_ : behind_[k - 1]; }
  const HitBatch& hits(std::size_t k) const { return k == 0 ? *first_ : behind_[k - 1]; }

  LaneArray<std::uint8_t> count;  ///< of a ray's crossings that are noted

 private:
  HitBatch* first_ = nullptr;
  std::array<HitBatch, most - 1> behind_;
};

/// What is asked of every ray of a batch. Of each surface and of all together there is what a ray that is asked for
/// first crossings would meet again and again behind the last.
struct AllHitsQuery {
  static constexpr std::size_t most_surfaces = 2;

  std::span<const TransparentSurface> surfaces;
  float least_light = 0;  ///< a ray may end where less than this would pass what it has crossed
  bool time_phases = false;
  bool only_places = false;  ///< of crossings t and gradient are asked for, the rest of a hit may stay what it was
};

/// What a thread keeps for it.
struct AllHitsScratch {
  std::shared_ptr<wide::GridAllHitsScratch> shells;
  std::shared_ptr<wide::FacetAllHitsScratch> facets;
};

/// Notes the crossings of rays of a volume's frame of which the start's side is not known.
/// @param lists     one for each surface
/// @param complete  of each ray: 1, or 0 where crossings may be missing behind the last of a list that is full, or
///                  where the ray is one for other kernels; what is noted of it is right in any case
using AllHitsKernel = void (*)(const VolumeImplementation& volume, const AllHitsQuery& query, const RayBatch& rays,
                               std::span<CrossingList* const> lists, std::uint8_t* complete, AllHitsScratch& memory,
                               KernelCounters& counters);

/// Null where there is none: rays are asked about again behind each crossing.
AllHitsKernel all_hits_kernel(const VolumeImplementation& volume, const RayQuery& query,
                              Machine machine = chosen_machine());

}  // namespace rhoray::render

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/lab/closed_scenes.h"

namespace rhoray::study {

/// The methods' answers for some rays of a scene, counted against the truth. Parts add up in any
/// order.
///
/// The truth for a ray is the certified answer, or the exact answer where the ray was decided
/// again. Decided again is every ray
///   - for which double decides otherwise than certified, or finds a position more than 1e-6 cells
///     beyond the certified bound;
///   - that changes side an odd number of times, although it begins and ends outside a closed
///     surface. Behind the certified first change, further changes are searched in double, each
///     from 0.001 cells behind the last. Along such a ray, all changes that certified finds are
///     then compared with the exact ones from the same positions;
///   - of a random sample, whatever the answers.
/// A wrong certified answer stays unnoticed only under three conditions. Double precision, which
/// shares nothing with it but the order of the cells, is wrong in the same way; the number of
/// changes stays even; and the ray is not in the sample. The sample bounds the number of such rays.
///
/// Float is run for one ray in eight, and only counted: its answers make no ray suspicious.
struct RayTally {
  struct OfMethod {
    std::uint64_t rays = 0;
    std::uint64_t missed = 0, extra = 0;
    std::uint64_t elsewhere = 0;  ///< another crossing, or none: more than 0.01 cells away
    double largest_error = 0;     ///< of the others: |t - truth|, cells
    double cpu_s = 0;
  };

  std::uint64_t rays = 0, hits = 0;
  OfMethod single, float64, certified;
  std::uint64_t touches = 0;              ///< hits that only touch by exact arithmetic; not counted
                                          ///< as missed
  std::uint64_t redone = 0;               ///< certified: not decided by single precision
  std::uint64_t judged = 0;               ///< certified: not decided by double precision
  std::uint64_t odd = 0;                  ///< rays that changed side an odd number of times
  std::uint64_t miscounted = 0;           ///< of these, rays whose certified changes are not the
                                          ///< exact ones
  std::uint64_t redecided = 0;            ///< checked by exact arithmetic
  std::uint64_t bound_broken = 0;         ///< certified and exact hits farther apart than their
                                          ///< bounds allow
  double largest_bound = 0;               ///< of certified hits, cells
  std::vector<std::string> complaints{};  ///< some of the rays for which certified was wrong, with
                                          ///< all digits

  void add(const RayTally& other);
};

/// @param sample_every  one ray in so many is decided again, at random
RayTally tally_rays(const ClosedScene& scene, Aim aim, std::uint64_t ray_count, std::uint64_t seed,
                    std::uint64_t sample_every);

}  // namespace rhoray::study

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/lab/closed_scenes.h"

namespace rhoray::study {

/// What some rays of a scene were told by the methods, counted against the truth. Parts add up in any order.
///
/// The truth for a ray is what the certified method says, or the judge where the ray was decided again. Decided again
/// is every ray
///   - for which double decides otherwise than certified, or finds another place by 1e-6 cells beyond the certified
///     bound;
///   - that changes side an odd number of times, though it begins and ends outside a closed surface: behind the
///     certified first change further ones are looked for in double, each from 0.001 cells behind the last. Along such
///     a ray all changes that certified finds are then compared with the judge's from the same places;
///   - of a random sample, whatever was said.
/// So a wrong certified answer goes unnoticed only where double precision, which shares nothing with it but the order
/// of the cells, is wrong in the same way, the changes stay even, and the sample passes the ray by: the sample bounds
/// how many such rays there can be.
///
/// Float is asked for one ray in eight, and only counted: what it says makes no ray suspicious.
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
  std::uint64_t touches = 0;              ///< hits, by the judge, that only touch; not counted as missed
  std::uint64_t redone = 0;               ///< certified: what single precision did not decide
  std::uint64_t judged = 0;               ///< certified: what double precision did not decide
  std::uint64_t odd = 0;                  ///< rays that changed side an odd number of times
  std::uint64_t miscounted = 0;           ///< of these, where the judge's changes are not the certified method's
  std::uint64_t redecided = 0;            ///< by the judge, to check
  std::uint64_t bound_broken = 0;         ///< certified and judge lie farther apart than their bounds allow
  double largest_bound = 0;               ///< of certified hits, cells
  std::vector<std::string> complaints{};  ///< rays for which certified was wrong, with all digits; some of them

  void add(const RayTally& other);
};

/// @param sample_every  one ray in so many is decided again, at random
RayTally tally_rays(const ClosedScene& scene, Aim aim, std::uint64_t ray_count, std::uint64_t seed,
                    std::uint64_t sample_every);

}  // namespace rhoray::study

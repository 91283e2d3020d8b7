#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/hard_cases/watertight_rays.h"

namespace rhoray::tests {

/// Counts how often kernels answer correctly for rays at closed surfaces. An answer is compared with the known facts
/// about the ray and with the exact judge.
///
/// Wide kernels are asked for the first crossing of every ray, by the certified and the default method, and for all its
/// crossings at once, as for pictures with clear surfaces. Some rays are asked of scalar kernels, too, and followed by
/// every method from crossing to crossing, each time from a thousandth of a cell behind the last. The judge decides
/// again
///   - every ray whose first crossing is not that of the certified method;
///   - every ray that changes side an odd number of times where it must be even, or the other way round;
///   - a random sample.
/// Certified answers must keep their bounds. An answer that rounds is right where a field that differs from the given
/// one by less than this rounding has it: between the judge's for a slightly lower and a slightly higher isovalue. So
/// ties alone are excused, where the surface is nearly touched or parts of a ray are shorter than the thousandth of a
/// cell; they are counted.
struct WatertightTally {
  struct OfMethod {
    std::uint64_t rays = 0, hits = 0, crossings = 0;
    std::uint64_t wide = 0;      ///< answers by wide kernels
    std::uint64_t parity = 0;    ///< rays that changed side as often as they cannot, before ties were excused
    std::uint64_t other = 0;     ///< rays whose first crossing is not the certified one, likewise
    std::uint64_t ties = 0;      ///< of both, excused
    std::uint64_t wrong = 0;     ///< decided otherwise by the judge
    std::uint64_t met_past = 0;  ///< hits on rays that go past the surface
  };
  static constexpr std::size_t method_count = 5, wide_count = 2;  ///< the wide ones come first

  std::uint64_t rays = 0;
  std::uint64_t redecided = 0;
  std::array<OfMethod, method_count> of_method{};
  OfMethod all{};  ///< wide kernels that record all crossings of a ray at once; rays with too many are left out
  std::vector<std::string> complaints{};  ///< rays that were answered wrongly, with all digits; some of them

  static const char* name(std::size_t method);
  void add(const WatertightTally& other);
};

/// Asks methods about rays that are aimed in one way. May be called for one scene by many threads at a time.
/// @param count         of rays; a multiple of 256
/// @param is_thorough   asks scalar kernels, too, and follows the rays
/// @param sample_every  one ray in so many is decided again, at random
WatertightTally tally_watertight(const study::ClosedScene& scene, study::Aim aim, std::size_t count, std::uint64_t seed,
                                 bool is_thorough, std::uint64_t sample_every);

}  // namespace rhoray::tests

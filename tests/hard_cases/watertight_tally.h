#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/query/kernels.h"
#include "render/query/machine.h"
#include "tests/hard_cases/watertight_rays.h"

namespace rhoray::tests {

/// Counts how often kernels answer correctly for rays at closed surfaces. Compares each answer with
/// the known facts about the ray and with exact arithmetic.
///
/// Wide kernels find the first crossing of every ray, with the certified and the default method.
/// They also find all crossings of a ray at once, as for pictures with transparent surfaces. For
/// some rays, scalar kernels are used as well, and every method follows the ray from crossing to
/// crossing. Each continuation starts a thousandth of a cell behind the last crossing. Exact
/// arithmetic re-evaluates
///   - every ray whose first crossing is not that of the certified method;
///   - every ray that changes side an odd number of times where it must be even, or vice versa;
///   - a random sample.
/// Certified answers must keep their bounds. An answer with rounding is right if a field that
/// differs from the given one by less than this rounding has it. It must lie between the exact
/// answers for a slightly lower and a slightly higher isovalue. So only ties are excused: the ray
/// nearly touches the surface, or parts of a ray are shorter than the thousandth of a cell. Ties
/// are counted.
struct WatertightTally {
  struct OfMethod {
    std::uint64_t rays = 0, hits = 0, crossings = 0;
    std::uint64_t wide = 0;      ///< answers by wide kernels
    std::uint64_t parity = 0;    ///< rays with a wrong parity of side changes, including ties
    std::uint64_t other = 0;     ///< rays whose first crossing is not the certified one, including
                                 ///< ties
    std::uint64_t ties = 0;      ///< excused rays among `parity` and `other`
    std::uint64_t wrong = 0;     ///< refuted by exact arithmetic
    std::uint64_t met_past = 0;  ///< hits on rays that go past the surface
  };
  static constexpr std::size_t method_count = 5, wide_count = 2;  ///< the wide ones come first

  std::uint64_t rays = 0;
  std::uint64_t redecided = 0;
  std::array<OfMethod, method_count> of_method{};
  /// Wide kernels that record all crossings of a ray at once. Rays that they leave to other kernels
  /// are not counted: those with too many crossings, and those through a vertex of the outline.
  OfMethod all{};
  std::vector<std::string> complaints{};  ///< some of the wrongly answered rays, with all digits

  static const char* name(std::size_t method);
  void add(const WatertightTally& other);
};

/// Runs methods on rays that are aimed in one way. May be called for one scene by many threads at a
/// time.
/// @param count         number of rays, a multiple of 256
/// @param is_thorough   whether to run scalar kernels too, and to follow the rays
/// @param sample_every  re-evaluates one random ray in so many
WatertightTally tally_watertight(const study::ClosedScene& scene, study::Aim aim, std::size_t count, std::uint64_t seed,
                                 bool is_thorough, std::uint64_t sample_every);

/// The crossings of a ray, found in one traversal as for pictures with transparent surfaces.
struct AllCrossings {
  bool is_complete = false;  ///< false: the ray is left to other kernels
  std::vector<double> t{};
};

/// @return  for each ray; empty if this machine has no such kernel for the scene
std::vector<AllCrossings> all_crossings(const study::ClosedScene& scene, std::span<const render::Ray> rays,
                                        render::Machine machine, render::Scratch& scratch);

}  // namespace rhoray::tests

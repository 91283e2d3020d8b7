#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "render/framebuffer.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/scene/resolve.h"

namespace rhoray::tools {

struct SelfCheckOptions {
  std::uint64_t pixels = 0;  ///< of each kind; 0: no check
  std::uint64_t seed = 1;
  std::optional<double> limit;  ///< for 99 % of the pixels, beside what is proven and instead of other promises: cells;
                                ///< of largest values a share of the field's range
};

/// What exact arithmetic found of some pixels of a picture.
struct CheckedPixels {
  std::uint64_t pixels = 0, missed = 0, false_hits = 0;
  std::uint64_t shown = 0;         ///< of these: that show something, or should
  std::uint64_t beyond_limit = 0;  ///< of those: missed, false, or off by more than the limit for 99 % of them
  std::uint64_t beyond_bound = 0;  ///< off by more than the picture says it may be, where it says so
  double kept_by_99 = 0;           ///< as in results.csv: cells; of largest values in the field's unit
  double largest = 0;              ///< of pixels that are neither missed nor false
  double largest_value_error = 0;  ///< in the field's unit
};

struct SelfCheck {
  CheckedPixels random{}, edges{};  ///< of all pixels; of those whose neighbour shows something else, or is far behind
  std::uint64_t seed = 1;
  std::string unit{};    ///< of the errors
  std::string limit{};   ///< what was promised, a sentence; empty where the method promises nothing
  std::string broken{};  ///< which of it does not hold; empty where all does
};

void check(const SelfCheckOptions& options);  ///< refuses a limit that is not above 0 (ErrorCode::usage)

/// The channels that a check looks at.
render::ChannelSet channels_to_check(const ResolvedScene& plan);

/// Refuses scenes of which a pixel does not tell one place or value: triangles, clear surfaces, projections beside
/// others (ErrorCode::usage).
void require_checkable(const ResolvedScene& plan);

/// Traces pixels of a picture again by the exact judge and compares. Depths are compared as the picture holds them, in
/// single precision, whose rounding is no error.
SelfCheck checked(const ResolvedScene& plan, const render::Framebuffer& picture, const SelfCheckOptions& options,
                  unsigned threads);

std::string text_of(const SelfCheck& check);
Json json_of(const SelfCheck& check);

}  // namespace rhoray::tools

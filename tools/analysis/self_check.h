#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "render/document.h"
#include "render/framebuffer.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

struct SelfCheckOptions {
  std::uint64_t pixels = 0;  ///< of each kind; 0: no check
  std::uint64_t seed = 1;
  /// For 99 % of the pixels, in addition to proven bounds and instead of other promises: in cells;
  /// for largest values a share of the field's range.
  std::optional<double> limit;
};

/// Result of checking some pixels of a picture with exact arithmetic.
struct CheckedPixels {
  std::uint64_t pixels = 0, missed = 0, false_hits = 0;
  std::uint64_t shown = 0;  ///< of these: pixels that show something, or should
  /// Of those: missed, false, or off by more than the limit for 99 % of them.
  std::uint64_t beyond_limit = 0;
  /// Off by more than the picture's error channel allows, if it has one.
  std::uint64_t beyond_bound = 0;
  /// As in results.csv: cells; for largest values the field's unit.
  double kept_by_99 = 0;
  double largest = 0;              ///< of pixels that are neither missed nor false
  double largest_value_error = 0;  ///< in the field's unit
};

struct SelfCheck {
  /// Of all pixels; of those whose neighbour shows something else, or is far behind.
  CheckedPixels random{}, edges{};
  std::uint64_t seed = 1;
  std::string unit{};    ///< of the errors
  std::string limit{};   ///< the promise, a sentence; empty if the method promises nothing
  std::string broken{};  ///< the parts of the promise that do not hold; empty if all hold
};

/// Refuses a limit that is not above 0 (ErrorCode::usage).
void check(const SelfCheckOptions& options);

/// The channels that a check reads.
render::ChannelSet channels_to_check(const render::ResolvedScene& plan);

/// Refuses scenes in which a pixel does not define one position or value: triangles, transparent
/// surfaces, projections beside other layers (ErrorCode::usage).
void require_checkable(const render::ResolvedScene& plan);

/// Traces pixels of a picture again in exact arithmetic and compares. Depths are compared as stored
/// in the picture, in single precision; that rounding does not count as an error.
SelfCheck checked(const render::ResolvedScene& plan, const render::Framebuffer& picture,
                  const SelfCheckOptions& options, unsigned threads);

std::string text_of(const SelfCheck& check);
Json json_of(const SelfCheck& check);

}  // namespace rhoray::tools

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "render/document.h"
#include "render/framebuffer.h"

/// How accurate a picture is, and which method is accurate enough. Exact arithmetic decides
/// (truth.h).
namespace rhoray::render {

struct SelfCheckOptions {
  std::uint64_t pixels = 0;  ///< of each kind; 0: no check
  std::uint64_t seed = 1;
  /// For 99 % of the pixels, in addition to proven bounds and instead of other promises: in cells;
  /// for largest values a share of the field's range.
  std::optional<double> limit;
  Watch watch{};
};

/// Result of checking some pixels of a picture with exact arithmetic.
struct CheckedPixels {
  std::uint64_t pixels = 0, missed = 0, false_hits = 0;
  std::uint64_t shown = 0;  ///< of these: pixels that show something, or should
  /// Number of shown pixels that are missed, false, or off by more than the limit.
  std::uint64_t beyond_limit = 0;
  /// Number of pixels whose error exceeds the bound in the picture's error channel, if it has one.
  std::uint64_t beyond_bound = 0;
  /// The error that 99 % of the shown pixels do not exceed: in cells along the ray; for largest
  /// values in the field's unit.
  double kept_by_99 = 0;
  double largest = 0;              ///< largest error of pixels that are neither missed nor false
  double largest_value_error = 0;  ///< in the field's unit
};

struct SelfCheck {
  /// Random pixels of the whole picture, and random pixels at edges: a neighbour shows something
  /// else, or is far behind.
  CheckedPixels random{}, edges{};
  std::uint64_t seed = 1;
  std::string unit{};    ///< of the errors
  std::string limit{};   ///< the promise, a sentence; empty if the method promises nothing
  std::string broken{};  ///< the parts of the promise that do not hold; empty if all hold
};

/// The channels that a check reads.
ChannelSet channels_to_check(const ResolvedScene& resolved);

/// Why pictures of a scene cannot be checked: a pixel does not define one position or value, as for
/// triangles, transparent surfaces, projections beside other layers. Empty if they can.
std::string why_not_checkable(const ResolvedScene& resolved);

/// Traces pixels of a picture again in exact arithmetic and compares. Depths are compared as stored
/// in the picture, in single precision; that rounding does not count as an error.
SelfCheck check_picture(const ResolvedScene& resolved, const Framebuffer& picture, const SelfCheckOptions& options,
                        unsigned threads);

/// Goal that a chosen method must meet.
struct Goal {
  /// Along the ray, in cells, for 99 % of the pixels; for largest values a share of the field's
  /// range.
  std::optional<double> max_error;
  std::optional<double> budget_ms;  ///< for tracing the picture on this machine

  bool is_given() const { return max_error || budget_ms; }
};

/// A method that was tried on a small picture of the scene.
struct Candidate {
  Method method;
  std::string word;
  /// Upper bound for 99 % of the pixels that show or should show something.
  double error = 0;
  double foreseen_ms = 0;  ///< predicted for the whole picture
  /// Meets max_error in 99 % of all pixels, at a confidence of 97.5 %; or by proof.
  bool keeps_error = true;
};

struct Choice {
  Candidate chosen;
  bool meets_goal = true;
  std::string sentence;  ///< what was chosen, and why
  std::vector<Candidate> candidates;
};

/// Tries the available methods on a small picture of one layer, and compares their results with the
/// exact ones. Chooses the cheapest method that meets the error, or the most accurate one that
/// meets the time. If no method meets both, the error has priority. If none meets the time, the
/// fastest is chosen. The sentence says so.
/// @param goal  for this layer, if there are several
Choice choose_method(const ResolvedScene& resolved, std::size_t layer, const Goal& goal, unsigned threads,
                     const Watch& watch = {});

/// Chooses for every isosurface and projection, which share the time. Stores the methods in the
/// scene. Throws if there is none.
std::vector<Choice> choose_methods(ResolvedScene& resolved, const Goal& goal, unsigned threads,
                                   const Watch& watch = {});

}  // namespace rhoray::render

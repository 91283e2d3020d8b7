#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "rhoray/context.h"
#include "rhoray/export.h"
#include "rhoray/picture.h"
#include "rhoray/progress.h"
#include "rhoray/scene.h"

namespace rhoray::RHORAY_ABI {

/// The largest error or time that a method may have. At least one is given; the error has priority.
struct Goal {
  /// Along the ray, in cells, for 99 % of the pixels; for largest values a share of the field's
  /// range.
  std::optional<double> max_error{};
  std::optional<double> budget_ms{};  ///< for tracing the picture on this computer
  /// The instruction set that will trace it, as ContextOptions::machine. Times and the errors of
  /// preview and float32 depend on it.
  std::optional<Machine> machine{};
  unsigned threads = 0;  ///< that will trace it; 0: all cores
};

/// The result of choose_method.
struct MethodChoice {
  Method method;
  double error = 0;         ///< measured, as Goal::max_error
  double predicted_ms = 0;  ///< for the whole picture
  bool meets_goal = true;
  std::string sentence;  ///< what was chosen, and why
};

/// Tries the available methods on a small picture of one layer, an isosurface or a projection, and
/// compares them with exact arithmetic. Returns the cheapest that keeps the error, or the most
/// accurate one within the time. It runs for about a second.
/// Throws ErrorCode::usage for a goal without numbers or out of range, and for another layer;
/// ErrorCode::invalid for data whose stored ranges do not hold; ErrorCode::interrupted if stopped;
/// ErrorCode::unsupported for an instruction set that this processor does not have.
RHORAY_API MethodChoice choose_method(const Scene& scene, std::size_t layer, const Size& size, const Goal& goal,
                                      const Watch& watch = {});

/// Some pixels of a picture, compared with exact arithmetic.
struct CheckedPixels {
  std::uint64_t pixels = 0;
  std::uint64_t shown = 0;         ///< of these: they show something, or should
  std::uint64_t missed = 0;        ///< they should show something and show nothing
  std::uint64_t false_hits = 0;    ///< they show something and should not
  std::uint64_t beyond_bound = 0;  ///< their error exceeds the bound in the channel `error`
  double error_of_99 = 0;          ///< that 99 % of the shown pixels do not exceed, in cells or the field's unit
  double largest_error = 0;
};

/// The result of self_check.
struct SelfCheck {
  CheckedPixels random;  ///< of the whole picture
  CheckedPixels edges;   ///< where a neighbour shows something else
  std::string promise;   ///< of the method, a sentence; empty if it promises nothing
  std::string broken;    ///< the parts of the promise that do not hold; empty if all hold
};

/// How many pixels self_check traces, and which.
struct SelfCheckOptions {
  std::uint64_t pixels = 500;  ///< of each kind, at least 1
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: all cores
  Watch watch{};         ///< a stop request ends the check with ErrorCode::interrupted
};

/// Traces pixels of a picture again in exact arithmetic, which does not depend on the instruction
/// set, and compares them. The picture must be whole and needs the channel `depth`, or `value` for
/// a projection; `error` is compared if it is there. Throws ErrorCode::usage for a picture without
/// them, and for a scene in which a pixel does not define one position: triangles, transparent
/// surfaces, a projection beside other layers. Throws ErrorCode::invalid for data whose stored
/// ranges do not hold, ErrorCode::interrupted if stopped.
RHORAY_API SelfCheck self_check(const Scene& scene, const Picture& picture, const SelfCheckOptions& options = {});

}  // namespace rhoray::RHORAY_ABI

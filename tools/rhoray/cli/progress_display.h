#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "formats/base/progress.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::tools {

/// How far a piece of work has come.
struct Pace {
  std::string what;         ///< the phase, without what is counted
  std::string counted;      ///< "bytes", "cells"; empty when not said
  double share = 0;         ///< done, 0 to 1; 0 when the whole is not known
  double rate_per_s = 0;    ///< of what is counted; 0 while it cannot be told
  double seconds_left = 0;  ///< at that rate; 0 when it cannot be told
};
/// @param phase  of a Progress, perhaps with what is counted in brackets at its end
Pace pace_of(std::string_view phase, std::uint64_t done, std::uint64_t total, double elapsed_s);

/// "writing", "[===   ] 10%", "250.0 MiB/s", "1 min 20 s left": what a bar says, as far as it is
/// known.
std::string bar_text(const Pace& pace);

/// Shows on stderr how far a piece of work has come, in the style of --progress. A bar is wiped
/// away at the end.
class ProgressDisplay {
 public:
  explicit ProgressDisplay(const CommonOptions& common);
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;
  ~ProgressDisplay();

  void show(std::string_view phase, std::uint64_t done = 0, std::uint64_t total = 0);
  void clear();  ///< wipes a bar away, so that messages can follow

  /// The same as what the verbs call. Valid as long as this display.
  Progress progress();

 private:
  enum class Style { none, bar, plain, json };
  bool is_due(std::string_view phase, bool finished);

  Style style_ = Style::none;
  std::string phase_;
  bool bar_is_shown_ = false;
  std::chrono::steady_clock::time_point last_shown_, phase_begin_;
};

}  // namespace rhoray::tools

#pragma once

#include <chrono>
#include <string>

#include "preprocess/progress.h"
#include "tools/rhoray/common_options.h"

namespace rhoray::tools {

/// Shows on stderr how far a piece of work has come, in the style of --progress. A bar is wiped away at the end.
class ProgressDisplay {
 public:
  explicit ProgressDisplay(const CommonOptions& common);
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;
  ~ProgressDisplay();

  void show(std::string_view phase, std::uint64_t done = 0, std::uint64_t total = 0);
  void clear();  ///< wipes a bar away, so that messages can follow

  /// The same as what the verbs call. Valid as long as this display.
  preprocess::Progress progress();

 private:
  enum class Style { none, bar, plain, json };
  bool is_due(std::string_view phase, bool finished);

  Style style_ = Style::none;
  std::string phase_;
  bool bar_is_shown_ = false;
  std::chrono::steady_clock::time_point last_shown_;
};

}  // namespace rhoray::tools

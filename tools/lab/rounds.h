#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/rhoray/cpu_meter.h"
#include "tools/rhoray/measure.h"

namespace rhoray::study {

/// One thing to be timed, and what it took each time.
struct TimedRow {
  std::string name;
  std::function<void()> act;
  std::vector<tools::Cost> costs{};
  std::vector<double> cycles{};  ///< of each: counted, or CPU time times the frequency measured in that round

  tools::Spread cpu_ms() const;
  double median_cycles() const;
  /// Median of the instructions counted, or nothing.
  std::optional<double> median_instructions() const;
};

struct RoundsOptions {
  int rounds = 5;
  double row_seconds = 8;  ///< a row that has taken this much CPU time is not timed again
};

/// Times every row once in every round, one after the other, so that what else runs on the machine meets all of them.
/// A round before is not counted, except for rows that then use up their seconds: these are timed that once.
/// @param tell  is told the round and the row before it is timed
void run_rounds(std::vector<TimedRow>& rows, const RoundsOptions& options,
                const std::function<void(const std::string&)>& tell);

/// "counted" or "CPU time x measured frequency": where cycles come from on this machine.
std::string cycles_source();

}  // namespace rhoray::study

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/analysis/cpu_meter.h"
#include "tools/analysis/measure.h"

namespace rhoray::study {

/// One action to be timed, and its cost each time.
struct TimedRow {
  std::string name;
  std::function<void()> act;
  std::vector<tools::Cost> costs{};
  std::vector<double> cycles{};  ///< per run: counted, or CPU time times the frequency measured in
                                 ///< that round

  tools::Spread cpu_ms() const;
  double median_cycles() const;
  /// Median of the instructions counted, or nothing.
  std::optional<double> median_instructions() const;
};

struct RoundsOptions {
  int rounds = 5;
  /// CPU time after which a row is not timed again.
  double row_seconds = 8;
};

/// Times every row once in every round, one after the other, so that other load on the machine
/// affects all of them. A first round is not counted, except for rows that use up their seconds in
/// it: these are timed only once.
/// @param tell  receives the round and the row before the row is timed
void run_rounds(std::vector<TimedRow>& rows, const RoundsOptions& options,
                const std::function<void(const std::string&)>& tell);

/// "counted" or "CPU time x measured frequency": the source of cycles on this machine.
std::string cycles_source();

}  // namespace rhoray::study

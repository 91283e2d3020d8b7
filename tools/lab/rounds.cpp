#include "tools/lab/rounds.h"

#include "formats/base/text.h"

namespace rhoray::study {

tools::Spread TimedRow::cpu_ms() const {
  std::vector<double> values;
  for (const tools::Cost& cost : costs) values.push_back(1e3 * cost.cpu_s);
  return tools::spread_of(values);
}

double TimedRow::median_cycles() const {
  return tools::spread_of(cycles).median;
}

std::optional<double> TimedRow::median_instructions() const {
  std::vector<double> values;
  for (const tools::Cost& cost : costs)
    if (cost.instructions) values.push_back(*cost.instructions);
  if (values.empty()) return std::nullopt;
  return tools::spread_of(values).median;
}

void run_rounds(std::vector<TimedRow>& rows, const RoundsOptions& options,
                const std::function<void(const std::string&)>& tell) {
  tools::CpuMeter meter;
  std::vector<double> used_s(rows.size(), 0);
  for (int round = 0; round <= options.rounds; ++round) {
    const double frequency_hz = tools::core_frequency_hz();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      TimedRow& row = rows[r];
      if (used_s[r] >= options.row_seconds) continue;
      tell(concat("round ", round, " of ", options.rounds, ", ", row.name));
      const tools::Cost cost = meter.measure(row.act);
      used_s[r] += cost.cpu_s;
      const bool is_the_only_time = used_s[r] >= options.row_seconds && row.costs.empty();
      if (round == 0 && !is_the_only_time) continue;
      row.costs.push_back(cost);
      row.cycles.push_back(cost.cycles.value_or(cost.cpu_s * frequency_hz));
    }
  }
}

std::string cycles_source() {
  return tools::CpuMeter().counts_cycles() ? "counted by the processor" : "CPU time x frequency measured in each round";
}

}  // namespace rhoray::study

#include "tools/rhoray/bench/parts.h"

#include <xxhash.h>

#include <cstdio>

#include "preprocess/input_file.h"
#include "tools/rhoray/cli/version.h"

namespace rhoray::tools {

Json bench_context(const BenchOptions& options) {
  const Machine machine = this_machine();
  return {{"processor", machine.processor},
          {"cores", machine.core_count},
          {"memory_bytes", machine.memory_bytes},
          {"system", machine.system},
          {"version", version()},
          {"commit", commit()},
          {"compiler", compiler()},
          {"input", options.input.filename().string()},
          {"input_bytes", preprocess::input_bytes(options.input)},
          {"repeat", options.repeat},
          {"threads", options.threads == 0 ? machine.core_count : options.threads}};
}

std::vector<std::vector<double>> interleaved(std::size_t row_count, int repeat,
                                             const std::function<double(std::size_t row)>& act) {
  std::vector<std::vector<double>> seconds(row_count);
  for (int round = -1; round < repeat; ++round)
    for (std::size_t row = 0; row < row_count; ++row) {
      const double taken = act(row);
      if (round >= 0) seconds[row].push_back(taken);
    }
  return seconds;
}

void add_spread(Json& row, const std::string& name, const Spread& spread) {
  row[name] = spread.median;
  row[name + "_min"] = spread.smallest;
  row[name + "_max"] = spread.largest;
}

std::string picture_hash(const render::Framebuffer& picture) {
  const XXH64_hash_t hash = XXH3_64bits(picture.color.data(), picture.color.size() * sizeof(float));
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace rhoray::tools

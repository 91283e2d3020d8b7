#include "render/query/machine.h"

#include <array>

namespace rhoray::render {

Machine best_machine() {
  Machine best = Machine::scalar;
  for (const Machine machine : all_machines)
    if (has_machine(machine)) best = machine;
  return best;
}

const char* name_of(Machine machine) {
  constexpr std::array names{"scalar", "baseline", "avx2", "avx512"};
  return names[static_cast<std::size_t>(machine)];
}

bool has_machine(Machine machine) {
#if defined(__x86_64__)
  switch (machine) {
    case Machine::scalar:
    case Machine::baseline:
      return true;
    case Machine::avx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
    case Machine::avx512:
      return has_machine(Machine::avx2) && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512vl");
  }
  return false;
#else
  return machine == Machine::scalar || machine == Machine::baseline;
#endif
}

}  // namespace rhoray::render

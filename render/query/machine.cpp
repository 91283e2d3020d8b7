#include "render/query/machine.h"

#include <array>
#include <cstdlib>
#include <string_view>

#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray::render {

namespace {

constexpr std::array machines{Machine::scalar, Machine::baseline, Machine::avx2, Machine::avx512};

Machine asked_for(std::string_view name) {
  for (const Machine machine : machines)
    if (name == name_of(machine)) {
      if (!has_machine(machine))
        throw Error(ErrorCode::usage, concat("RHORAY_MACHINE=", name, "; this processor does not have it"));
      return machine;
    }
  throw Error(ErrorCode::usage, concat("RHORAY_MACHINE=", name, "; expected scalar, baseline, avx2 or avx512"));
}

}  // namespace

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

Machine chosen_machine() {
  static const Machine chosen = [] {
    if (const char* name = std::getenv("RHORAY_MACHINE")) return asked_for(name);
    Machine best = Machine::scalar;
    for (const Machine machine : machines)
      if (has_machine(machine)) best = machine;
    return best;
  }();
  return chosen;
}

}  // namespace rhoray::render

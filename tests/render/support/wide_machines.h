#pragma once

#include <vector>

#include "render/query/machine.h"

namespace rhoray::tests {

/// Those that this processor has, of the machines that wide kernels are compiled for. Tests of InstructionSets say
/// which these are and are skipped for the others, so that a test run shows what it has left out.
inline std::vector<render::Machine> wide_machines() {
  std::vector<render::Machine> machines;
  for (const render::Machine machine : {render::Machine::baseline, render::Machine::avx2, render::Machine::avx512})
    if (render::has_machine(machine)) machines.push_back(machine);
  return machines;
}

}  // namespace rhoray::tests

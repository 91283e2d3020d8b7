#pragma once

#include <vector>

#include "render/query/machine.h"

namespace rhoray::tests {

/// Returns the instruction sets with wide kernels that this processor has. Tests of InstructionSets
/// report them and are skipped for the others, so that a test run shows what it has omitted.
inline std::vector<render::Machine> wide_machines() {
  std::vector<render::Machine> machines;
  for (const render::Machine machine : {render::Machine::baseline, render::Machine::avx2, render::Machine::avx512})
    if (render::has_machine(machine)) machines.push_back(machine);
  return machines;
}

}  // namespace rhoray::tests

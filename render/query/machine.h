#pragma once

#include <array>

namespace rhoray::render {

/// The instruction sets that kernels are compiled for. `scalar` means the reference kernels, one
/// ray at a time. The others mean the SIMD kernels, where there is one for the query, the dataset
/// and the method.
enum class Machine { scalar, baseline, avx2, avx512 };

inline constexpr std::array all_machines{Machine::scalar, Machine::baseline, Machine::avx2, Machine::avx512};

const char* name_of(Machine machine);

/// True when this processor can run code for this machine.
bool has_machine(Machine machine);

/// The last machine that this processor has.
Machine best_machine();

/// The best machine, or the one named by the environment variable RHORAY_MACHINE (scalar, baseline,
/// avx2 or avx512). Refuses an unknown name and a machine that this processor does not have
/// (ErrorCode::usage). In the shared library, which reads no environment, always the best
/// (chosen_machine_library.cpp).
Machine chosen_machine();

}  // namespace rhoray::render

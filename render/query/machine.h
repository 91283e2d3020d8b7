#pragma once

namespace rhoray::render {

/// What kernels are compiled for. `scalar` are the reference kernels, one ray at a time; the others are the wide ones,
/// where there are some for the question, the volume and the method.
enum class Machine { scalar, baseline, avx2, avx512 };

const char* name_of(Machine machine);

/// The best that this processor has, or what the environment variable RHORAY_MACHINE names (scalar, baseline, avx2 or
/// avx512). Refuses a name that is none, and one that this processor does not have (ErrorCode::usage).
Machine chosen_machine();

/// True when this processor can run it.
bool has_machine(Machine machine);

}  // namespace rhoray::render

#pragma once

#include <span>
#include <string>
#include <vector>

#include "preprocess/inspect_surface.h"
#include "preprocess/neutral.h"
#include "preprocess/tetrahedralize.h"

namespace rhoray::preprocess {

inline constexpr const char* fill_verb = "fill";
inline constexpr const char* find_faults_verb = "find-faults";

/// The worker's second input: where the samples of a size field stand, beside what fits on the
/// command line.
struct SizeMessage {
  std::string kind{};  ///< "volume", "mesh", "distance"; empty = no size field
  int descriptor = -1;
};

/// True when the user, the surface or a size field asks for cells of some size.
bool wants_sizes(const TetrahedralizeOptions& options, const NeutralSurface& surface);

/// The options that the worker needs, as its command line, and back; the size field comes back
/// read. Numbers keep every bit.
std::vector<std::string> arguments_of(const TetrahedralizeOptions& options, const SizeMessage& sizes);
TetrahedralizeOptions options_from(std::span<const char* const> arguments);

/// TetGen's switches for this surface. Numbers are written without exponent, which TetGen would not
/// read everywhere.
std::string tetgen_switches(const TetrahedralizeOptions& options, const NeutralSurface& surface);

/// Refuses switches that TetrahedralizeOptions::tetgen does not take, each by name and with the
/// option to use instead (ErrorCode::usage).
void check_tetgen_switches(const std::string& switches);

/// The worker's answer to find_faults.
void hand_over_faults(std::span<const FaultyFacet> faults, int descriptor);

}  // namespace rhoray::preprocess

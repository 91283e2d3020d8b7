#pragma once

#include <filesystem>
#include <span>

#include "preprocess/inspect_surface.h"

namespace rhoray::tools {

/// Writes the faulty facets as PLY (text): every facet once for each fault, its number in the
/// surface as property `facet`, the kind of fault as property `fault`; comments name the kinds.
void write_fault_file(const std::filesystem::path& path, const preprocess::NeutralSurface& surface,
                      std::span<const preprocess::FaultyFacet> faults, bool replace_existing);

}  // namespace rhoray::tools

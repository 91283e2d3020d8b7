#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Faults of a facet. The numbers must not change: files of faulty facets hold them.
enum class FacetFault : std::uint8_t {
  not_finite = 1,       ///< a corner's coordinate is not a finite number
  flat = 2,             ///< no area, or fewer than three corners
  twin = 3,             ///< another facet has the same corners
  at_open_edge = 4,     ///< has an edge that no other facet shares
  at_crowded_edge = 5,  ///< has an edge that more than one other facet shares
  crossing = 6          ///< intersects another facet outside shared corners and edges
};

std::string_view name_of(FacetFault fault);

struct FaultyFacet {
  std::uint64_t facet = 0;
  FacetFault fault = FacetFault::flat;
};

/// Returns the facets for which `tetrahedralize` refuses a surface, in ascending order. A facet
/// with several faults is listed for each. A worker process decides them in exact arithmetic.
std::vector<FaultyFacet> find_faults(const NeutralSurface& surface, bool solids_may_touch = false);

}  // namespace rhoray::preprocess

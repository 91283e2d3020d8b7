#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// What is wrong with a facet. The numbers stay: they stand in files of faulty facets.
enum class FacetFault : std::uint8_t {
  not_finite = 1,       ///< a corner's coordinate is not a finite number
  flat = 2,             ///< no area, or fewer than three corners
  twin = 3,             ///< there is another with the same corners
  at_open_edge = 4,     ///< meets no other facet at an edge
  at_crowded_edge = 5,  ///< meets more than one other facet at an edge
  crossing = 6          ///< has points in common with another facet beside shared corners and edges
};

std::string_view name_of(FacetFault fault);

struct FaultyFacet {
  std::uint64_t facet = 0;
  FacetFault fault = FacetFault::flat;
};

/// The facets for which `tetrahedralize` refuses a surface, in rising order; a facet may be there for several faults.
/// Decided by exact arithmetic in a worker process.
std::vector<FaultyFacet> find_faults(const NeutralSurface& surface, bool solids_may_touch = false);

}  // namespace rhoray::preprocess

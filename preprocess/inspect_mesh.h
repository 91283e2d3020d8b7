#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// One thing that was looked for, how often it was found, and what that means.
struct Finding {
  std::string name;                        ///< "flat cells"
  std::string thing;                       ///< what `first_ids` number, as in the source: "cell", "point", "sample"
  std::uint64_t count = 0;                 ///< 0: looked for and not found
  std::vector<std::uint64_t> first_ids{};  ///< at most five, rising
  std::string packing;                     ///< what packing does about it
};

/// CandidateList for everything that may be wrong with a mesh of tetrahedra; always the same list, found or not. Flat
/// and flipped are decided exactly; the radii r and R of a sliver's inscribed and circumscribed spheres have 3 r / R
/// below 0.01 (1 for a regular tetrahedron); a point hangs where it lies in a face or edge of the boundary that does
/// not name it, within a millionth of that face's longest edge; cells overlap where the centre of one lies inside
/// another (those that overlap less are not found).
///
/// Expects vertex numbers below the number of points (ErrorCode::invalid otherwise).
std::vector<Finding> inspect_mesh(const NeutralMesh& mesh, const Progress& progress = {});

/// The same for samples on a lattice: no data, no variation, and whether the values look like labels.
std::vector<Finding> inspect_volume(const NeutralVolume& volume);

}  // namespace rhoray::preprocess

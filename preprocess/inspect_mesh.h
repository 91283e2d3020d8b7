#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// One check: how often it found something, and what that means.
struct Finding {
  std::string name;  ///< "flat cells"
  /// what `first_ids` number, as in the source: "cell", "point", "sample"
  std::string thing;
  std::uint64_t count = 0;                 ///< 0: checked and not found
  std::vector<std::uint64_t> first_ids{};  ///< at most five, ascending
  std::string packing;                     ///< what packing does about it
};

/// Checks a mesh of tetrahedra for everything that may be wrong with it. The list of findings is
/// always the same, found or not. The terms mean:
///  * flat and flipped cells: decided exactly;
///  * slivers: 3 r / R is below 0.01, where r and R are the radii of the inscribed and
///    circumscribed spheres (the ratio is 1 for a regular tetrahedron);
///  * hanging points: a point lies in a face or edge of the boundary that does not name it, within
///    a millionth of that face's longest edge;
///  * overlapping cells: the centre of one cell lies inside another (cells that overlap less are
///    not found).
///
/// Expects vertex numbers below the number of points (ErrorCode::invalid otherwise).
std::vector<Finding> inspect_mesh(const NeutralMesh& mesh, const Progress& progress = {});

/// The same for samples on a lattice: checks for missing data, for no variation, and whether the
/// values look like labels.
std::vector<Finding> inspect_volume(const NeutralVolume& volume);

}  // namespace rhoray::preprocess

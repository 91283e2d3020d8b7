#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::recipes {

/// A current dipole smoothed by a normal distribution, so that the potential is smooth and meshes
/// of any resolution approach the same solution.
struct Dipole {
  std::array<double, 3> at_mm{};
  std::array<double, 3> moment_ma_mm{};  ///< milliampere times millimetre
  double width_mm = 8;                   ///< standard deviation in each direction
};

struct PotentialReport {
  /// at the points; its volume mean is 0 when no point is fixed
  std::vector<double> potential_mv;
  double residual = 0;                ///< |K phi - f| / |f|
  std::uint64_t iteration_count = 0;  ///< 0: solved directly
};

using HeldFixed = std::vector<std::pair<std::uint64_t, double>>;  ///< point, potential in mV

/// Solves div(sigma grad phi) = div(dipole density) with linear finite elements and no current
/// through the boundary. Refuses cells without volume, indices out of range, a dipole outside the
/// mesh, and solvers that do not converge.
///
/// @param conductivity  S/m, one per cell, positive
/// @param fixed         points with a given potential; if empty, the mean potential is 0
PotentialReport solve_potential(const preprocess::NeutralMesh& mesh, std::span<const double> conductivity,
                                const Dipole& dipole, const HeldFixed& fixed = {});

/// S/m; rounded values in the range used by forward models of electrocardiography
struct Conductivities {
  double torso = 0.24;
  double heart = 0.4;
  double lungs = 0.05;
};

/// One value per cell, from the cell field "region" (torso_surface.h). Refuses a mesh without the
/// field or with other numbers.
std::vector<double> conductivity_of_cells(const preprocess::NeutralMesh& mesh, const Conductivities& conductivities);

}  // namespace rhoray::recipes

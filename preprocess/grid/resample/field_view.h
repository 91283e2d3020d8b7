#pragma once

#include <limits>
#include <span>
#include <vector>

#include "preprocess/grid/resample/points.h"
#include "preprocess/grid/resample/sample.h"

namespace rhoray::preprocess {

/// A cell's linear function: its change for each step of the lattice.
struct Gradient {
  Point slope{};
  /// of each component; infinite when the cell has no volume
  double error = std::numeric_limits<double>::infinity();
  bool has_values = false;  ///< at all four vertices

  bool is_known() const { return has_values && error < std::numeric_limits<double>::infinity(); }
};

/// @param p  vertices, in steps
/// @param v  the values there
Gradient gradient_of(const std::array<Point, 4>& p, const std::array<double, 4>& v);

/// The data of a field that the certificate needs.
struct FieldView {
  std::vector<double> values;  ///< at the mesh's points
  std::vector<Gradient> gradients;
  double low = 0;  ///< the smallest value; 0 where there is none
  double range = 0;
  double unit = 1;  ///< of the quick bounds, which are in single precision
  /// a power of two: squares of differences in it are neither too small nor too large
  double square_unit = 1;
  double noise = 0;  ///< largest effect of rounding on a difference
  std::span<const Conflict> conflicts;

  double middle() const { return low + 0.5 * range; }
};

/// The mesh's points, in steps of the lattice.
std::vector<Point> points_in_steps(const CleanMesh& mesh, const SampleLattice& lattice);

/// @param steps  as returned by points_in_steps
FieldView view_of(const CleanMesh& mesh, const ScalarField& field, const std::vector<Point>& steps,
                  const SampleLattice& lattice, std::span<const Conflict> conflicts);

}  // namespace rhoray::preprocess

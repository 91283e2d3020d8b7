#pragma once

#include <limits>
#include <span>
#include <vector>

#include "preprocess/grid/resample/points.h"
#include "preprocess/grid/resample/sample.h"

namespace rhoray::preprocess {

/// A cell's linear function: how it rises with each step of the lattice.
struct Gradient {
  Point slope{};
  double error = std::numeric_limits<double>::infinity();  ///< of each component; infinite when the cell has no volume
  bool has_values = false;                                 ///< at all four vertices

  bool is_known() const { return has_values && error < std::numeric_limits<double>::infinity(); }
};

/// @param p  vertices, in steps
/// @param v  the values there
Gradient gradient_of(const std::array<Point, 4>& p, const std::array<double, 4>& v);

/// A field as the certificate needs it.
struct FieldView {
  std::vector<double> values;  ///< at the mesh's points
  std::vector<Gradient> gradients;
  double low = 0;  ///< the smallest value; 0 where there is none
  double range = 0;
  double unit = 1;         ///< of the quick bounds, which are in single precision
  double square_unit = 1;  ///< a power of two: squares of differences in it are neither too small nor too large
  double noise = 0;        ///< what rounding may do to a difference
  std::span<const Conflict> conflicts;

  double middle() const { return low + 0.5 * range; }
};

/// The mesh's points, in steps of the lattice.
std::vector<Point> points_in_steps(const CleanMesh& mesh, const SampleLattice& lattice);

/// @param steps  as points_in_steps gives them
FieldView view_of(const CleanMesh& mesh, const PointField& field, const std::vector<Point>& steps,
                  const SampleLattice& lattice, std::span<const Conflict> conflicts);

}  // namespace rhoray::preprocess

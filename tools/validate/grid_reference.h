#pragma once

#include <optional>

#include "tools/validate/geometry.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools::validate {

/// Finds on which side of the isovalue a trilinear field is at points of a ray. It uses the doubles
/// of samples and ray, and rational arithmetic where rounding could matter. Two points on different
/// sides prove a crossing between them. Safe to call from several threads.
class GridReference {
 public:
  /// The field must outlive this.
  GridReference(const GridField& field, double isovalue) : field_(&field), isovalue_(isovalue) {}

  /// True for value >= isovalue at the ray's point t; nothing outside the grid and where there is
  /// no data.
  std::optional<bool> is_inside(const render::Ray& ray, double t) const;

  /// As above, but nothing where the decision would need more than doubles.
  std::optional<bool> is_clearly_inside(const render::Ray& ray, double t) const;

  /// Difference between the value at the ray's point and the isovalue, in the cell that is said to
  /// contain the point, as a share of the range of its corners. Nothing if the point is outside the
  /// cell by more than rounding, or has no data.
  std::optional<double> residual(const render::Ray& ray, double t, const Index3& cell) const;

  /// The crossing nearest to t, at most `farthest` away, as found by an outward search in growing
  /// steps. Its accuracy is `finest`.
  std::optional<double> crossing_near(const render::Ray& ray, double t, double finest, double farthest) const;

  /// The first crossing in [t_begin, t_end] that is proved by points of the ray, `step_cells`
  /// apart: data on both of its sides, on different sides of the isovalue. A result of nothing is
  /// no proof that there is no crossing.
  std::optional<double> first_proved(const render::Ray& ray, double t_begin, double t_end, double step_cells) const;

 private:
  /// Bisects between points on different sides; nothing if a point between them has no data.
  std::optional<double> halved(const render::Ray& ray, double lo, double hi, bool side_lo, double finest) const;

  const GridField* field_;
  double isovalue_;
};

}  // namespace rhoray::tools::validate

#pragma once

#include <optional>

#include "tools/validate/geometry.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools::validate {

/// On which side of the isovalue a trilinear field lies at points of a ray: by the doubles of samples and ray, decided
/// in rational numbers where rounding could matter. Two points with different sides prove a crossing between them. May
/// be asked from many threads.
class GridReference {
 public:
  /// The field must outlive this.
  GridReference(const GridField& field, double isovalue) : field_(&field), isovalue_(isovalue) {}

  /// True for value >= isovalue at the ray's point t; nothing outside the grid and where there is no data.
  std::optional<bool> is_inside(const render::Ray& ray, double t) const;

  /// As above, but nothing where the decision would need more than doubles.
  std::optional<bool> is_clearly_inside(const render::Ray& ray, double t) const;

  /// How far the value at the ray's point lies from the isovalue in a cell that is said to hold it, as a share of the
  /// range of its corners; nothing when the point lies outside the cell by more than rounding, or has no data.
  std::optional<double> residual(const render::Ray& ray, double t, const Index3& cell) const;

  /// The crossing nearest to t: at most `farthest` away, and so that a search outwards in steps that grow by a factor
  /// proves it. Known to `finest`.
  std::optional<double> crossing_near(const render::Ray& ray, double t, double finest, double farthest) const;

  /// The first crossing of [t_begin, t_end] that points of the ray, so many cells apart, prove: on both sides of it
  /// lies data on different sides of the isovalue. Nothing proves that there is none.
  std::optional<double> first_proved(const render::Ray& ray, double t_begin, double t_end, double step_cells) const;

 private:
  /// Between points with different sides; nothing where no data lies between.
  std::optional<double> halved(const render::Ray& ray, double lo, double hi, bool side_lo, double finest) const;

  const GridField* field_;
  double isovalue_;
};

}  // namespace rhoray::tools::validate

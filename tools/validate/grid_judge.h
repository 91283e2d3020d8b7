#pragma once

#include <optional>

#include "formats/base/interval.h"
#include "tools/validate/geometry.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools::validate {

/// On which side of the isovalue a trilinear field lies at points of a ray: by the doubles of samples and ray, decided
/// in rational numbers where rounding could matter. Two points with different sides prove a crossing between them. May
/// be asked from many threads.
class GridJudge {
 public:
  /// The field must outlive this.
  GridJudge(const GridField& field, double isovalue) : field_(&field), isovalue_(isovalue) {}

  /// True for value >= isovalue at the ray's point t; nothing outside the grid and where there is no data.
  std::optional<bool> is_inside(const render::FrameRay& ray, double t) const;

  /// As above, but nothing where the decision would need more than doubles.
  std::optional<bool> is_clearly_inside(const render::FrameRay& ray, double t) const;

  /// How far the value at the ray's point lies from the isovalue, as a share of the range of its cell's corners;
  /// nothing outside the grid and where there is no data.
  std::optional<double> residual(const render::FrameRay& ray, double t) const;

  /// The crossing nearest to t: at most `farthest` away, and so that a search outwards in steps that grow by a factor
  /// proves it. Known to `finest`.
  std::optional<double> crossing_near(const render::FrameRay& ray, double t, double finest, double farthest) const;

  /// A stretch of [t_begin, t_end] at whose ends the ray is clearly on different sides, with data all along as far as
  /// its points, `step` apart, tell: the first of them. Nothing proves that there is none.
  std::optional<Interval<double>> clear_change(const render::FrameRay& ray, double t_begin, double t_end,
                                               double step) const;

 private:
  const GridField* field_;
  double isovalue_;
};

}  // namespace rhoray::tools::validate

#pragma once

#include <memory>
#include <optional>

#include "render/ray_caster.h"

namespace rhoray::tools {

/// Evaluates the original data on rays, to measure errors in cells and in values.
class FieldTruth {
 public:
  explicit FieldTruth(const render::Dataset& dataset);
  ~FieldTruth();

  /// Number of cells that a ray passes while t grows by 1, at its true hit. For a grid these are
  /// its cells along the ray. For a mesh it is the reciprocal of the longest edge of the
  /// tetrahedron hit. For OpenVDB these are voxels.
  double cells_per_t(const render::Ray& ray, const render::Hit& truth) const;

  /// The field at t: trilinear between the samples of a grid. In a mesh and in OpenVDB it is
  /// extrapolated with the true hit's gradient; that equals the field as long as the position is in
  /// the same cell. Nothing outside the data.
  std::optional<double> value(const render::Ray& ray, const render::Hit& truth, double isovalue, double t) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace rhoray::tools

#pragma once

#include <memory>
#include <optional>

#include "render/ray_caster.h"

namespace rhoray::tools {

/// What the data themselves say at a place on a ray, to measure errors in cells and in values.
class FieldTruth {
 public:
  explicit FieldTruth(const render::Volume& volume);
  ~FieldTruth();

  /// Cells that a ray passes while t grows by 1, where it truly hits: of a grid its cells along the way; of a mesh one
  /// over the longest edge of the tetrahedron that is hit; of OpenVDB voxels.
  double cells_per_t(const render::Ray& ray, const render::Hit& truth) const;

  /// The field at a place, trilinear between the samples of a grid. In a mesh and in OpenVDB by the true hit's
  /// gradient, which is the field itself as long as the place lies in the same cell. Nothing outside the data.
  std::optional<double> value(const render::Ray& ray, const render::Hit& truth, double isovalue, double t) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace rhoray::tools

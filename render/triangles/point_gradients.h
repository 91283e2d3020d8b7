#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "render/tets/tet_data.h"
#include "render/triangles/triangle_data.h"

namespace rhoray::render {

/// The gradient of a mesh's field at its points: the mean of the gradients of the cells around each
/// point, weighted by their volumes (C. Correa, R. Hero, K.-L. Ma, IEEE TVCG 17(3), 2011). That is
/// the mean slope of the field over all these cells. Slivers, whose own gradients are unreliable,
/// get little weight, and no cell is divided by its volume.
///
/// Cells without data do not count. Zero where a point's cells have no volume.
///
/// For a surface: the mean of the unit normals of the triangles around each point, weighted by
/// their angles there (G. Thuermer, C. Wuethrich, Journal of Graphics Tools 3(1), 1998). It does
/// not depend on how faces are triangulated. Triangles without area do not count; those with
/// opposite orientation cancel.
class PointGradients {
 public:
  /// @param threads  0 = all cores; the result is the same for any number
  PointGradients(const TetData& view, unsigned threads);
  PointGradients(const TriangleData& view, unsigned threads);

  /// Gradients in the mesh's frame.
  std::span<const std::array<double, 3>> of_points() const { return gradients_; }

 private:
  std::vector<std::array<double, 3>> gradients_;
};

/// The gradients of one mesh or surface, computed at the first call. Any thread may call.
class PointGradientsCache {
 public:
  template <class View>
  std::shared_ptr<const PointGradients> of(const View& view, unsigned threads) {
    const std::lock_guard lock(mutex_);
    if (!gradients_) gradients_ = std::make_shared<const PointGradients>(view, threads);
    return gradients_;
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const PointGradients> gradients_;
};

}  // namespace rhoray::render

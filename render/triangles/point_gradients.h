#pragma once

#include <array>
#include <span>
#include <stop_token>
#include <vector>

#include "render/tets/tet_data.h"
#include "render/triangles/computed_once.h"

namespace rhoray::render {

/// The gradient of a mesh's field at its points: the mean of the gradients of the cells around each
/// point, weighted by their volumes (C. Correa, R. Hero, K.-L. Ma, IEEE TVCG 17(3), 2011). That is
/// the mean slope of the field over all these cells. Slivers, whose own gradients are unreliable,
/// get little weight, and no cell is divided by its volume.
///
/// Cells without data do not count. Zero where a point's cells have no volume.
class PointGradients {
 public:
  /// @param threads  0 = all cores; the result is the same for any number
  /// @param stop     ends it (ErrorCode::interrupted)
  PointGradients(const TetData& view, unsigned threads, const std::stop_token& stop = {});

  /// Gradients in the mesh's frame.
  std::span<const std::array<double, 3>> of_points() const { return gradients_; }

  std::size_t size_bytes() const { return of_points().size_bytes(); }

 private:
  std::vector<std::array<double, 3>> gradients_;
};

class PointGradientsCache : public ComputedOnce<PointGradients> {};

}  // namespace rhoray::render

#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "formats/base/vector.h"
#include "render/triangles/computed_once.h"
#include "render/triangles/triangle_data.h"

namespace rhoray::render {

/// Smooth normals at the corners of a surface's triangles: the mean of the unit normals of the
/// triangles around a point, weighted by their angles there (G. Thuermer, C. Wuethrich, Journal of
/// Graphics Tools 3(1), 1998). It does not depend on how faces are triangulated.
///
/// Two triangles that share an edge at the point belong together if their normals are less than 30
/// degrees apart; the mean is that of all triangles that belong together from edge to edge. So a
/// surface is smooth across every edge below that crease angle, and keeps every other edge.
/// Triangles of opposite orientation are turned to agree: a normal points to the side of its own
/// triangle's normal. A triangle without area takes the normal of the neighbour from which it is
/// reached, and has no weight.
class CornerNormals {
 public:
  static constexpr double crease_angle_deg = 30;

  /// @param threads  0 = all cores; the result is the same for any number
  /// @param stop     ends it (ErrorCode::interrupted)
  CornerNormals(const TriangleData& view, unsigned threads, const std::stop_token& stop = {});

  /// The normal at a corner of a triangle, of length 1; zero where there is none.
  Vec3 of(std::uint32_t triangle, std::size_t corner) const { return normals_[of_corners_[triangle][corner]]; }

  std::size_t size_bytes() const {
    return normals_.size() * sizeof(normals_[0]) + of_corners_.size() * sizeof(of_corners_[0]);
  }

 private:
  std::vector<Vec3> normals_;  ///< one of each point, then the others of points at creases
  std::vector<std::array<std::uint32_t, 3>> of_corners_;
};

class CornerNormalsCache : public ComputedOnce<CornerNormals> {};

}  // namespace rhoray::render

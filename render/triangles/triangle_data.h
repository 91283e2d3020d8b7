#pragma once

#include <array>
#include <cstdint>

#include "formats/triangle_mesh.h"
#include "render/traverse/ray.h"

namespace rhoray::render {

/// A packed surface as a volume for rays: its triangles, in world axes. There is no field.
class TriangleData {
 public:
  explicit TriangleData(const formats::TriangleMesh& mesh) : mesh_(mesh) {}

  const formats::TriangleMesh& mesh() const { return mesh_; }
  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(mesh_.description().triangle_count); }

  /// Returns the point indices of a triangle.
  RHORAY_INLINE std::array<std::uint32_t, 3> vertices(std::uint32_t triangle) const {
    return mesh_.triangles()[triangle];
  }
  RHORAY_INLINE std::array<std::array<double, 3>, 3> points_at(const std::array<std::uint32_t, 3>& v) const {
    return {mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2])};
  }
  std::uint64_t cell_id(std::uint32_t triangle) const { return mesh_.triangle_id(triangle); }

 private:
  formats::TriangleMesh mesh_;
};

}  // namespace rhoray::render

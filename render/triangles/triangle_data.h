#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "formats/triangle_mesh.h"
#include "render/traverse/ray.h"
#include "render/triangles/mesh_boundary.h"

namespace rhoray::render {

/// Triangles as a volume for rays: a packed surface, in world axes, which has no field; or the
/// boundary of a mesh, in the mesh's frame, whose fields are those of its cells.
class TriangleData {
 public:
  explicit TriangleData(const formats::TriangleMesh& mesh) : mesh_(mesh), triangles_(mesh.triangles()) {}
  explicit TriangleData(std::shared_ptr<const MeshBoundary> boundary)
      : boundary_(std::move(boundary)), triangles_(boundary_->triangles) {}

  /// Null: a packed surface.
  const MeshBoundary* boundary() const { return boundary_.get(); }

  std::uint64_t point_count() const { return boundary_ ? boundary_->points.size() : mesh_->description().point_count; }
  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(triangles_.size()); }

  /// Returns the point indices of a triangle.
  RHORAY_INLINE std::array<std::uint32_t, 3> vertices(std::uint32_t triangle) const { return triangles_[triangle]; }
  RHORAY_INLINE std::array<std::array<double, 3>, 3> points_at(const std::array<std::uint32_t, 3>& v) const {
    return {point(v[0]), point(v[1]), point(v[2])};
  }
  /// The id of the triangle, or of the cell of which it is a face.
  std::uint64_t cell_id(std::uint32_t triangle) const {
    return boundary_ ? boundary_->mesh.cell_id(boundary_->cells[triangle]) : mesh_->triangle_id(triangle);
  }

 private:
  RHORAY_INLINE std::array<double, 3> point(std::uint32_t p) const {
    return boundary_ ? boundary_->points[p] : mesh_->point(p);
  }

  std::optional<formats::TriangleMesh> mesh_{};  ///< one of these two is set
  std::shared_ptr<const MeshBoundary> boundary_{};
  std::span<const std::array<std::uint32_t, 3>> triangles_;
};

}  // namespace rhoray::render

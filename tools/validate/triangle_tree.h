#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "tools/validate/geometry.h"

namespace rhoray::tools::validate {

/// Triangles for ray intersection and distance queries (CGAL's AABB tree; exact predicates decide
/// which triangle is hit). Triangles without area are omitted, because their points belong to their
/// neighbours' edges. Safe to call from several threads.
class TriangleTree {
 public:
  explicit TriangleTree(const Triangles& triangles);
  ~TriangleTree();
  TriangleTree(TriangleTree&&) noexcept;
  TriangleTree& operator=(TriangleTree&&) noexcept;

  bool is_empty() const;

  struct Meeting {
    std::size_t triangle = 0;
    double t = 0;  ///< rounded
  };
  /// The first triangle on the ray, borders included.
  std::optional<Meeting> first_on(const render::Ray& ray) const;

  /// The point of the triangles nearest to p; needs at least one triangle.
  Vec3 nearest(const Vec3& p) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace rhoray::tools::validate

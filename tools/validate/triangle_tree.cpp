#include "tools/validate/triangle_tree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "tools/validate/shot.h"

namespace rhoray::tools::validate {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangle = Kernel::Triangle_3;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using Aabb = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 cgal_point(const Vec3& p) {
  return {p.x, p.y, p.z};
}

}  // namespace

struct TriangleTree::Tree {
  std::vector<Triangle> triangles;
  std::vector<std::size_t> numbers;  ///< indices of the triangles in the tree
  Box3 box;
  Aabb aabb;
};

TriangleTree::TriangleTree(const Triangles& triangles) : tree_(std::make_unique<Tree>()) {
  for (std::size_t t = 0; t < triangles.corners.size(); ++t) {
    const auto a = cgal_point(triangles.corner(t, 0)), b = cgal_point(triangles.corner(t, 1)),
               c = cgal_point(triangles.corner(t, 2));
    if (CGAL::collinear(a, b, c)) continue;
    tree_->triangles.emplace_back(a, b, c);
    tree_->numbers.push_back(t);
    for (std::size_t corner = 0; corner < 3; ++corner) tree_->box.extendBy(triangles.corner(t, corner));
  }
  tree_->aabb.insert(tree_->triangles.cbegin(), tree_->triangles.cend());
  if (tree_->triangles.empty()) return;
  tree_->aabb.build();
  tree_->aabb.accelerate_distance_queries();
}

TriangleTree::~TriangleTree() = default;
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;
TriangleTree& TriangleTree::operator=(TriangleTree&&) noexcept = default;

bool TriangleTree::is_empty() const {
  return tree_->triangles.empty();
}

std::optional<TriangleTree::Meeting> TriangleTree::first_on(const render::Ray& ray) const {
  if (is_empty()) return std::nullopt;
  const auto met = tree_->aabb.first_intersection(shot_of(ray, tree_->box));
  if (!met) return std::nullopt;
  const Triangle& triangle = *met->second;
  const auto vec = [](const Kernel::Point_3& p) { return Vec3(p.x(), p.y(), p.z()); };
  const Vec3 a = vec(triangle[0]);
  const Vec3 normal = (vec(triangle[1]) - a).cross(vec(triangle[2]) - a);
  const double t = normal.dot(a - ray.origin) / normal.dot(ray.direction);
  return Meeting{tree_->numbers[static_cast<std::size_t>(met->second - tree_->triangles.cbegin())], t};
}

Vec3 TriangleTree::nearest(const Vec3& p) const {
  const Kernel::Point_3 found = tree_->aabb.closest_point(cgal_point(p));
  return {found.x(), found.y(), found.z()};
}

}  // namespace rhoray::tools::validate

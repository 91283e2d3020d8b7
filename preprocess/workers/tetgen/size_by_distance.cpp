#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "formats/base/error.h"
#include "preprocess/workers/faces/cut_faces.h"
#include "preprocess/workers/tetgen/sizes.h"

namespace rhoray::preprocess {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;  // distances are wanted to a few digits
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Triangles triangles_of(const NeutralSurface& s) {
  Triangles triangles;
  const auto point = [&](std::uint64_t index) {
    const auto& p = s.points[index];
    return Kernel::Point_3(p[0], p[1], p[2]);
  };
  for (const auto& corners : cut_faces(s).triangles) {
    const Kernel::Triangle_3 t(point(corners[0]), point(corners[1]), point(corners[2]));
    if (!t.is_degenerate()) triangles.push_back(t);
  }
  if (triangles.empty()) throw Error(ErrorCode::invalid, "size field: the surface has no facet with an area");
  return triangles;
}

class DistanceSizes {
 public:
  explicit DistanceSizes(const SizeByDistance& sizes)
      : sizes_(sizes),
        triangles_(std::make_shared<const Triangles>(triangles_of(sizes.surface))),
        tree_(std::make_shared<Tree>(triangles_->begin(), triangles_->end())) {
    tree_->accelerate_distance_queries();
  }

  std::optional<double> operator()(const std::array<double, 3>& p) const {
    const double distance = std::sqrt(tree_->squared_distance(Kernel::Point_3(p[0], p[1], p[2])));
    return std::min(sizes_.near + sizes_.growth * distance, sizes_.far);
  }

 private:
  const SizeByDistance& sizes_;
  std::shared_ptr<const Triangles> triangles_;
  std::shared_ptr<Tree> tree_;
};

}  // namespace

SizeAt size_by_distance(const SizeByDistance& distance) {
  return DistanceSizes(distance);
}

}  // namespace rhoray::preprocess

#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <array>
#include <cstddef>
#include <vector>

namespace rhoray::preprocess::repair {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using TriangleMesh = CGAL::Surface_mesh<Point>;

/// Triangles that know their corners but not their neighbours.
struct Soup {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> facets;
};

}  // namespace rhoray::preprocess::repair

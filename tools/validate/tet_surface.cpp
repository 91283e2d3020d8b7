#include "tools/validate/tet_surface.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <array>
#include <unordered_map>

namespace rhoray::tools::validate {

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;

/// Corners already made, by the edge they lie on.
class Corners {
 public:
  Corners(double isovalue, std::vector<Vec3>& points) : isovalue_(isovalue), points_(points) {}

  std::uint32_t on_edge(const TetField::Cell& cell, std::size_t a, std::size_t b) {
    if (cell.vertex[b] < cell.vertex[a]) std::swap(a, b);
    const std::uint64_t edge = (std::uint64_t{cell.vertex[a]} << 32) | cell.vertex[b];
    const auto [at, is_new] = made_.try_emplace(edge, static_cast<std::uint32_t>(points_.size()));
    if (is_new) points_.push_back(make(cell, a, b));
    return at->second;
  }

 private:
  Vec3 make(const TetField::Cell& cell, std::size_t a, std::size_t b) const {
    const auto exact = [](const std::array<double, 3>& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
    const Kernel::FT low = cell.value[a], high = cell.value[b];
    const Kernel::Point_3 from = exact(cell.point[a]);
    const Kernel::Point_3 point = from + (Kernel::FT(isovalue_) - low) / (high - low) * (exact(cell.point[b]) - from);
    const auto rounded = [](const Kernel::FT& coordinate) { return CGAL::to_double(coordinate.exact()); };
    return {rounded(point.x()), rounded(point.y()), rounded(point.z())};
  }

  double isovalue_;
  std::vector<Vec3>& points_;
  std::unordered_map<std::uint64_t, std::uint32_t> made_;
};

}  // namespace

TetSurface extract_surface(const TetField& field, double isovalue) {
  TetSurface surface;
  Corners corners(isovalue, surface.triangles.points);
  for (std::size_t c = 0; c < field.cell_count(); ++c) {
    const TetField::Cell cell = field.cell(c);
    if (!TetField::straddles(cell, isovalue)) continue;
    surface.straddling.push_back(static_cast<std::uint32_t>(c));
    std::array<std::size_t, 4> inside{}, outside{};
    std::size_t inside_count = 0, outside_count = 0;
    for (std::size_t v = 0; v < 4; ++v)
      (cell.value[v] >= isovalue ? inside[inside_count++] : outside[outside_count++]) = v;

    // All corners in the order around the polygon: with two vertices on each side, neighbours share
    // one of them.
    std::vector<std::uint32_t> polygon;
    if (inside_count == 2) {
      polygon = {corners.on_edge(cell, inside[0], outside[0]), corners.on_edge(cell, inside[0], outside[1]),
                 corners.on_edge(cell, inside[1], outside[1]), corners.on_edge(cell, inside[1], outside[0])};
    } else {
      for (std::size_t i = 0; i < inside_count; ++i)
        for (std::size_t o = 0; o < outside_count; ++o) polygon.push_back(corners.on_edge(cell, inside[i], outside[o]));
    }
    for (std::size_t last = 2; last < polygon.size(); ++last) {
      surface.triangles.corners.push_back({polygon[0], polygon[last - 1], polygon[last]});
      surface.cells.push_back(static_cast<std::uint32_t>(c));
    }
  }
  return surface;
}

}  // namespace rhoray::tools::validate

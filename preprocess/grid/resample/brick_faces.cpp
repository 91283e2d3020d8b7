#include "preprocess/grid/resample/brick_faces.h"

#include <algorithm>

namespace rhoray::preprocess {

BrickFace::BrickFace(const std::array<Point, 3>& corners_in_brick, const std::array<std::uint32_t, 3>& vertices_of_mesh,
                     std::uint32_t cell_of_mesh)
    : corners(corners_in_brick), vertices(vertices_of_mesh), cell(cell_of_mesh) {
  const Point e0 = minus(corners[1], corners[0]), e1 = minus(corners[2], corners[1]),
              e2 = minus(corners[0], corners[2]);
  normal = cross(e0, e1);
  normal_error = 0x1p-48 * sum_of_magnitudes(e0) * sum_of_magnitudes(e1);
  inverse_area = 1 / dot(normal, normal);
  sides = {cross(normal, e0), cross(normal, e1), cross(normal, e2)};
  constexpr double half = 0.5 + 1e-6;
  normal_reach = half * sum_of_magnitudes(normal);
  for (std::size_t e = 0; e < 3; ++e) side_reaches[e] = half * sum_of_magnitudes(sides[e]);
}

void BrickFaces::enter(const Point& first, std::span<const std::uint32_t> cells) {
  first_ = first;
  cells_ = cells;
  numbers_.assign(4 * cells.size(), not_made);
  faces_.clear();
}

std::uint32_t BrickFaces::make(std::uint32_t cell, std::size_t side) {
  std::array<Point, 3> corners;
  std::array<std::uint32_t, 3> vertices;
  for (std::size_t v = 0; v < 3; ++v) {
    vertices[v] = mesh_.cells[cell][face_vertices[side][v]];
    corners[v] = minus(steps_[vertices[v]], first_);
  }
  faces_.emplace_back(corners, vertices, cell);
  return static_cast<std::uint32_t>(faces_.size() - 1);
}

CellPlane::CellPlane(const std::array<double, 8>& corners) {
  for (std::size_t c = 0; c < 8; ++c) {
    value_ += 0.125 * corners[c];
    for (std::size_t a = 0; a < 3; ++a) slope_[a] += (c >> a & 1) != 0 ? 0.25 * corners[c] : -0.25 * corners[c];
  }
  for (std::size_t c = 0; c < 8; ++c) {
    double linear = value_;
    for (std::size_t a = 0; a < 3; ++a) linear += (c >> a & 1) != 0 ? 0.5 * slope_[a] : -0.5 * slope_[a];
    rest_ = std::max(rest_, std::abs(corners[c] - linear));
  }
}

double CellPlane::bound_on(const BrickFace& face, const FieldView& field, const Point& low) const {
  const Gradient& gradient = field.gradients[face.cell];
  double distance = 0, along = 0, at_middle = value_ - field.values[face.vertices[0]], reach = 1.5;
  Point half, off;
  for (std::size_t a = 0; a < 3; ++a) {
    const double p = face.corners[0][a] - low[a], q = face.corners[1][a] - low[a], r = face.corners[2][a] - low[a];
    const double lo = larger(0.0, smaller(smaller(p, q), r)), hi = smaller(1.0, larger(larger(p, q), r));
    const double middle = 0.5 * (lo + hi);
    half[a] = 0.5 * std::abs(hi - lo) + 1e-6;
    off[a] = slope_[a] - gradient.slope[a];
    at_middle += slope_[a] * (middle - 0.5) - gradient.slope[a] * (middle - p);
    distance += face.normal[a] * (p - middle);
    along += face.normal[a] * off[a];
    reach += std::abs(middle - p);
  }
  along *= face.inverse_area;
  double bound = std::abs(at_middle + along * distance);
  for (std::size_t a = 0; a < 3; ++a) bound += half[a] * std::abs(off[a] - along * face.normal[a]);
  const double rounding = reach * (gradient.error + std::abs(along) * face.normal_error);
  return (bound + rest_ + rounding) * (1 + 1e-9);
}

}  // namespace rhoray::preprocess

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/triangles/triangle_data.h"

namespace rhoray::render {

/// A triangle's corner at a point.
struct Corner {
  std::uint32_t triangle;
  std::uint32_t index;
};

/// The corners at every point, by triangle.
class CornersOfPoints {
 public:
  explicit CornersOfPoints(const TriangleData& view) : first_(view.point_count() + 1) {
    for (std::uint32_t t = 0; t < view.triangle_count(); ++t)
      for (const std::uint32_t point : view.vertices(t)) ++first_[point + 1];
    for (std::size_t p = 1; p < first_.size(); ++p) first_[p] += first_[p - 1];
    corners_.resize(first_.back());
    std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < view.triangle_count(); ++t) {
      const auto vertices = view.vertices(t);
      for (std::uint32_t c = 0; c < 3; ++c) corners_[next[vertices[c]]++] = {t, c};
    }
  }

  std::span<const Corner> at(std::size_t point) const {
    return std::span(corners_).subspan(first_[point], first_[point + 1] - first_[point]);
  }

 private:
  std::vector<std::uint64_t> first_;
  std::vector<Corner> corners_;
};

}  // namespace rhoray::render

#include "render/triangles/feature_edges.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

#include "formats/base/parallel.h"
#include "render/cell/triangle_crossing.h"
#include "render/triangles/corners_of_points.h"

namespace rhoray::render {

namespace {

/// One side of an edge: a triangle whose corners go along it from the point in question, or towards
/// that point.
struct Side {
  std::uint32_t to;  ///< the other end
  std::uint32_t triangle;
  bool leaves;
};

Vec3 normal_of(const TriangleData& view, std::uint32_t triangle) {
  return triangle_normal(view.points_at(view.vertices(triangle)));
}

/// By how much a surface turns at an edge, in degrees.
double turn_deg(const TriangleData& view, std::span<const Side> sides) {
  if (sides.size() != 2) return 180;
  const Vec3 a = normal_of(view, sides[0].triangle), b = normal_of(view, sides[1].triangle);
  const double sign = sides[0].leaves == sides[1].leaves ? -1 : 1;  // one is oriented the other way round
  return std::atan2(a.cross(b).length(), sign * a.dot(b)) * 180 / std::numbers::pi;
}

/// Calls take(to) for the edges from a point to points of higher index that turn by more.
template <class Take>
void find_at(const TriangleData& view, std::uint32_t point, std::span<const Corner> corners, double angle_deg,
             std::vector<Side>& sides, const Take& take) {
  sides.clear();
  for (const auto [triangle, index] : corners) {
    const auto vertices = view.vertices(triangle);
    const std::uint32_t next = vertices[(index + 1) % 3], last = vertices[(index + 2) % 3];
    if (next > point) sides.push_back({next, triangle, true});
    if (last > point) sides.push_back({last, triangle, false});
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.to < b.to; });
  for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
    while (end < sides.size() && sides[end].to == sides[first].to) ++end;
    if (turn_deg(view, std::span(sides).subspan(first, end - first)) > angle_deg) take(sides[first]);
  }
}

/// The ends of the edge between a triangle's corners at two of its points.
std::array<Vec3, 2> ends_of(const TriangleData& view, std::uint32_t triangle, std::uint32_t from, std::uint32_t to) {
  const auto vertices = view.vertices(triangle);
  const auto points = view.points_at(vertices);
  std::array<Vec3, 2> ends;
  for (std::size_t c = 0; c < 3; ++c)
    for (const auto& [vertex, end] : {std::pair(from, 0U), {to, 1U}})
      if (vertices[c] == vertex) ends[end] = Vec3(points[c][0], points[c][1], points[c][2]);
  return ends;
}

}  // namespace

std::vector<std::array<Vec3, 2>> feature_edges(const TriangleData& view, double angle_deg, unsigned threads) {
  constexpr std::uint64_t fewest_points = 1 << 12;
  const CornersOfPoints corners(view);
  using Edges = std::vector<std::array<Vec3, 2>>;
  std::mutex guard;
  std::vector<std::pair<std::uint64_t, Edges>> parts;  // first point, its edges and those of some that follow
  for_each_range(view.point_count(), fewest_points, threads, [&](std::uint64_t first, std::uint64_t end) {
    Edges edges;
    std::vector<Side> sides;
    for (std::uint64_t p = first; p < end; ++p) {
      const auto point = static_cast<std::uint32_t>(p);
      find_at(view, point, corners.at(p), angle_deg, sides,
              [&](const Side& side) { edges.push_back(ends_of(view, side.triangle, point, side.to)); });
    }
    const std::lock_guard lock(guard);
    parts.emplace_back(first, std::move(edges));
  });
  std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Edges found;
  for (const auto& [first, edges] : parts) found.insert(found.end(), edges.begin(), edges.end());
  return found;
}

double area_of(const TriangleData& view) {
  double twice = 0;
  for (std::uint32_t t = 0; t < view.triangle_count(); ++t) twice += normal_of(view, t).length();
  return twice / 2;
}

}  // namespace rhoray::render

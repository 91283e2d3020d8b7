#include "render/triangles/corner_normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "formats/base/stopping.h"
#include "render/cell/triangle_crossing.h"
#include "render/triangles/corners_of_points.h"

namespace rhoray::render {

namespace {

double angle_at(const TrianglePoints& points, std::size_t corner) {
  const auto edge = [&](std::size_t to) {
    const auto &a = points[corner], &b = points[(corner + to) % 3];
    return Vec3(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
  };
  const Vec3 a = edge(1), b = edge(2);
  return std::atan2(a.cross(b).length(), a.dot(b));
}

/// The triangles around one point, put together across its edges.
class Fans {
 public:
  /// Finds for each corner at the point the place of its normal among normals().
  void find(const TriangleData& view, std::span<const Corner> corners) {
    members_.clear(), edges_.clear(), normals_.clear();
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
      const auto [triangle, index] = corners[i];
      const auto vertices = view.vertices(triangle);
      const TrianglePoints points = view.points_at(vertices);
      const Vec3 normal = triangle_normal(points).normalized();
      members_.push_back({.normal = normal, .weighted = angle_at(points, index) * normal});
      edges_.push_back({.to = vertices[(index + 1) % 3], .member = i, .leaves = true});
      edges_.push_back({.to = vertices[(index + 2) % 3], .member = i, .leaves = false});
    }
    std::stable_sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) { return a.to < b.to; });
    for (std::size_t e = 0; e < edges_.size(); ++e)
      if (Member& member = members_[edges_[e].member]; edges_[e].leaves)
        member.leaving = e;
      else
        member.arriving = e;
    for (std::uint32_t i = 0; i < members_.size(); ++i)
      if (members_[i].slot == none) gather(i);
  }

  const std::vector<Vec3>& normals() const { return normals_; }
  std::uint32_t slot(std::size_t corner) const { return members_[corner].slot; }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  struct Member {
    Vec3 normal;  ///< of length 1, or 0
    Vec3 weighted;
    std::size_t leaving = 0, arriving = 0;  ///< its edges at the point
    std::uint32_t slot = none;
    bool is_turned = false;  ///< against the first of its fan
  };
  struct Edge {
    std::uint32_t to;
    std::uint32_t member;
    bool leaves;  ///< the member's corners go along it away from the point
  };

  /// Puts a fan together, starting with one member, and adds its normal; two of opposite sign where
  /// members are turned.
  void gather(std::uint32_t start) {
    Vec3 sum(0, 0, 0);
    bool has_turned = false;
    const auto slot = static_cast<std::uint32_t>(normals_.size());
    members_[start].slot = slot;
    fan_.assign(1, start);
    for (std::size_t next = 0; next < fan_.size(); ++next) {
      const Member member = members_[fan_[next]];
      sum += member.is_turned ? -member.weighted : member.weighted;
      has_turned |= member.is_turned;
      for (const std::size_t edge : {member.leaving, member.arriving}) add_beyond(edge, member, slot);
    }
    normals_.push_back(sum);
    if (!has_turned) return;
    normals_.push_back(-sum);
    for (const std::uint32_t i : fan_)
      if (members_[i].is_turned) members_[i].slot = slot + 1;
  }

  /// Adds the members on the other side of an edge that belong to the fan.
  void add_beyond(std::size_t edge, const Member& from, std::uint32_t slot) {
    static const double least_cosine = std::cos(CornerNormals::crease_angle_deg * std::numbers::pi / 180);
    const Edge& own = edges_[edge];
    const auto add = [&](const Edge& other) {
      Member& member = members_[other.member];
      if (member.slot != none) return;
      const bool is_turned = other.leaves == own.leaves;
      const bool is_flat = member.normal == Vec3(0, 0, 0);
      const double cosine = (is_turned ? -1 : 1) * member.normal.dot(from.normal);
      if (!is_flat && from.normal != Vec3(0, 0, 0) && !(cosine > least_cosine)) return;
      if (is_flat) member.normal = is_turned ? -from.normal : from.normal;
      member.slot = slot;
      member.is_turned = from.is_turned != is_turned;
      fan_.push_back(other.member);
    };
    for (std::size_t e = edge + 1; e < edges_.size() && edges_[e].to == own.to; ++e) add(edges_[e]);
    for (std::size_t e = edge; e-- > 0 && edges_[e].to == own.to;) add(edges_[e]);
  }

  std::vector<Member> members_;
  std::vector<Edge> edges_;  ///< by their other end
  std::vector<std::uint32_t> fan_;
  std::vector<Vec3> normals_;
};

}  // namespace

// The first normal of a point has the point's place; the places of the others are counted before
// they are computed again. So the result is the same for any number of threads.
CornerNormals::CornerNormals(const TriangleData& view, unsigned threads, const std::stop_token& stop) {
  constexpr std::uint64_t fewest_points = 1 << 12, points_per_check = 1 << 8;
  const std::uint64_t point_count = view.point_count();
  const CornersOfPoints corners(view);
  std::vector<std::uint32_t> first_other(point_count + 1);
  for_each_range(point_count, fewest_points, threads, [&](std::uint64_t first, std::uint64_t end) {
    Fans fans;
    for_each_until_stopped(first, end, points_per_check, stop, [&](std::uint64_t point) {
      fans.find(view, corners.at(point));
      first_other[point + 1] = static_cast<std::uint32_t>(std::max<std::size_t>(fans.normals().size(), 1) - 1);
    });
  });
  first_other[0] = static_cast<std::uint32_t>(point_count);
  for (std::uint64_t point = 0; point < point_count; ++point) first_other[point + 1] += first_other[point];
  normals_.resize(first_other.back(), Vec3(0, 0, 0));
  of_corners_.resize(view.triangle_count());
  for_each_range(point_count, fewest_points, threads, [&](std::uint64_t first, std::uint64_t end) {
    Fans fans;
    for_each_until_stopped(first, end, points_per_check, stop, [&](std::uint64_t point) {
      const std::span<const Corner> at_point = corners.at(point);
      fans.find(view, at_point);
      const auto place = [&](std::uint32_t slot) {
        return slot == 0 ? static_cast<std::uint32_t>(point) : first_other[point] + slot - 1;
      };
      for (std::uint32_t slot = 0; slot < fans.normals().size(); ++slot)
        normals_[place(slot)] = fans.normals()[slot].normalized();
      for (std::size_t i = 0; i < at_point.size(); ++i)
        of_corners_[at_point[i].triangle][at_point[i].index] = place(fans.slot(i));
    });
  });
}

}  // namespace rhoray::render

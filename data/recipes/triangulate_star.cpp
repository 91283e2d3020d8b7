#include "data/recipes/triangulate_star.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "formats/base/checks.h"

namespace rhoray::recipes {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

class Triangulator {
 public:
  Triangulator(const StarSurface& surface, const std::function<double(const Vec3&)>& edge_length)
      : surface_(surface), edge_length_(edge_length) {
    start_with_icosahedron();
    // halving lengths this often reaches any size; more rounds mean that the surface has gaps
    constexpr int most_rounds = 60;
    int rounds = 0;
    while (split_long_edges()) RHORAY_CHECK(++rounds < most_rounds && triangles_.size() < 100'000'000);
    for (int round = 0; round < 4; ++round) {
      for (int pass = 0; pass < 3; ++pass) flip_edges();
      smooth();
    }
    flip_edges();
  }

  Triangulation take() && { return {std::move(points_), std::move(triangles_)}; }

 private:
  void start_with_icosahedron() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    for (const Vec3& d :
         {Vec3(-1, g, 0), Vec3(1, g, 0), Vec3(-1, -g, 0), Vec3(1, -g, 0), Vec3(0, -1, g), Vec3(0, 1, g),
          Vec3(0, -1, -g), Vec3(0, 1, -g), Vec3(g, 0, -1), Vec3(g, 0, 1), Vec3(-g, 0, -1), Vec3(-g, 0, 1)})
      points_.push_back(surface_point(surface_, d));
    triangles_ = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  }

  double length2(std::uint32_t a, std::uint32_t b) const { return (points_[a] - points_[b]).length2(); }

  bool is_long(std::uint32_t a, std::uint32_t b) const {
    const double wanted = edge_length_(0.5 * (points_[a] + points_[b]));
    return length2(a, b) > wanted * wanted;
  }

  /// Index (0, 1, 2) of the corner where the longest edge begins. Edges of equal length are ordered
  /// by the edge itself, so that both neighbours agree.
  std::size_t longest_edge(const Triangle& t) const {
    std::size_t longest = 0;
    for (std::size_t i = 1; i < 3; ++i) {
      const auto rank = [&](std::size_t j) {
        return std::pair(length2(t[j], t[(j + 1) % 3]), edge_key(t[j], t[(j + 1) % 3]));
      };
      if (rank(i) > rank(longest)) longest = i;
    }
    return longest;
  }

  /// Splits every edge that is too long. To avoid thin triangles, it also splits the longest edge
  /// of each triangle that is split (Rivara). Returns true if any edge was split.
  bool split_long_edges() {
    // midpoint of each edge to split; the point numbers follow later
    std::unordered_map<std::uint64_t, std::uint32_t> middles;
    for (const Triangle& t : triangles_)
      for (std::size_t i = 0; i < 3; ++i)
        if (is_long(t[i], t[(i + 1) % 3])) middles.emplace(edge_key(t[i], t[(i + 1) % 3]), 0);
    if (middles.empty()) return false;
    for (bool grew = true; grew;) {
      grew = false;
      for (const Triangle& t : triangles_) {
        const bool is_split = middles.contains(edge_key(t[0], t[1])) || middles.contains(edge_key(t[1], t[2])) ||
                              middles.contains(edge_key(t[2], t[0]));
        if (!is_split) continue;
        const std::size_t i = longest_edge(t);
        grew = middles.emplace(edge_key(t[i], t[(i + 1) % 3]), 0).second || grew;
      }
    }
    const std::vector<Triangle> old = std::move(triangles_);
    triangles_.clear();
    for (const Triangle& t : old) split(t, middles);
    return true;
  }

  void split(const Triangle& t, std::unordered_map<std::uint64_t, std::uint32_t>& middles) {
    const std::size_t i = longest_edge(t);
    const std::uint32_t a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
    // 0: not split (0 is never a midpoint)
    const auto middle = [&](std::uint32_t p, std::uint32_t q) -> std::uint32_t {
      const auto found = middles.find(edge_key(p, q));
      if (found == middles.end()) return 0;
      if (found->second == 0) {
        found->second = static_cast<std::uint32_t>(points_.size());
        points_.push_back(surface_point(surface_, 0.5 * (points_[p] + points_[q]) - surface_.centre));
      }
      return found->second;
    };
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    if (ab == 0) {
      triangles_.push_back(t);
      return;
    }
    if (ca != 0)
      triangles_.insert(triangles_.end(), {{a, ab, ca}, {ca, ab, c}});
    else
      triangles_.push_back({a, ab, c});
    if (bc != 0)
      triangles_.insert(triangles_.end(), {{ab, b, bc}, {ab, bc, c}});
    else
      triangles_.push_back({ab, b, c});
  }

  /// Seen from the centre, the triangle is counter-clockwise with some area, and not turned away.
  bool faces_outward(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3 pa = points_[a] - surface_.centre, pb = points_[b] - surface_.centre, pc = points_[c] - surface_.centre;
    const Vec3 normal = (pb - pa).cross(pc - pa);
    return pa.dot(normal) > 0.05 * pa.length() * normal.length();
  }

  double angle_at(std::uint32_t corner, std::uint32_t p, std::uint32_t q) const {
    const Vec3 u = points_[p] - points_[corner], v = points_[q] - points_[corner];
    return std::atan2(u.cross(v).length(), u.dot(v));
  }

  /// Replaces an edge by the other diagonal where the two opposite angles add up to more than 180
  /// degrees.
  void flip_edges() {
    // triangle + 1 on either side
    std::unordered_map<std::uint64_t, std::pair<std::size_t, std::size_t>> sides;
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i) {
        auto& pair = sides[edge_key(triangles_[f][i], triangles_[f][(i + 1) % 3])];
        (pair.first == 0 ? pair.first : pair.second) = f + 1;
      }
    std::vector<bool> changed(triangles_.size());
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      for (std::size_t i = 0; i < 3 && !changed[f]; ++i) {
        const std::uint32_t a = triangles_[f][i], b = triangles_[f][(i + 1) % 3], c = triangles_[f][(i + 2) % 3];
        const auto pair = sides.at(edge_key(a, b));
        const std::size_t g = (pair.first == f + 1 ? pair.second : pair.first) - 1;
        if (changed[g]) continue;
        std::size_t j = 0;
        while (triangles_[g][j] == a || triangles_[g][j] == b) ++j;
        const std::uint32_t d = triangles_[g][j];
        if (angle_at(c, a, b) + angle_at(d, a, b) <= 3.1416 + 1e-3 || sides.contains(edge_key(c, d))) continue;
        if (!faces_outward(c, a, d) || !faces_outward(d, b, c)) continue;
        triangles_[f] = {c, a, d};
        triangles_[g] = {d, b, c};
        changed[f] = changed[g] = true;
        sides[edge_key(c, d)] = {f + 1, g + 1};
      }
  }

  /// Moves each point towards the centre of its neighbours, along the surface, unless that would
  /// fold a triangle.
  void smooth() {
    std::vector<std::vector<std::size_t>> around(points_.size());
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      for (const std::uint32_t corner : triangles_[f]) around[corner].push_back(f);
    for (std::uint32_t p = 0; p < points_.size(); ++p) {
      Vec3 sum(0);
      for (const std::size_t f : around[p])
        for (const std::uint32_t corner : triangles_[f])
          if (corner != p) sum += points_[corner];
      const Vec3 before = points_[p], middle = sum / static_cast<double>(2 * around[p].size());
      points_[p] = surface_point(surface_, 0.5 * (before + middle) - surface_.centre);
      const bool folds = std::any_of(around[p].begin(), around[p].end(), [&](std::size_t f) {
        return !faces_outward(triangles_[f][0], triangles_[f][1], triangles_[f][2]);
      });
      if (folds) points_[p] = before;
    }
  }

  const StarSurface& surface_;
  const std::function<double(const Vec3&)>& edge_length_;
  std::vector<Vec3> points_;
  std::vector<Triangle> triangles_;
};

}  // namespace

Vec3 surface_point(const StarSurface& surface, const Vec3& direction) {
  const Vec3 step = direction.normalized();
  double inside = 0, outside = surface.reach;
  RHORAY_CHECK(surface.outside_by(surface.centre) < 0 && surface.outside_by(surface.centre + outside * step) > 0);
  for (int halving = 0; halving < 34; ++halving) {
    const double middle = 0.5 * (inside + outside);
    (surface.outside_by(surface.centre + middle * step) < 0 ? inside : outside) = middle;
  }
  return surface.centre + 0.5 * (inside + outside) * step;
}

Triangulation triangulate(const StarSurface& surface, const std::function<double(const Vec3&)>& edge_length) {
  return Triangulator(surface, edge_length).take();
}

}  // namespace rhoray::recipes

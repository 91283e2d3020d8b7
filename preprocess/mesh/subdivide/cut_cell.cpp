#include "preprocess/mesh/subdivide/cut_cell.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace rhoray::preprocess {
namespace {

using Place = std::array<double, 3>;

/// Six times the volume, positive in VTK's orientation.
double volume6(const Place& p, const Place& a, const Place& b, const Place& c) {
  const Place u{a[0] - p[0], a[1] - p[1], a[2] - p[2]};
  const Place v{b[0] - p[0], b[1] - p[1], b[2] - p[2]};
  const Place w{c[0] - p[0], c[1] - p[1], c[2] - p[2]};
  return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2];
}

double volume6(const CutCell& cell, const CornerTetrahedron& tet) {
  return volume6(cell.places[tet[0]], cell.places[tet[1]], cell.places[tet[2]], cell.places[tet[3]]);
}

std::uint32_t lowest_corner(const CutCell& cell) {
  return static_cast<std::uint32_t>(std::min_element(cell.ids.begin(), cell.ids.end()) - cell.ids.begin());
}

bool names_a_point_twice(const CutCell& cell) {
  for (std::size_t i = 0; i < cell.ids.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (cell.ids[i] == cell.ids[j]) return true;
  return false;
}

/// Drops pairs of coincident triangles where a cell is folded onto itself; they separate nothing.
void drop_opposite_triangles(CutCell& cell) {
  const auto key = [&](const CornerTriangle& t) {
    std::array<std::uint64_t, 3> ids{cell.ids[t[0]], cell.ids[t[1]], cell.ids[t[2]]};
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  std::vector<CornerTriangle>& boundary = cell.boundary;
  for (std::size_t i = 0; i < boundary.size();) {
    const auto twin = std::find_if(boundary.begin() + static_cast<std::ptrdiff_t>(i) + 1, boundary.end(),
                                   [&](const CornerTriangle& other) { return key(other) == key(boundary[i]); });
    if (twin == boundary.end()) {
      ++i;
      continue;
    }
    boundary.erase(twin);
    boundary.erase(boundary.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void fan_from_corner(CutCell& cell, std::uint32_t apex) {
  cell.tets.clear();
  for (const CornerTriangle& t : cell.boundary) {
    const bool touches =
        std::any_of(t.begin(), t.end(), [&](auto corner) { return cell.ids[corner] == cell.ids[apex]; });
    if (!touches) cell.tets.push_back({apex, t[0], t[1], t[2]});
  }
}

/// Replaces three of a hexahedron's six tetrahedra by two, where three share the line from its
/// lowest corner to the opposite one. Of the two, one has the lowest corner and one the opposite
/// corner.
void join_three_across(CutCell& cell, std::uint32_t across) {
  const auto holds = [&](const CornerTetrahedron& tet) {
    return std::find(tet.begin(), tet.end(), across) != tet.end();
  };
  if (std::count_if(cell.tets.begin(), cell.tets.end(), holds) != 3) return;
  // Around `across`, the far sides of the three run x -> y -> z -> x.
  const auto far_side = [&](const CornerTetrahedron& tet) {
    const std::size_t at = static_cast<std::size_t>(std::find(tet.begin() + 1, tet.end(), across) - tet.begin());
    return std::array<std::uint32_t, 2>{tet[at % 3 + 1], tet[(at + 1) % 3 + 1]};
  };
  const auto first = std::find_if(cell.tets.begin(), cell.tets.end(), holds);
  const std::uint32_t lowest = (*first)[0];
  const auto [x, y] = far_side(*first);
  std::uint32_t z = x;
  for (const CornerTetrahedron& tet : cell.tets)
    if (holds(tet) && far_side(tet)[0] == y) z = far_side(tet)[1];
  if (z == x) return;
  std::erase_if(cell.tets, holds);
  cell.tets.push_back({lowest, x, y, z});
  cell.tets.push_back({across, x, z, y});
}

/// A volume that is negative only by rounding does not count as negative.
constexpr double volume_slack = 1e-10;

void count_inverted(CutCell& cell) {
  double whole = 0, sum_of_sizes = 0;
  for (const CornerTetrahedron& tet : cell.tets) {
    whole += volume6(cell, tet);
    sum_of_sizes += std::abs(volume6(cell, tet));
  }
  const double sign = whole < 0 ? -1 : 1;
  cell.inverted_count =
      static_cast<std::uint32_t>(std::count_if(cell.tets.begin(), cell.tets.end(), [&](const CornerTetrahedron& tet) {
        return sign * volume6(cell, tet) < -volume_slack * sum_of_sizes;
      }));
}

void turn_if_negative(CutCell& cell) {
  double whole = 0;
  for (const CornerTetrahedron& tet : cell.tets) whole += volume6(cell, tet);
  if (!(whole < 0)) return;
  for (CornerTriangle& t : cell.boundary) std::swap(t[1], t[2]);
  for (CornerTetrahedron& tet : cell.tets) std::swap(tet[2], tet[3]);
}

Place weighted_place(const CutCell& cell, const std::vector<double>& weights) {
  Place place{};
  for (std::size_t corner = 0; corner < weights.size(); ++corner)
    for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += weights[corner] * cell.places[corner][axis];
  return place;
}

/// Signed distance of a point from the plane of a triangle, positive inside.
struct InsideOf {
  const CutCell& cell;
  double sign;
  double operator()(const CornerTriangle& t, const Place& place) const {
    const Place &a = cell.places[t[0]], &b = cell.places[t[1]], &c = cell.places[t[2]];
    const Place u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double area2 = std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    return area2 > 0 ? sign * volume6(place, a, b, c) / area2 : std::numeric_limits<double>::infinity();
  }
};

/// Searches for a point that sees the whole boundary. It starts at the mean of the corners. Each
/// step moves away from the plane that is farthest on the wrong side, towards the corner farthest
/// on its right side. (This is fictitious play of the game "point against plane"; its value is the
/// size of the cell's kernel.)
bool find_center(CutCell& cell) {
  constexpr int most_steps = 400;
  double whole = 0, sum_of_sizes = 0;
  for (const CornerTetrahedron& tet : cell.tets) {
    whole += volume6(cell, tet);
    sum_of_sizes += std::abs(volume6(cell, tet));
  }
  const InsideOf inside{cell, whole < 0 ? -1.0 : 1.0};
  const auto sees_all = [&](const Place& place) {
    return std::all_of(cell.boundary.begin(), cell.boundary.end(), [&](const CornerTriangle& t) {
      return inside.sign * volume6(place, cell.places[t[0]], cell.places[t[1]], cell.places[t[2]]) >=
             -volume_slack * sum_of_sizes;
    });
  };
  std::vector<double> weights(cell.ids.size(), 1.0 / static_cast<double>(cell.ids.size()));
  for (int step = 0; step < most_steps; ++step) {
    const Place place = weighted_place(cell, weights);
    if (sees_all(place)) {
      cell.center_weights = std::move(weights);
      return true;
    }
    const auto worst = std::min_element(
        cell.boundary.begin(), cell.boundary.end(),
        [&](const CornerTriangle& a, const CornerTriangle& b) { return inside(a, place) < inside(b, place); });
    const auto best = std::max_element(cell.places.begin(), cell.places.end(), [&](const Place& a, const Place& b) {
      return inside(*worst, a) < inside(*worst, b);
    });
    const double share = 1.0 / (step + static_cast<double>(cell.ids.size()) + 1);
    for (double& weight : weights) weight *= 1 - share;
    weights[static_cast<std::size_t>(best - cell.places.begin())] += share;
  }
  return false;
}

void fan_from_center(CutCell& cell) {
  const auto center = static_cast<std::uint32_t>(cell.ids.size());
  cell.tets.clear();
  for (const CornerTriangle& t : cell.boundary) cell.tets.push_back({center, t[0], t[1], t[2]});
  cell.inverted_count = 0;
}

}  // namespace

void add_face(CutCell& cell, std::span<const std::uint32_t> corners) {
  const std::size_t count = corners.size();
  std::size_t lowest = 0;
  for (std::size_t i = 1; i < count; ++i)
    if (cell.ids[corners[i]] < cell.ids[corners[lowest]]) lowest = i;
  const auto corner = [&](std::size_t i) { return corners[(lowest + i) % count]; };
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const CornerTriangle t{corner(0), corner(i), corner(i + 1)};
    const auto a = cell.ids[t[0]], b = cell.ids[t[1]], c = cell.ids[t[2]];
    if (a != b && b != c && c != a) cell.boundary.push_back(t);
  }
}

void add_faces(CutCell& cell, const CellFrame& frame) {
  cell.boundary.clear();
  for (const CellFace& face : frame.faces) {
    std::array<std::uint32_t, 6> corners;
    std::copy_n(face.corners.begin(), face.corner_count, corners.begin());
    add_face(cell, std::span(corners).first(face.corner_count));
  }
}

std::uint32_t corner_across(const CutCell& cell, CellKind linear_kind) {
  constexpr std::uint32_t across_in_hexahedron[] = {6, 7, 4, 5, 2, 3, 0, 1};
  const std::uint32_t lowest = lowest_corner(cell);
  if (linear_kind == CellKind::hexahedron) return across_in_hexahedron[lowest];
  if (linear_kind == CellKind::voxel) return 7 - lowest;
  return CutRules::none;
}

void fill_cell(CutCell& cell, const CutRules& rules) {
  cell.center_weights.clear();
  const bool is_collapsed = names_a_point_twice(cell);
  if (is_collapsed) drop_opposite_triangles(cell);
  fan_from_corner(cell, lowest_corner(cell));
  if (!is_collapsed && rules.hexahedron_across != CutRules::none) join_three_across(cell, rules.hexahedron_across);
  if (rules.either_winding) turn_if_negative(cell);
  count_inverted(cell);
  if (cell.inverted_count > 0 && rules.may_add_center && find_center(cell)) fan_from_center(cell);
}

}  // namespace rhoray::preprocess

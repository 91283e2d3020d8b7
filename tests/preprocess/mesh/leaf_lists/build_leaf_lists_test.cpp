#include "preprocess/mesh/leaf_lists/build_leaf_lists.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/mesh/leaf_lists/choose_lattice.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using Real = long double;
using Point = std::array<Real, 3>;
using Polygon = std::vector<Point>;

/// A second road: a tetrahedron touches a box when something is left of one of its faces after
/// clipping it to the box, or when it holds the box's centre (then the box may lie wholly inside).
/// In units of leaf cells, long double.
class Clipping {
 public:
  Clipping(const formats::LeafLattice& lattice, const std::array<std::array<double, 3>, 4>& points) {
    for (std::size_t v = 0; v < 4; ++v)
      for (std::size_t a = 0; a < 3; ++a) {
        const int axis = static_cast<int>(a);
        p_[v][a] = (Real{points[v][a]} - Real{lattice.low[axis]}) / Real{lattice.leaf_size[axis]};
        low_[a] = v == 0 ? p_[v][a] : std::min(low_[a], p_[v][a]);
        high_[a] = v == 0 ? p_[v][a] : std::max(high_[a], p_[v][a]);
      }
  }

  /// Leaf cells of the tetrahedron's box, one more on every side.
  std::int64_t first(std::size_t axis) const { return static_cast<std::int64_t>(std::floor(low_[axis])) - 1; }
  std::int64_t last(std::size_t axis) const { return static_cast<std::int64_t>(std::floor(high_[axis])) + 1; }

  bool touches(const std::array<std::int64_t, 3>& leaf, Real grown) const {
    Point low, high, center;
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = static_cast<Real>(leaf[a]) - grown;
      high[a] = static_cast<Real>(leaf[a] + 1) + grown;
      center[a] = (low[a] + high[a]) / 2;
    }
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Polygon face;
      for (std::size_t v = 0; v < 4; ++v)
        if (v != opposite) face.push_back(p_[v]);
      for (std::size_t a = 0; a < 3; ++a) {
        face = clipped(face, a, low[a], 1);
        face = clipped(face, a, high[a], -1);
      }
      if (!face.empty()) return true;
    }
    return holds(center);
  }

 private:
  /// What lies on the side of the plane where sign * (coordinate - place) >= 0.
  static Polygon clipped(const Polygon& polygon, std::size_t axis, Real place, Real sign) {
    Polygon kept;
    for (std::size_t v = 0; v < polygon.size(); ++v) {
      const Point& from = polygon[v];
      const Point& to = polygon[(v + 1) % polygon.size()];
      const Real d_from = sign * (from[axis] - place), d_to = sign * (to[axis] - place);
      if (d_from >= 0) kept.push_back(from);
      if ((d_from >= 0) == (d_to >= 0)) continue;
      const Real t = d_from / (d_from - d_to);
      Point cut;
      for (std::size_t a = 0; a < 3; ++a) cut[a] = from[a] + t * (to[a] - from[a]);
      cut[axis] = place;
      kept.push_back(cut);
    }
    return kept;
  }

  static Real side(const Point& a, const Point& b, const Point& c, const Point& d) {
    Real m[3][3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      m[0][axis] = b[axis] - a[axis];
      m[1][axis] = c[axis] - a[axis];
      m[2][axis] = d[axis] - a[axis];
    }
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  }
  bool holds(const Point& q) const {
    const Real s[4] = {side(q, p_[1], p_[2], p_[3]), side(p_[0], q, p_[2], p_[3]), side(p_[0], p_[1], q, p_[3]),
                       side(p_[0], p_[1], p_[2], q)};
    return (s[0] > 0 && s[1] > 0 && s[2] > 0 && s[3] > 0) || (s[0] < 0 && s[1] < 0 && s[2] < 0 && s[3] < 0);
  }

  std::array<Point, 4> p_;
  Point low_, high_;
};

struct Verdict {
  std::uint64_t touches = 0;   ///< pairs of cell and leaf cell that touch
  std::uint64_t missing = 0;   ///< of these not in the list
  std::uint64_t needless = 0;  ///< in the list, but apart even from a leaf cell twice the margin larger
  std::uint64_t listed = 0;
};

Verdict judged(const NeutralMesh& mesh, double leaf_cell_count) {
  const CleanMesh clean = clean_mesh(mesh, "mesh");
  const auto lattice = choose_lattice(clean.box, {.leaf_cell_count = leaf_cell_count});
  const LeafLists lists = build_leaf_lists(clean.points, clean.cells, lattice);
  const formats::LeafListsView view = lists.view();
  const Index3 count = lattice.macro.leaf_count;

  Verdict verdict;
  verdict.listed = lists.items.size();
  std::uint64_t justified = 0;
  for (std::uint32_t c = 0; c < clean.cells.size(); ++c) {
    const auto& cell = clean.cells[c];
    const Clipping clipping(
        lattice, {clean.points[cell[0]], clean.points[cell[1]], clean.points[cell[2]], clean.points[cell[3]]});
    for (std::int64_t k = std::max<std::int64_t>(0, clipping.first(2)); k <= std::min(clipping.last(2), count.z - 1);
         ++k)
      for (std::int64_t j = std::max<std::int64_t>(0, clipping.first(1)); j <= std::min(clipping.last(1), count.y - 1);
           ++j)
        for (std::int64_t i = std::max<std::int64_t>(0, clipping.first(0));
             i <= std::min(clipping.last(0), count.x - 1); ++i) {
          const auto list = view.list(static_cast<std::uint64_t>((k * count.y + j) * count.x + i));
          const bool is_listed = std::binary_search(list.begin(), list.end(), c);
          const bool touches = clipping.touches({i, j, k}, 0);
          verdict.touches += touches;
          verdict.missing += touches && !is_listed;
          if (!is_listed) continue;
          if (touches || clipping.touches({i, j, k}, 2e-6L))
            ++justified;
          else
            ++verdict.needless;
        }
  }
  EXPECT_EQ(justified + verdict.needless, lists.items.size()) << "a cell is listed far from its own box, or twice";
  for (std::size_t leaf = 0; leaf + 1 < lists.offsets.size(); ++leaf) {
    const auto list = view.list(leaf);
    EXPECT_TRUE(std::is_sorted(list.begin(), list.end()));
  }
  return verdict;
}

struct Case {
  std::string name;
  NeutralMesh mesh;
  double leaf_cell_count;
};

std::vector<Case> cases() {
  std::vector<Case> made;
  made.push_back({"jittered", tests::box_mesh({.cells = {8, 7, 6}, .jitter = 0.15}), 8 * 7 * 6 * 6});
  made.push_back({"graded", tests::box_mesh({.cells = {8, 8, 8}, .grading = 40}), 3000});
  // Vertices, edges and faces on the planes between leaf cells, up to the lattice's small margin
  // and exactly.
  made.push_back({"lattice-aligned", tests::box_mesh({.cells = {8, 8, 8}}), 512});
  made.push_back({"one leaf cell", tests::box_mesh({.cells = {2, 2, 2}, .jitter = 0.1}), 1});
  made.push_back({"one layer", tests::box_mesh({.cells = {9, 9, 1}, .box = {{0, 0, 0}, {9, 9, 0.1}}}), 400});
  made.push_back(
      {"far away",
       tests::box_mesh(
           {.cells = {5, 5, 5}, .box = {{4e6, 8.5e6, -1e7}, {4e6 + 50, 8.5e6 + 40, -1e7 + 30}}, .jitter = 0.1}),
       900});
  made.push_back({"round, strewn", tests::strewn_mesh(300, 0.1, 1, 21), 4000});
  made.push_back({"slivers", tests::strewn_mesh(300, 0.15, 1e-9, 22), 4000});
  made.push_back({"flat but for rounding", tests::strewn_mesh(300, 0.15, 0, 23), 4000});
  made.push_back({"large cells", tests::strewn_mesh(20, 0.7, 1, 24), 4000});
  made.push_back({"tiny cells", tests::strewn_mesh(3000, 1e-4, 1, 25), 4000});
  return made;
}

TEST(LeafLists, miss_no_cell_that_touches_a_leaf_cell_and_list_none_needlessly) {
  for (const Case& one : cases()) {
    const Verdict verdict = judged(one.mesh, one.leaf_cell_count);
    EXPECT_EQ(verdict.missing, 0u) << one.name << " of " << verdict.touches;
    EXPECT_EQ(verdict.needless, 0u) << one.name << " of " << verdict.listed;
    EXPECT_GE(verdict.touches, one.mesh.cells.size()) << one.name;
  }
}

TEST(LeafLists, hold_exactly_flat_cells_that_lie_between_leaf_cells_on_both_sides) {
  // Leaf cells of edge 1 and a flat cell in the plane x = 2 between them.
  formats::LeafLattice lattice{.low = {0, 0, 0}, .leaf_size = {1, 1, 1}, .macro = {.leaf_count = {4, 4, 4}}};
  const std::vector<std::array<double, 3>> points{{2, 0.5, 0.5}, {2, 1.5, 0.5}, {2, 0.5, 1.5}, {2, 1.4, 1.4}};
  const std::vector<std::array<std::uint32_t, 4>> cells{{0, 1, 2, 3}};
  const LeafLists lists = build_leaf_lists(points, cells, lattice);
  for (std::int64_t leaf = 0; leaf < 64; ++leaf) {
    const std::int64_t i = leaf % 4, j = leaf / 4 % 4, k = leaf / 16;
    const bool expected = (i == 1 || i == 2) && j <= 1 && k <= 1;
    EXPECT_EQ(lists.view().list(static_cast<std::uint64_t>(leaf)).size(), expected ? 1u : 0u)
        << i << ' ' << j << ' ' << k;
  }
}

TEST(LeafLists, name_a_needle_along_the_diagonal_only_where_it_passes) {
  formats::LeafLattice lattice{.low = {0, 0, 0}, .leaf_size = {1, 1, 1}, .macro = {.leaf_count = {64, 64, 64}}};
  const std::vector<std::array<double, 3>> points{
      {0.5, 0.5, 0.5}, {63.5, 63.5, 63.5}, {0.5, 0.5001, 0.5}, {0.5, 0.5, 0.5001}};
  const std::vector<std::array<std::uint32_t, 4>> cells{{0, 1, 2, 3}};
  const LeafLists lists = build_leaf_lists(points, cells, lattice);
  EXPECT_LT(lists.items.size(), 64u * 8) << "its box holds 262144 leaf cells";
  for (std::uint64_t d = 0; d < 64; ++d) EXPECT_EQ(lists.view().list((d * 64 + d) * 64 + d).size(), 1u);
}

}  // namespace
}  // namespace rhoray::preprocess

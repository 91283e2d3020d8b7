#include "render/triangles/facet_neighbours.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "render/triangles/facets.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::FacetBlock;
using render::FacetField;
using render::FacetNeighbours;
using Corner = std::array<float, 3>;
using Corners = std::array<Corner, 4>;
using Turn = FacetNeighbours::Turn;

Corners corners_of(const FacetBlock* blocks, std::size_t f) {
  Corners corners;
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t a = 0; a < 3; ++a) corners[c][a] = blocks[f / 16].corner[c][a][f % 16];
  return corners;
}

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

// All edges of an isosurface, determined once more with a map. On the other side of each edge is
// the facet that shares it, whose own edge leads back; where a cell has no neighbour, there is
// nothing. An isosurface has a side with higher values, so all its facets have the same
// orientation.
TEST(FacetNeighbours, share_their_edges) {
  const TracedDataset traced(box_mesh({.cells = {9, 8, 7}, .jitter = 0.12}, waves), {});
  const auto& implementation = traced.dataset().implementation();
  const render::Facets facets(std::get<render::TetData>(implementation.view), implementation.bounds_data, 0.21, 1);
  const FacetNeighbours& neighbours = facets.neighbours();
  ASSERT_EQ(neighbours.count(), facets.count());
  EXPECT_EQ(&facets.neighbours(), &neighbours);
  EXPECT_EQ(neighbours.size_bytes(), 17 * std::size_t{facets.count()});
  std::map<std::set<Corner>, std::vector<std::uint32_t>> of_edges;
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const Corners corners = corners_of(facets.blocks(), f);
    for (std::size_t c = 0; c < 4; ++c) of_edges[{corners[c], corners[(c + 1) % 4]}].push_back(f);
  }
  std::size_t shared = 0, at_the_end = 0, triangles = 0;
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const Corners corners = corners_of(facets.blocks(), f);
    for (std::size_t c = 0; c < 4; ++c) {
      const FacetNeighbours::Beyond beyond = neighbours.of(f)[c];
      if (corners[c] == corners[(c + 1) % 4]) {
        EXPECT_EQ(beyond, neighbours.no_edge());
        ++triangles;
        continue;
      }
      const std::vector<std::uint32_t>& here = of_edges[{corners[c], corners[(c + 1) % 4]}];
      if (here.size() == 1) {
        EXPECT_EQ(beyond, neighbours.nothing());
        ++at_the_end;
        continue;
      }
      ASSERT_EQ(here.size(), 2U);
      EXPECT_EQ(FacetNeighbours::place_of(beyond), here[0] == f ? here[1] : here[0]);
      EXPECT_EQ(FacetNeighbours::is_alike(beyond), 1U);
      ++shared;
    }
  }
  EXPECT_GT(shared, 2000U);
  EXPECT_GT(at_the_end, 50U);
  EXPECT_GT(triangles, 200U);
  // The orientation also agrees with the direction in which the field rises.
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const Corners p = corners_of(facets.blocks(), f);
    const auto way = [&](std::size_t from, std::size_t to) {
      return Vec3(static_cast<double>(p[to][0]) - static_cast<double>(p[from][0]),
                  static_cast<double>(p[to][1]) - static_cast<double>(p[from][1]),
                  static_cast<double>(p[to][2]) - static_cast<double>(p[from][2]));
    };
    const Vec3 normal = way(0, 2).cross(way(1, 3));
    const double* g = facets.fields()[f].gradient;
    const double along = normal.dot(Vec3(g[0], g[1], g[2]));
    if (normal.length() < 1e-4) continue;
    EXPECT_EQ(neighbours.turns()[f], along > 0 ? Turn::counter_clockwise : Turn::clockwise);
  }
}

/// Facets in blocks, with a field that rises along z.
FacetNeighbours neighbours_of(const std::vector<Corners>& facets) {
  std::vector<FacetBlock> blocks((facets.size() + 15) / 16);
  std::vector<FacetField> fields(facets.size());
  for (FacetField& field : fields) field.gradient[2] = 1;
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t a = 0; a < 3; ++a) blocks[f / 16].corner[c][a][f % 16] = facets[f][c][a];
  return FacetNeighbours(blocks.data(), fields.data(), static_cast<std::uint32_t>(facets.size()));
}

constexpr Corner a{0, 0, 0}, b{1, 0, 0}, c{1, 1, 0}, d{0, 1, 0}, e{0.5F, 0.5F, 1}, f{0.5F, 0.5F, -1};

TEST(FacetNeighbours, are_alike_where_they_are_turned_alike) {
  // Two halves of a square, in both orders each, on both sides of the diagonal from a to c.
  for (const bool first_back : {false, true})
    for (const bool second_back : {false, true}) {
      const Corners first = first_back ? Corners{c, b, a, a} : Corners{a, b, c, c},
                    second = second_back ? Corners{d, c, a, a} : Corners{a, c, d, d};
      const FacetNeighbours neighbours = neighbours_of({first, second});
      EXPECT_EQ(neighbours.turns()[0], first_back ? Turn::clockwise : Turn::counter_clockwise);
      EXPECT_EQ(neighbours.turns()[1], second_back ? Turn::clockwise : Turn::counter_clockwise);
      int met = 0;
      for (const FacetNeighbours::Beyond beyond : neighbours.of(0)) {
        if (FacetNeighbours::place_of(beyond) != 1) continue;
        EXPECT_EQ(FacetNeighbours::is_alike(beyond), 1U);
        ++met;
      }
      EXPECT_EQ(met, 1);
    }
  // Folded along the diagonal, with both normals towards z: they are on the same side of the
  // diagonal.
  const FacetNeighbours folded = neighbours_of({{a, b, c, c}, {a, Corner{0.9F, 0.1F, 0.1F}, c, c}});
  EXPECT_EQ(folded.of(0)[3], 2 * 1U);
  EXPECT_EQ(folded.of(1)[3], 2 * 0U);
}

TEST(FacetNeighbours, are_none_where_three_meet) {
  for (int order = 0; order < 3; ++order) {
    std::vector<Corners> facets{{a, b, c, c}, {c, d, a, a}, {a, c, e, e}};
    std::swap(facets[0], facets[static_cast<std::size_t>(order)]);
    for (const bool fourth : {false, true}) {
      if (fourth) facets.push_back({c, a, f, f});
      const FacetNeighbours neighbours = neighbours_of(facets);
      for (std::uint32_t facet = 0; facet < facets.size(); ++facet)
        for (const FacetNeighbours::Beyond beyond : neighbours.of(facet))
          EXPECT_TRUE(beyond == neighbours.nothing() || beyond == neighbours.no_edge());
    }
  }
}

// Rounding hides or reverses the facet's orientation: its neighbours determine it. This also works
// for a thin facet next to another thin one.
TEST(FacetNeighbours, tell_how_thin_facets_are_turned) {
  for (const float off : {1e-7F, -1e-7F, 0.0F}) {
    const Corner on{0.5F, off, 0}, further{0.5F, 2 * off, 0};
    const Corner below{0.5F, -1, 0};
    const std::vector<Corners> facets{{a, on, b, b}, {on, further, b, b}, {below, b, a, a}};
    const FacetNeighbours neighbours = neighbours_of(facets);
    // `below` passes the edge from b to a; so the thin one passes it from a to b, which is the
    // reverse of its own order.
    EXPECT_EQ(neighbours.turns()[2], Turn::counter_clockwise);
    EXPECT_EQ(neighbours.turns()[0], Turn::clockwise) << off;
    EXPECT_EQ(neighbours.of(0)[3], 2 * 2U + 1);
    if (off == 0) continue;
    EXPECT_EQ(neighbours.turns()[1], Turn::clockwise) << off;
    EXPECT_EQ(neighbours.of(0)[1], 2 * 1U + 1);
  }
}

TEST(FacetNeighbours, of_zeros_there_is_one) {
  const Corner other_a{-0.0F, 0.0F, 0.0F};
  const FacetNeighbours neighbours = neighbours_of({{a, b, c, c}, {c, d, other_a, other_a}});
  EXPECT_EQ(FacetNeighbours::place_of(neighbours.of(0)[3]), 1U);
}

}  // namespace
}  // namespace rhoray::tests

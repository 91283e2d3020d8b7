#include "preprocess/workers/tetgen/enclosed_regions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace rhoray::preprocess {

namespace {

constexpr std::size_t not_reached = std::numeric_limits<std::size_t>::max();

double volume_of(const std::array<const double*, 4>& p) {
  const auto edge = [&](std::size_t i, std::size_t axis) { return p[i][axis] - p[0][axis]; };
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    sum += edge(1, i) * (edge(2, j) * edge(3, k) - edge(2, k) * edge(3, j));
  }
  return std::abs(sum);
}

/// Breadth first from the outside.
void set_depths(std::vector<EnclosedRegion>& regions, const std::set<std::pair<std::size_t, std::size_t>>& walls,
                std::vector<std::size_t> reached) {
  for (EnclosedRegion& region : regions) region.depth = not_reached;
  for (std::size_t depth = 1; !reached.empty(); ++depth) {
    std::vector<std::size_t> next;
    for (const std::size_t c : reached)
      if (regions[c].depth == not_reached) regions[c].depth = depth;
    for (const auto& [from, to] : walls)
      if (regions[from].depth == depth && regions[to].depth == not_reached) next.push_back(to);
    reached = std::move(next);
  }
}

}  // namespace

std::vector<EnclosedRegion> regions_of(const MeshWithRegions& mesh) {
  std::map<double, std::size_t> index_of;
  std::vector<EnclosedRegion> regions;
  std::vector<double> largest;
  std::vector<std::size_t> outer;
  std::set<std::pair<std::size_t, std::size_t>> walls;
  const auto region_of = [&](std::size_t cell) {
    const auto [place, is_new] = index_of.try_emplace(mesh.region[cell], regions.size());
    if (is_new) {
      regions.push_back({.number = mesh.region[cell], .first_point = std::numeric_limits<int>::max(), .seed = {}});
      largest.push_back(-1);
    }
    return place->second;
  };

  for (std::size_t cell = 0; cell < mesh.region.size(); ++cell) {
    const std::size_t c = region_of(cell);
    std::array<const double*, 4> p;
    for (std::size_t i = 0; i < 4; ++i) {
      const int corner = mesh.corners[cell * mesh.corners_per_cell + i];
      regions[c].first_point = std::min(regions[c].first_point, corner);
      p[i] = mesh.coordinates.data() + 3 * static_cast<std::size_t>(corner);
    }
    if (const double volume = volume_of(p); volume > largest[c]) {
      largest[c] = volume;
      for (std::size_t axis = 0; axis < 3; ++axis)
        regions[c].seed[axis] = (p[0][axis] + p[1][axis] + p[2][axis] + p[3][axis]) / 4;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const int neighbour = mesh.neighbours[4 * cell + i];
      if (neighbour < 0)
        outer.push_back(c);
      else if (const std::size_t other = region_of(static_cast<std::size_t>(neighbour)); other != c)
        walls.insert({c, other});
    }
  }
  set_depths(regions, walls, std::move(outer));
  std::sort(regions.begin(), regions.end(), [](const EnclosedRegion& a, const EnclosedRegion& b) {
    return std::tie(a.depth, a.first_point, a.number) < std::tie(b.depth, b.first_point, b.number);
  });
  return regions;
}

}  // namespace rhoray::preprocess

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace rhoray::preprocess {

/// Two triangles that meet elsewhere than in the corners or the edge that they share.
struct Crossing {
  std::uint64_t first = 0;  ///< positions in the list of triangles, first < second
  std::uint64_t second = 0;
  std::array<double, 3> place{};  ///< a point of both: the middle of what they have in common, rounded to doubles
};

struct Crossings {
  std::uint64_t pair_count = 0;
  std::vector<std::uint64_t> triangles;  ///< that cross any, in rising order
  std::vector<Crossing> first_pairs;     ///< in rising order, at most as many as asked for
};

/// Every pair of triangles that cross, decided by exact arithmetic. Triangles must have three
/// corners that are not collinear, and no two of them the same three corners; points are finite.
Crossings find_crossings(std::span<const std::array<double, 3>> points,
                         std::span<const std::array<std::uint64_t, 3>> triangles, std::size_t most_places);

/// True when the three points lie on one line (or coincide); exact.
bool are_collinear(const std::array<double, 3>& a, const std::array<double, 3>& b, const std::array<double, 3>& c);

/// True when all points lie in one plane; exact.
bool are_coplanar(std::span<const std::array<double, 3>> points);

}  // namespace rhoray::preprocess

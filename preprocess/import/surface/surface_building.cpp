#include "preprocess/import/surface/surface_building.h"

#include <bit>

namespace rhoray::preprocess {

std::size_t PointMerger::Hash::operator()(const std::array<std::uint64_t, 3>& bits) const {
  std::uint64_t hash = 0;
  for (const std::uint64_t word : bits) {
    // 2^64 / golden ratio: spreads close values
    hash = (hash ^ word) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 32;
  }
  return hash;
}

std::uint64_t PointMerger::position_of(const std::array<double, 3>& point) {
  std::array<std::uint64_t, 3> bits;
  for (std::size_t axis = 0; axis < 3; ++axis)
    bits[axis] = std::bit_cast<std::uint64_t>(point[axis] + 0.0);  // -0 -> +0
  const auto [found, is_new] = positions_.try_emplace(bits, surface_.points.size());
  if (is_new) surface_.points.push_back(point);
  return found->second;
}

void add_facet(NeutralSurface& surface, std::span<const std::uint64_t> corners, const std::filesystem::path& path,
               const std::string& place) {
  if (corners.size() < 3) refuse_input(path, place, concat("a facet with ", corners.size(), " corners"), "at least 3");
  for (const std::uint64_t corner : corners)
    if (corner >= surface.points.size())
      refuse_input(path, place, concat("corner ", static_cast<std::int64_t>(corner)),
                   concat("a point, 0 to ", static_cast<std::int64_t>(surface.points.size()) - 1));
  surface.facet_corners.insert(surface.facet_corners.end(), corners.begin(), corners.end());
  surface.facet_offsets.push_back(surface.facet_corners.size());
}

void finish_surface(const NeutralSurface& surface, const std::filesystem::path& path) {
  if (surface.facet_corners.empty()) refuse_input(path, "facets", "none", "at least one");
}

}  // namespace rhoray::preprocess

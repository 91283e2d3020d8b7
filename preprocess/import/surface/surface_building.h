#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>

#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Assigns one index to points that coincide exactly. +0 and -0 coincide; a NaN coincides with the
/// same NaN.
class PointMerger {
 public:
  explicit PointMerger(NeutralSurface& surface) : surface_(surface) {}
  std::uint64_t position_of(const std::array<double, 3>& point);

 private:
  struct Hash {
    std::size_t operator()(const std::array<std::uint64_t, 3>& bits) const;
  };
  NeutralSurface& surface_;
  std::unordered_map<std::array<std::uint64_t, 3>, std::uint64_t, Hash> positions_;
};

/// Appends one facet. Refuses fewer than three corners and corners that are not points.
/// @param place  location in the file, for messages
void add_facet(NeutralSurface& surface, std::span<const std::uint64_t> corners, const std::filesystem::path& path,
               const std::string& place);

/// Last step of every surface reader: refuses a surface without facets.
void finish_surface(const NeutralSurface& surface, const std::filesystem::path& path);

}  // namespace rhoray::preprocess

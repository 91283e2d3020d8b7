#pragma once

#include <cstdint>
#include <span>

namespace rhoray::study {

/// Differences of one system's hit distances from the true ones, ray by ray; infinity is a miss.
/// NaN in `found` is a hit at an unknown distance.
struct DepthErrors {
  std::uint64_t rays = 0, hits = 0;         ///< hits: true ones
  std::uint64_t missed = 0, invented = 0;   ///< true hits that were not found; found hits that do
                                            ///< not exist
  double median = 0, p99 = 0, largest = 0;  ///< |difference| in voxels, of hits that are true and
                                            ///< found
  double share_above_1 = 0;                 ///< as a fraction of these hits
  bool has_depth = true;                    ///< false: no distance was known, and the numbers above
                                            ///< are 0
};
DepthErrors depth_errors(std::span<const double> truth, std::span<const double> found, double voxel);

/// Largest values along rays against the true ones, in 8-bit levels of a window; NaN is no data.
struct LevelErrors {
  std::uint64_t rays = 0, with_data = 0;
  std::uint64_t missed = 0, invented = 0;  ///< true data that were not found; found data where
                                           ///< there are none
  double mean = 0, p99 = 0, largest = 0;
  double share_above_1 = 0;
};
LevelErrors level_errors(std::span<const double> truth, std::span<const double> found, double window);

}  // namespace rhoray::study

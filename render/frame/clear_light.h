#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "render/query/all_hits.h"
#include "render/query/batch.h"

namespace rhoray::render {

/// Crossings of a tile's rays with one transparent layer, and the share of the light that each
/// shows.
struct SharedLayer {
  double opacity = 0;
  const std::uint8_t* count = nullptr;                ///< crossings of each ray
  std::array<const double*, CrossingList::most> t{};  ///< t of the k-th crossings
  std::array<float*, CrossingList::most> share{};     ///< shares of the k-th crossings
  /// Number of entries of `share` that were written.
  std::size_t deepest = 0;
};

/// Result of sharing out light.
struct SharedLight {
  float* alpha;                          ///< light left for each ray
  std::uint64_t shown = 0, through = 0;  ///< crossings shown; those with light left behind them
};

/// Input of share_light_inline.
struct LightSharing {
  static constexpr std::size_t most_layers = 4, most = CrossingList::most, side_by_side = 16;
  using Rays = double[side_by_side];

  SharedLayer* layers;  ///< in the order in which crossings at equal t are shown
  std::size_t layer_count;
  /// For each ray 0 or 1; 1: the ray is skipped, as if it had no crossing.
  const std::uint8_t* is_left;
  std::size_t ray_count;  ///< shares are written for whole groups
  double least_light;     ///< crossings that less light reaches are not shown
};

/// Crossings of `side_by_side` rays.
struct SharedCrossings {
  LightSharing::Rays t[LightSharing::most_layers][LightSharing::most];  ///< infinity: no crossing
  /// Light that reaches the crossing.
  LightSharing::Rays light[LightSharing::most_layers][LightSharing::most];
  std::size_t deepest[LightSharing::most_layers];

  /// Reads the crossings. The light of each layer is computed as if there were no other layers.
  RHORAY_INLINE void read(const LightSharing& asked, std::size_t first) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (std::size_t l = 0; l < asked.layer_count; ++l) {
      const SharedLayer& layer = asked.layers[l];
      std::uint8_t count[LightSharing::side_by_side], largest = 0;
      for (std::size_t i = 0; i < LightSharing::side_by_side; ++i) {
        const std::size_t r = first + i;
        count[i] = r < asked.ray_count && asked.is_left[r] == 0 ? layer.count[r] : std::uint8_t{0};
        largest = count[i] > largest ? count[i] : largest;
      }
      deepest[l] = largest;
      double reaching = 1;
      for (std::size_t k = 0; k < largest; ++k, reaching *= 1 - layer.opacity)
        for (std::size_t i = 0; i < LightSharing::side_by_side; ++i) {
          t[l][k][i] = k < count[i] ? layer.t[k][first + i] : infinity;
          light[l][k][i] = reaching;
        }
    }
  }

  /// Attenuates the light of each crossing by the nearer crossings of the other layer; at equal t,
  /// `a` is first.
  RHORAY_INLINE void compare(const LightSharing& asked, std::size_t a, std::size_t b) {
    const double through_a = 1 - asked.layers[a].opacity, through_b = 1 - asked.layers[b].opacity;
    for (std::size_t j = 0; j < deepest[a]; ++j)
      for (std::size_t k = 0; k < deepest[b]; ++k)
        for (std::size_t i = 0; i < LightSharing::side_by_side; ++i) {
          const bool b_first = t[b][k][i] < t[a][j][i];
          light[a][j][i] *= b_first ? through_b : 1;
          light[b][k][i] *= b_first ? 1 : through_a;
        }
  }
};

/// Shares out the light of rays among their crossings with a few layers, in the order of t. Each
/// crossing attenuates the light for all crossings behind it. No ray is followed through its
/// crossings. The light that reaches a crossing is the product of the transmittances of all nearer
/// crossings. Every pair is compared, with rays side by side.
RHORAY_INLINE void share_light_inline(const LightSharing& asked, SharedLight& out) {
  constexpr std::size_t side_by_side = LightSharing::side_by_side;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < asked.layer_count; ++l) {
    std::uint8_t deepest = 0;
    for (std::size_t r = 0; r < asked.ray_count; ++r)
      deepest = asked.layers[l].count[r] > deepest ? asked.layers[l].count[r] : deepest;
    asked.layers[l].deepest = deepest;
  }
  const std::size_t end = (asked.ray_count + RayBatch::group_size - 1) / RayBatch::group_size * RayBatch::group_size;
  SharedCrossings crossings;
  for (std::size_t first = 0; first < end; first += side_by_side) {
    crossings.read(asked, first);
    for (std::size_t a = 0; a < asked.layer_count; ++a)
      for (std::size_t b = a + 1; b < asked.layer_count; ++b) crossings.compare(asked, a, b);
    LightSharing::Rays left, shown, through;
    for (std::size_t i = 0; i < side_by_side; ++i) left[i] = 1, shown[i] = through[i] = 0;
    for (std::size_t l = 0; l < asked.layer_count; ++l) {
      const SharedLayer& layer = asked.layers[l];
      const double opacity = layer.opacity, passing = 1 - opacity;
      for (std::size_t k = crossings.deepest[l]; k < layer.deepest; ++k)
        for (std::size_t i = 0; i < side_by_side; ++i) layer.share[k][first + i] = 0;
      for (std::size_t k = 0; k < crossings.deepest[l]; ++k)
        for (std::size_t i = 0; i < side_by_side; ++i) {
          const double light = crossings.light[l][k][i];
          const bool is_shown = crossings.t[l][k][i] < infinity && light >= asked.least_light;
          const double here = is_shown ? light : 0, behind = here * passing;
          layer.share[k][first + i] = static_cast<float>(here * opacity);
          left[i] = is_shown && behind < left[i] ? behind : left[i];
          shown[i] += is_shown ? 1 : 0;
          through[i] += is_shown && behind >= asked.least_light ? 1 : 0;
        }
    }
    for (std::size_t i = 0; i < side_by_side; ++i) {
      out.alpha[first + i] = static_cast<float>(left[i]);
      out.shown += static_cast<std::uint64_t>(shown[i]), out.through += static_cast<std::uint64_t>(through[i]);
    }
  }
}

}  // namespace rhoray::render

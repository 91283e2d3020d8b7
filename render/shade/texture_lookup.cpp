#include "render/shade/texture_lookup.h"

#include <array>
#include <cmath>

#include "render/query/compiled_for.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;

using View = TextureLookup::View;

/// The sRGB curve (IEC 61966-2-1).
std::array<float, 256> srgb_decoded() {
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double encoded = static_cast<double>(i) / 255;
    linear[i] = static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4));
  }
  return linear;
}

/// Positions of a group's hits among the texels.
struct alignas(64) TexelPlaces {
  /// The texel at or before the hit; undefined if none is read.
  std::int32_t before[3][group_size];
  float weight[3][group_size];       ///< of the next texel
  std::int32_t is_read[group_size];  ///< 1 or 0
};

RHORAY_INLINE void find_places(const View& view, const RayBatch& rays, const HitBatch& hits, std::size_t first,
                               const float* shown, TexelPlaces& places) {
  const double* t = hits.t.data() + first;
  const double *ox = rays.origin[0].data() + first, *oy = rays.origin[1].data() + first,
               *oz = rays.origin[2].data() + first;
  const double *dx = rays.direction[0].data() + first, *dy = rays.direction[1].data() + first,
               *dz = rays.direction[2].data() + first;
  for (std::size_t i = 0; i < group_size; ++i) places.is_read[i] = shown[i] > 0 ? 1 : 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double of_x = view.grid_from_data.x_axis[axis], of_y = view.grid_from_data.y_axis[axis],
                 of_z = view.grid_from_data.z_axis[axis], origin = view.grid_from_data.origin[axis];
    const auto last = static_cast<double>(view.last[axis]);
    std::int32_t* before = places.before[axis];
    float* weight = places.weight[axis];
    for (std::size_t i = 0; i < group_size; ++i) {
      const double at =
          ((ox[i] + t[i] * dx[i]) * of_x + (oy[i] + t[i] * dy[i]) * of_y) + ((oz[i] + t[i] * dz[i]) * of_z + origin);
      const double after_first = at > 0 ? at : 0;  // written so that a NaN becomes 0
      const double inside = after_first < last ? after_first : last;
      places.is_read[i] &= at >= -0.5 ? 1 : 0;
      places.is_read[i] &= at <= last + 0.5 ? 1 : 0;
      before[i] = static_cast<std::int32_t>(inside);
      weight[i] = static_cast<float>(inside - static_cast<double>(before[i]));
    }
  }
}

/// Red, green, blue and the covered share. Eight texels are mixed in this type, hit by hit.
/// Gathering single components for many hits at once takes twice the time of the whole lookup (on
/// processors that guard against gather data sampling).
using Light [[gnu::vector_size(16)]] = float;

/// Premultiplied light of a texel of N components.
template <int N>
RHORAY_INLINE Light light_of(const float* linear, const std::uint8_t* texel) {
  static_assert(N == 3 || N == 4);
  Light light{linear[texel[0]], linear[texel[1]], linear[texel[2]], 1};
  if constexpr (N == 4) light *= static_cast<float>(texel[3]) * (1.0F / 255);
  return light;
}

/// Interpolates; exactly a if both are equal.
RHORAY_INLINE Light between(const Light& a, const Light& b, float share) {
  return a + share * (b - a);
}

/// Mixes the texels around the hit in lane i of its group.
template <int N>
RHORAY_INLINE Light mixed_texels(const View& view, const TexelPlaces& places, std::size_t i) {
  const auto behind = [&](int axis) {
    const std::int32_t before = places.before[axis][i];
    return before < view.last[axis] ? before + 1 : before;
  };
  const std::uint8_t* left = view.texels + N * view.x[places.before[0][i]];
  const std::uint8_t* right = view.texels + N * view.x[behind(0)];
  const std::uint64_t y[2] = {N * view.y[places.before[1][i]], N * view.y[behind(1)]},
                      z[2] = {N * view.z[places.before[2][i]], N * view.z[behind(2)]};
  const auto row = [&](std::uint64_t at) {
    return between(light_of<N>(view.linear, left + at), light_of<N>(view.linear, right + at), places.weight[0][i]);
  };
  const auto layer = [&](std::uint64_t at) { return between(row(y[0] + at), row(y[1] + at), places.weight[1][i]); };
  return between(layer(z[0]), layer(z[1]), places.weight[2][i]);
}

template <int N>
RHORAY_INLINE void look_up(const View& view, const RayBatch& rays, const HitBatch& hits, std::size_t first,
                           const float* shown, CoveringColors& colors, int& count) {
  TexelPlaces places;
  find_places(view, rays, hits, first, shown, places);
  count = 0;
  for (std::size_t i = 0; i < group_size; ++i) {
    Light light{0, 0, 0, 0};
    if (places.is_read[i] != 0) light = mixed_texels<N>(view, places, i);
    colors.red[i] = light[0], colors.green[i] = light[1], colors.blue[i] = light[2], colors.share[i] = light[3];
    count += places.is_read[i];
  }
}

}  // namespace

TextureLookup::TextureLookup(const formats::ColorGrid& grid, const Affine& grid_from_data, Machine machine) {
  static const std::array<float, 256> linear = srgb_decoded();
  const formats::ColorGridDescription& description = grid.description();
  const formats::AxisTables& tables = grid.tables();
  const Index3 last = description.layout.sample_count - Index3(1, 1, 1);
  view_ = {
      .texels = grid.texels().data(),
      .x = tables.x.data(),
      .y = tables.y.data(),
      .z = tables.z.data(),
      .last = {static_cast<std::int32_t>(last.x), static_cast<std::int32_t>(last.y), static_cast<std::int32_t>(last.z)},
      .grid_from_data = grid_from_data,
      .linear = linear.data()};
  look_up_ = description.has_alpha() ? compiled_for<look_up<4>>(machine) : compiled_for<look_up<3>>(machine);
}

}  // namespace rhoray::render

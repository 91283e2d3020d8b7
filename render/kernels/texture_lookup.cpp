#include "render/kernels/texture_lookup.h"

#include <array>
#include <cmath>
#include <cstring>

#include "render/kernels/compiled_for.h"

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

/// Where the hits of a group lie among the texels.
struct alignas(64) TexelPlaces {
  std::int32_t before[3][group_size];  ///< the texel at or before the hit; any number where none is read
  float weight[3][group_size];         ///< of the texel behind it
  std::int32_t is_read[group_size];    ///< 1 or 0
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
    const double of_x = view.grid_from_volume.x_axis[axis], of_y = view.grid_from_volume.y_axis[axis],
                 of_z = view.grid_from_volume.z_axis[axis], origin = view.grid_from_volume.origin[axis];
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

/// N components of a texel, the first one lowest; of three the fourth is any number.
template <int N>
RHORAY_INLINE std::uint32_t texel_at(const std::uint8_t* texel) {
  static_assert(N == 3 || N == 4);
  if constexpr (N == 4) {
    std::uint32_t components;
    std::memcpy(&components, texel, sizeof components);
    return components;
  }
  std::uint16_t low;
  std::memcpy(&low, texel, sizeof low);
  return low | std::uint32_t{texel[2]} << 16;
}

struct alignas(64) Corners {
  std::uint32_t texel[8][group_size];
};

template <int N>
RHORAY_INLINE void read_corners(const View& view, const TexelPlaces& places, Corners& corners) {
  for (std::size_t i = 0; i < group_size; ++i) {
    if (places.is_read[i] == 0) {
      for (auto& corner : corners.texel) corner[i] = 0;
      continue;
    }
    const auto table_entries = [&](int axis, const std::uint64_t* table, std::uint64_t* entries) {
      const std::int32_t before = places.before[axis][i], behind = before < view.last[axis] ? before + 1 : before;
      entries[0] = table[before], entries[1] = table[behind];
    };
    std::uint64_t x[2], y[2], z[2];
    table_entries(0, view.x, x), table_entries(1, view.y, y), table_entries(2, view.z, z);
    for (unsigned c = 0; c < 8; ++c)
      corners.texel[c][i] = texel_at<N>(view.texels + N * (x[c & 1] + y[c >> 1 & 1] + z[c >> 2]));
  }
}

template <int N>
RHORAY_INLINE void mix_corners(const View& view, const TexelPlaces& places, const Corners& corners,
                               CoveringColors& colors) {
  for (std::size_t i = 0; i < group_size; ++i) colors.red[i] = colors.green[i] = colors.blue[i] = colors.share[i] = 0;
  for (unsigned c = 0; c < 8; ++c)
    for (std::size_t i = 0; i < group_size; ++i) {
      const float x = places.weight[0][i], y = places.weight[1][i], z = places.weight[2][i];
      const std::uint32_t texel = corners.texel[c][i];
      float weight = (c & 1 ? x : 1 - x) * (c >> 1 & 1 ? y : 1 - y) * (c >> 2 ? z : 1 - z);
      if constexpr (N == 4) weight *= static_cast<float>(static_cast<std::int32_t>(texel >> 24)) * (1.0F / 255);
      weight = places.is_read[i] != 0 ? weight : 0;
      colors.red[i] += weight * view.linear[texel & 255];
      colors.green[i] += weight * view.linear[texel >> 8 & 255];
      colors.blue[i] += weight * view.linear[texel >> 16 & 255];
      if constexpr (N == 4) colors.share[i] += weight;
    }
  if constexpr (N == 3)
    for (std::size_t i = 0; i < group_size; ++i) colors.share[i] = static_cast<float>(places.is_read[i]);
}

template <int N>
RHORAY_INLINE void look_up(const View& view, const RayBatch& rays, const HitBatch& hits, std::size_t first,
                           const float* shown, CoveringColors& colors, int& count) {
  TexelPlaces places;
  Corners corners;
  find_places(view, rays, hits, first, shown, places);
  read_corners<N>(view, places, corners);
  mix_corners<N>(view, places, corners, colors);
  count = 0;
  for (std::size_t i = 0; i < group_size; ++i) count += places.is_read[i];
}

/// a * b: target_from_source of b's source.
Affine composed(const Affine& a, const Affine& b) {
  return {a.vector(b.x_axis), a.vector(b.y_axis), a.vector(b.z_axis), a.point(b.origin)};
}

}  // namespace

TextureLookup::TextureLookup(const formats::ColorGrid& grid, const Affine& world_from_volume, Machine machine) {
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
      .grid_from_volume = composed(description.world_from_grid.inverse(), world_from_volume),
      .linear = linear.data()};
  look_up_ = description.has_alpha() ? compiled_for<look_up<4>>(machine) : compiled_for<look_up<3>>(machine);
}

}  // namespace rhoray::render

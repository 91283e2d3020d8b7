#include "render/frame/pixels.h"

#include <algorithm>
#include <limits>

#include "render/frame/streaming.h"
#include "render/query/compiled_for.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;
constexpr double infinity = std::numeric_limits<double>::infinity();

bool is_hit(const HitBatch& hits, std::size_t r) {
  return hits.t[r] < infinity;
}

/// Writes 1 for the lanes of a group that are shown, else 0, and returns their number.
template <class IsShown>
RHORAY_INLINE int find_shown(const IsShown& is_shown, Lanes& share) {
  for (std::size_t i = 0; i < group_size; ++i) share[i] = is_shown(i) ? 1 : 0;
  float count = 0;
  for (std::size_t i = 0; i < group_size; ++i) count += share[i];
  return static_cast<int>(count);
}

/// One group of a tile's colours.
struct GroupColors {
  float *red, *green, *blue, *alpha;
};
RHORAY_INLINE GroupColors group_of(TileColors& colors, std::size_t first) {
  return {colors.red + first, colors.green + first, colors.blue + first, colors.alpha + first};
}

/// Looks up what effects need at the shown hits of a group. Hits that are not shown keep their own
/// gradient: it decides on which side of the surface a ray goes on, once they are.
RHORAY_INLINE void look_up(const LayerShading& shading, LayerWork& work, std::size_t first, const Lanes& shown,
                           double* field_values) {
  double own[3][group_size];
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < group_size; ++i) own[axis][i] = work.hits.gradient[axis].data()[first + i];
  (*shading.lookup)(work.rays, work.hits, first, field_values);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double* gradient = work.hits.gradient[axis].data() + first;
    for (std::size_t i = 0; i < group_size; ++i) gradient[i] = shown[i] > 0 ? gradient[i] : own[axis][i];
  }
}

/// Calls act(first, shown lanes, their colours) for groups with shown hits of a layer.
/// @param is_shown  (ray of the batch)
template <class IsShown, class Act>
RHORAY_INLINE void for_each_shown_group(const LayerShading& shading, LayerWork& work, const ReceivedLight& received,
                                        const IsShown& is_shown, WorkerCounts& counts, const Act& act) {
  const Surroundings surroundings{
      .lights = &shading.lights, .received = &received, .fog = shading.fog ? &*shading.fog : nullptr};
  for (std::size_t first = 0; first < work.rays.count; first += group_size) {
    Lanes shown;
    const int count = find_shown([&](std::size_t i) { return is_shown(first + i); }, shown);
    if (count == 0) continue;
    Colors colors;
    double field_values[group_size];
    if (shading.lookup) look_up(shading, work, first, shown, field_values);
    CoveringColors texture;
    if (shading.texture)
      counts.texture_lookups +=
          static_cast<std::uint64_t>((*shading.texture)(work.rays, work.hits, first, shown.data(), texture));
    const double* values = shading.layer.mode == Mode::slice ? work.hits.value.data() + first : field_values;
    shade(shading.layer, shading.effects, shading.facing, work.rays, work.hits, first, values, colors, surroundings,
          &texture);
    act(first, shown, colors);
    const auto hit_count = static_cast<std::uint64_t>(count);
    if (shading.effects.specular) counts.highlights += hit_count;
    if (shading.effects.smooth_normals) counts.smooth_normals += hit_count;
    if (shading.effects.field_color && shading.lookup) counts.field_values += hit_count;
  }
}

RHORAY_INLINE void put(const Lanes& color, const Lanes& shown, float* out) {
  for (std::size_t i = 0; i < group_size; ++i) out[i] = shown[i] > 0 ? color[i] : out[i];
}

RHORAY_INLINE void put_group(const Lanes& shown, const Colors& colors, const GroupColors& out) {
  put(colors.red, shown, out.red);
  put(colors.green, shown, out.green);
  put(colors.blue, shown, out.blue);
  put(shown, shown, out.alpha);
}

RHORAY_INLINE void shade_hits_inline(const LayerShading& shading, LayerWork& work, const ReceivedLight& received,
                                     WorkerCounts& counts, TileColors& colors) {
  double* t = work.hits.t.data();
  // Empty lanes of the last group.
  for (std::size_t r = work.rays.count; r % group_size != 0; ++r) t[r] = infinity;
  for_each_shown_group(
      shading, work, received, [t](std::size_t r) { return t[r] < infinity; }, counts,
      [&](std::size_t first, const Lanes& shown, const Colors& shaded) {
        put_group(shown, shaded, group_of(colors, first));
      });
}

RHORAY_INLINE void shade_shown_inline(const LayerShading& shading, LayerWork& work, const LayerOfRays& shown,
                                      std::uint8_t layer, const ReceivedLight& received, WorkerCounts& counts,
                                      TileColors& colors) {
  for_each_shown_group(
      shading, work, received, [&](std::size_t r) { return shown.of[r] == layer; }, counts,
      [&](std::size_t first, const Lanes& lanes, const Colors& shaded) {
        put_group(lanes, shaded, group_of(colors, first));
      });
}

/// Adds light, attenuated by what is in front of it.
RHORAY_INLINE void add_through(const Lanes& color, const Lanes& share, float* out) {
  for (std::size_t i = 0; i < group_size; ++i) out[i] += share[i] > 0 ? share[i] * color[i] : 0;
}

RHORAY_INLINE void shade_clear_inline(const LayerShading& shading, LayerWork& work, const LayerOfRays& next,
                                      std::uint8_t layer, const ReceivedLight& received, WorkerCounts& counts,
                                      TileColors& front) {
  const auto opacity = static_cast<float>(shading.layer.material.opacity);
  for_each_shown_group(
      shading, work, received, [&](std::size_t r) { return next.of[r] == layer; }, counts,
      [&](std::size_t first, Lanes share, const Colors& shaded) {
        const GroupColors out = group_of(front, first);
        for (std::size_t i = 0; i < group_size; ++i) {
          share[i] *= opacity * out.alpha[i];
          out.alpha[i] -= share[i];
        }
        add_through(shaded.red, share, out.red);
        add_through(shaded.green, share, out.green);
        add_through(shaded.blue, share, out.blue);
      });
}

/// Light up to 512 becomes a multiple of 2^-42; sums of these up to 2048 are exact in any order.
RHORAY_INLINE void add_exactly(const Lanes& color, const Lanes& share, double* out) {
  constexpr double unit = 1536;  // numbers from 1024 to 2048 are such multiples
  for (std::size_t i = 0; i < group_size; ++i) {
    const double light = share[i] > 0 ? static_cast<double>(share[i]) * static_cast<double>(color[i]) : 0.0;
    out[i] += light + unit - unit;
  }
}

RHORAY_INLINE void add_clear_inline(const LayerShading& shading, LayerWork& work, const float* shares,
                                    const ReceivedLight& received, WorkerCounts& counts, LightSums& light) {
  for_each_shown_group(
      shading, work, received, [&](std::size_t r) { return shares[r] > 0; }, counts,
      [&](std::size_t first, Lanes share, const Colors& shaded) {
        for (std::size_t i = 0; i < group_size; ++i) share[i] = shares[first + i];
        add_exactly(shaded.red, share, light.red.data() + first);
        add_exactly(shaded.green, share, light.green.data() + first);
        add_exactly(shaded.blue, share, light.blue.data() + first);
      });
}

RHORAY_INLINE void composite_mip_inline(const LayerShading& shading, LayerWork& work, const ReceivedLight& received,
                                        WorkerCounts& counts, TileColors& colors) {
  double* t = work.hits.t.data();
  for (std::size_t r = work.rays.count; r % group_size != 0; ++r) t[r] = infinity;
  for_each_shown_group(
      shading, work, received, [t](std::size_t r) { return t[r] < infinity; }, counts,
      [&](std::size_t first, const Lanes& shown, const Colors& light) {
        const GroupColors out = group_of(colors, first);
        for (std::size_t i = 0; i < group_size; ++i) {
          // weights of red, green and blue light; what is brightest covers the background
          const float red = shown[i] > 0 ? light.red[i] : 0, green = shown[i] > 0 ? light.green[i] : 0,
                      blue = shown[i] > 0 ? light.blue[i] : 0;
          const float brighter = red > green ? red : green, share = brighter > blue ? brighter : blue;
          out.red[i] += red * (1 - out.red[i]);
          out.green[i] += green * (1 - out.green[i]);
          out.blue[i] += blue * (1 - out.blue[i]);
          out.alpha[i] += share * (1 - out.alpha[i]);
        }
      });
}

RHORAY_INLINE std::size_t pixel_at(const PixelLattice& lattice, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(lattice.width) + static_cast<std::size_t>(x);
}

/// Calls write(r, pixel) for every pixel that the tile's ray r fills.
template <class Write>
RHORAY_INLINE void for_each_pixel(const PixelLattice& lattice, const Tile& tile, const Write& write) {
  if (lattice.spacing == 1) {
    for_each_run(tile, [&](const Run& run) {
      const std::size_t pixel = pixel_at(lattice, run.x, run.y);
      if (run.count == block_edge)
        for (std::size_t i = 0; i < block_edge; ++i) write(run.first + i, pixel + i);
      else
        for (std::size_t i = 0; i < static_cast<std::size_t>(run.count); ++i) write(run.first + i, pixel + i);
    });
    return;
  }
  for_each_run(tile, [&](const Run& run) {
    const int y_begin = lattice.y_first + run.y * lattice.spacing;
    const int y_end = std::min(y_begin + lattice.extent, lattice.height);
    for (int i = 0; i < run.count; ++i) {
      const int x_begin = lattice.x_first + (run.x + i) * lattice.spacing;
      const int x_end = std::min(x_begin + lattice.extent, lattice.width);
      for (int y = y_begin; y < y_end; ++y)
        for (int x = x_begin; x < x_end; ++x) write(run.first + static_cast<std::size_t>(i), pixel_at(lattice, x, y));
    }
  });
}

/// Writes pixels side by side.
template <std::size_t count>
RHORAY_INLINE void write_run(const TileColors& colors, std::size_t first, float* __restrict out) {
  for (std::size_t i = 0; i < count; ++i) {
    out[4 * i] = colors.red[first + i];
    out[4 * i + 1] = colors.green[first + i];
    out[4 * i + 2] = colors.blue[first + i];
    out[4 * i + 3] = colors.alpha[first + i];
  }
}

RHORAY_INLINE void write_colors_inline(const PixelLattice& lattice, const Tile& tile, const TileColors& colors,
                                       float* out) {
  if (lattice.spacing != 1) {
    for_each_pixel(lattice, tile, [&](std::size_t r, std::size_t pixel) { write_run<1>(colors, r, out + 4 * pixel); });
    return;
  }
  for_each_run(
      tile, [&](const Run& run) __attribute__((always_inline)) {
        float* to = out + 4 * pixel_at(lattice, run.x, run.y);
        if (run.count == block_edge && begins_line(to)) {
          alignas(64) float pixels[4 * block_edge];
          write_run<block_edge>(colors, run.first, pixels);
          return stream_lines<sizeof pixels / 64>(pixels, to);
        }
        if (run.count == block_edge) return write_run<block_edge>(colors, run.first, to);
        for (std::size_t i = 0; i < static_cast<std::size_t>(run.count); ++i)
          write_run<1>(colors, run.first + i, to + 4 * i);
      });
}

/// Calls fill(pixel, count) for all runs of pixels that the rays of a tile's untraced blocks fill.
template <class Fill>
void for_each_background_run(const PixelLattice& lattice, const Tile& tile, const Fill& fill) {
  for_each_untraced_run(tile, [&](int first, int row, int count) {
    const int y_begin = lattice.y_first + row * lattice.spacing;
    const int y_end = std::min(y_begin + lattice.extent, lattice.height);
    // No pixels of other lattices between them.
    const bool is_closed = lattice.extent == lattice.spacing;
    const int step = is_closed ? count : 1;
    for (int x = first; x < first + count; x += step) {
      const int x_begin = lattice.x_first + x * lattice.spacing;
      const int x_end = std::min(x_begin + (step - 1) * lattice.spacing + lattice.extent, lattice.width);
      for (int y = y_begin; y < y_end; ++y)
        fill(pixel_at(lattice, x_begin, y), static_cast<std::size_t>(x_end - x_begin));
    }
  });
}

void fill_colors(const float (&color)[4], float* to, std::size_t count) {
  alignas(64) float line[line_floats];
  for (std::size_t i = 0; i < line_floats; ++i) line[i] = color[i % 4];
  std::size_t i = 0;
  for (; i < count && !begins_line(to + 4 * i); ++i) std::copy_n(color, 4, to + 4 * i);
  for (; i + line_floats / 4 <= count; i += line_floats / 4) stream_lines<1>(line, to + 4 * i);
  for (; i < count; ++i) std::copy_n(color, 4, to + 4 * i);
}

/// Largest error of the hits; 0 if there are none.
double largest_error_of(const HitBatch& hits, std::size_t count) {
  constexpr std::size_t abreast = 8;  // independent lanes hide the latency of the maximum
  double largest[abreast] = {};
  const auto take = [&](std::size_t r, double& so_far) {
    const double error = is_hit(hits, r) ? hits.error[r] : 0;
    so_far = error > so_far ? error : so_far;
  };
  std::size_t r = 0;
  for (; r + abreast <= count; r += abreast)
    for (std::size_t lane = 0; lane < abreast; ++lane) take(r + lane, largest[lane]);
  for (; r < count; ++r) take(r, largest[0]);
  return *std::max_element(largest, largest + abreast);
}

}  // namespace

void fill_background(const Vec3& background, std::size_t count, TileColors& colors) {
  count = (count + group_size - 1) / group_size * group_size;
  std::fill_n(colors.red, count, static_cast<float>(background.x));
  std::fill_n(colors.green, count, static_cast<float>(background.y));
  std::fill_n(colors.blue, count, static_cast<float>(background.z));
  std::fill_n(colors.alpha, count, 0.0F);
}

void shade_hits(const LayerShading& shading, LayerWork& work, const ReceivedLight& received, WorkerCounts& counts,
                TileColors& colors) {
  compiled_for<shade_hits_inline>(shading.machine)(shading, work, received, counts, colors);
  if (shading.proves)
    counts.largest_error = std::max(counts.largest_error, largest_error_of(work.hits, work.rays.count));
}

void shade_shown(const LayerShading& shading, LayerWork& work, const LayerOfRays& shown, std::uint8_t layer,
                 const ReceivedLight& received, WorkerCounts& counts, TileColors& colors) {
  compiled_for<shade_shown_inline>(shading.machine)(shading, work, shown, layer, received, counts, colors);
  if (!shading.proves) return;
  for (std::size_t r = 0; r < work.rays.count; ++r)
    if (shown.of[r] == layer) counts.largest_error = std::max(counts.largest_error, work.hits.error[r]);
}

void begin_front(std::size_t count, TileColors& front) {
  fill_background({0, 0, 0}, count, front);
  std::fill_n(front.alpha, (count + group_size - 1) / group_size * group_size, 1.0F);
}

void shade_clear(const LayerShading& shading, LayerWork& work, const LayerOfRays& next, std::uint8_t layer,
                 const ReceivedLight& received, WorkerCounts& counts, TileColors& front) {
  compiled_for<shade_clear_inline>(shading.machine)(shading, work, next, layer, received, counts, front);
}

void add_clear(const LayerShading& shading, LayerWork& work, const float* shares, const ReceivedLight& received,
               WorkerCounts& counts, LightSums& light) {
  compiled_for<add_clear_inline>(shading.machine)(shading, work, shares, received, counts, light);
}

void put_into_front(const LightSums& light, std::size_t count, TileColors& front) {
  for (std::size_t r = 0; r < count; ++r) {
    front.red[r] = static_cast<float>(light.red[r]);
    front.green[r] = static_cast<float>(light.green[r]);
    front.blue[r] = static_cast<float>(light.blue[r]);
  }
}

void put_in_front(const TileColors& front, std::size_t count, TileColors& colors) {
  for (std::size_t r = 0; r < count; ++r) {
    const float through = front.alpha[r];
    colors.red[r] = front.red[r] + through * colors.red[r];
    colors.green[r] = front.green[r] + through * colors.green[r];
    colors.blue[r] = front.blue[r] + through * colors.blue[r];
    colors.alpha[r] = 1 - through * (1 - colors.alpha[r]);
  }
}

void composite_mip(const LayerShading& shading, LayerWork& work, const ReceivedLight& received, WorkerCounts& counts,
                   TileColors& colors) {
  compiled_for<composite_mip_inline>(shading.machine)(shading, work, received, counts, colors);
}

void write_colors(const PixelLattice& lattice, const Tile& tile, const TileColors& colors, Framebuffer& out,
                  Machine machine) {
  compiled_for<write_colors_inline>(machine)(lattice, tile, colors, out.color.data());
}

void write_channels(const PixelLattice& lattice, const Tile& tile, const HitBatch& hits, const Vec3* normals,
                    Framebuffer& out) {
  const auto write_each = [&](const auto& write) { for_each_pixel(lattice, tile, write); };
  if (!out.depth.empty())
    write_each([&](std::size_t r, std::size_t pixel) { out.depth[pixel] = static_cast<float>(hits.t[r]); });
  if (!out.normal.empty())
    write_each([&](std::size_t r, std::size_t pixel) {
      const Vec3 normal = is_hit(hits, r) ? normals[r] : Vec3(0, 0, 0);
      for (int axis = 0; axis < 3; ++axis)
        out.normal[3 * pixel + static_cast<std::size_t>(axis)] = static_cast<float>(normal[axis]);
    });
  if (!out.cell.empty())
    write_each([&](std::size_t r, std::size_t pixel) {
      out.cell[pixel] = is_hit(hits, r) ? hits.cell[r] : Framebuffer::no_cell;
    });
  if (!out.value.empty())
    write_each([&](std::size_t r, std::size_t pixel) {
      out.value[pixel] = is_hit(hits, r) ? hits.value[r] : std::numeric_limits<double>::quiet_NaN();
    });
  if (!out.error.empty())
    write_each([&](std::size_t r, std::size_t pixel) { out.error[pixel] = static_cast<float>(hits.error[r]); });
  if (!out.roots.empty()) write_each([&](std::size_t r, std::size_t pixel) { out.roots[pixel] = hits.root_count[r]; });
  if (!out.iterations.empty())
    write_each([&](std::size_t r, std::size_t pixel) { out.iterations[pixel] = hits.iteration_count[r]; });
  if (!out.cost.empty()) write_each([&](std::size_t r, std::size_t pixel) { out.cost[pixel] = hits.cost[r]; });
}

void write_background(const Vec3& background, const PixelLattice& lattice, const Tile& tile, Framebuffer& out) {
  const float color[4] = {static_cast<float>(background.x), static_cast<float>(background.y),
                          static_cast<float>(background.z), 0};
  for_each_background_run(lattice, tile, [&](std::size_t first, std::size_t count) {
    const auto fill = [&](auto& channel, auto value) {
      if (!channel.empty()) std::fill_n(channel.data() + first, count, value);
    };
    fill_colors(color, out.color.data() + 4 * first, count);
    fill(out.depth, std::numeric_limits<float>::infinity());
    if (!out.normal.empty()) std::fill_n(out.normal.data() + 3 * first, 3 * count, 0.0F);
    fill(out.cell, Framebuffer::no_cell);
    fill(out.value, std::numeric_limits<double>::quiet_NaN());
    fill(out.error, std::numeric_limits<float>::quiet_NaN());
    for (auto* numbers : {&out.roots, &out.iterations, &out.cost}) fill(*numbers, std::uint32_t{0});
  });
}

}  // namespace rhoray::render

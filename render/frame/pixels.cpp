#include "render/frame/pixels.h"

#include <algorithm>
#include <limits>

#include "render/kernels/compiled_for.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;
constexpr double infinity = std::numeric_limits<double>::infinity();

bool is_hit(const HitBatch& hits, std::size_t r) {
  return hits.t[r] < infinity;
}

/// Where a group's hits are, as the alpha of its pixels, and how many there are.
RHORAY_INLINE int find_hits(const double* t, Lanes& alpha) {
  for (std::size_t i = 0; i < group_size; ++i) alpha[i] = t[i] < infinity ? 1 : 0;
  float count = 0;
  for (std::size_t i = 0; i < group_size; ++i) count += alpha[i];
  return static_cast<int>(count);
}

/// One colour of a group, and the background where nothing was hit.
RHORAY_INLINE void over_background(const Lanes& color, const Lanes& alpha, double background, float* out) {
  const auto behind = static_cast<float>(background);
  Lanes shown;
  for (std::size_t i = 0; i < group_size; ++i) shown[i] = alpha[i] > 0 ? color[i] : behind;
  std::copy_n(shown.data(), group_size, out);
}

RHORAY_INLINE std::size_t pixel_at(const PixelLattice& lattice, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(lattice.width) + static_cast<std::size_t>(x);
}

/// Calls write(r, pixel) for every pixel that the tile's ray r stands for.
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

RHORAY_INLINE void shade_tile_inline(const Look& look, Worker& worker) {
  HitBatch& hits = worker.hits;
  const Vec3& background = look.background;
  const std::size_t count = worker.rays.count;
  for (std::size_t r = count; r % group_size != 0; ++r) hits.t[r] = infinity;  // the last group's empty rooms
  for (std::size_t first = 0; first < count; first += group_size) {
    Lanes alpha;
    Colors colors;
    const int hit_count = find_hits(hits.t.data() + first, alpha);
    if (hit_count > 0) {
      double field_values[group_size];
      if (look.lookup != nullptr) (*look.lookup)(worker.rays, hits, first, field_values);
      shade(look.layer, look.effects, look.facing, worker.rays, hits, first, field_values, colors);
    }
    over_background(colors.red, alpha, background.x, worker.colors.red + first);
    over_background(colors.green, alpha, background.y, worker.colors.green + first);
    over_background(colors.blue, alpha, background.z, worker.colors.blue + first);
    std::copy_n(alpha.data(), group_size, worker.colors.alpha + first);
    worker.hit_count += static_cast<std::uint64_t>(hit_count);
    if (look.effects.specular) worker.highlights += static_cast<std::uint64_t>(hit_count);
    if (look.effects.smooth_normals) worker.smooth_normals += static_cast<std::uint64_t>(hit_count);
    if (look.effects.field_color) worker.field_values += static_cast<std::uint64_t>(hit_count);
  }
  if (!look.proves) return;
  for (std::size_t r = 0; r < count; ++r)
    if (is_hit(hits, r) && hits.error[r] > worker.largest_error) worker.largest_error = hits.error[r];
}

}  // namespace

void shade_tile(const Look& look, Worker& worker) {
  compiled_for<shade_tile_inline>(look.machine)(look, worker);
}

void expect_tile(const PixelLattice& lattice, const Tile& tile, const Framebuffer& out) {
  if (lattice.spacing != 1) return;
  constexpr std::size_t line_floats = 64 / sizeof(float);
  const auto width = static_cast<std::size_t>(tile.x_end - tile.x_begin);
  for (int y = tile.y_begin; y < tile.y_end; ++y) {
    const float* row = out.color.data() + 4 * pixel_at(lattice, tile.x_begin, y);
    for (std::size_t i = 0; i < 4 * width; i += line_floats) __builtin_prefetch(row + i, 1);
  }
}

void write_tile(const Look& look, const PixelLattice& lattice, const Tile& tile, const Worker& worker,
                Framebuffer& out) {
  const auto write_each = [&](const auto& write) { for_each_pixel(lattice, tile, write); };
  const HitBatch& hits = worker.hits;
  const TileColors& colors = worker.colors;
  write_each([&, color = out.color.data()](std::size_t r, std::size_t pixel) {
    color[4 * pixel] = colors.red[r];
    color[4 * pixel + 1] = colors.green[r];
    color[4 * pixel + 2] = colors.blue[r];
    color[4 * pixel + 3] = colors.alpha[r];
  });
  if (!out.depth.empty())
    write_each([&](std::size_t r, std::size_t pixel) { out.depth[pixel] = static_cast<float>(hits.t[r]); });
  if (!out.normal.empty())
    write_each([&](std::size_t r, std::size_t pixel) {
      const Hit hit = hits[r];
      const Vec3 normal = hit.is_miss() ? Vec3(0, 0, 0) : look.facing.normal(hit.gradient, worker.rays[r].direction);
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

}  // namespace rhoray::render

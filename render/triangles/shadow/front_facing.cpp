#include "render/triangles/shadow/front_facing.h"

#include <algorithm>
#include <limits>

#include "render/query/compiled_for.h"

namespace rhoray::render::wide {

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();
constexpr std::size_t size = SeenBlock::size;

RHORAY_INLINE float smaller(float a, float b) {
  return a < b ? a : b;
}
RHORAY_INLINE float larger(float a, float b) {
  return a > b ? a : b;
}

/// Extent of all facets, per lane of their blocks.
struct Extent {
  /// `sum` is that of the longer sides of the projected bounding boxes.
  float low[2][size], high[2][size], sum[size];
};

RHORAY_INLINE void see(const FacetBlock* facets, std::size_t blocks, const SeenFromLight& seen, float margin,
                       SeenBlock* out, Extent& extent) {
  const int height = seen.height_axis(), across = seen.place_axis(0), along = seen.place_axis(1);
  const float slope_x = static_cast<float>(seen.slope(0)), slope_y = static_cast<float>(seen.slope(1)),
              sign = static_cast<float>(seen.sign());
  for (std::size_t i = 0; i < size; ++i) {
    extent.low[0][i] = extent.low[1][i] = nowhere;
    extent.high[0][i] = extent.high[1][i] = -nowhere, extent.sum[i] = 0;
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto& corner = facets[b].corner;
    SeenBlock& block = out[b];
    float x[4][size], y[4][size];
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t i = 0; i < size; ++i) {
        const float w = corner[c][height][i];
        x[c][i] = corner[c][across][i] - slope_x * w, y[c][i] = corner[c][along][i] - slope_y * w;
      }
    std::uint8_t is_up[size], is_down[size], is_number[size];
    for (std::size_t i = 0; i < size; ++i) {
      const float h0 = sign * corner[0][height][i], h1 = sign * corner[1][height][i], h2 = sign * corner[2][height][i],
                  h3 = sign * corner[3][height][i];
      block.lowest[i] = smaller(smaller(h0, h1), smaller(h2, h3));
      block.highest[i] = larger(larger(h0, h1), larger(h2, h3));
    }
    for (std::size_t i = 0; i < size; ++i) {
      block.low[0][i] = smaller(smaller(x[0][i], x[1][i]), smaller(x[2][i], x[3][i]));
      block.high[0][i] = larger(larger(x[0][i], x[1][i]), larger(x[2][i], x[3][i]));
      block.low[1][i] = smaller(smaller(y[0][i], y[1][i]), smaller(y[2][i], y[3][i]));
      block.high[1][i] = larger(larger(y[0][i], y[1][i]), larger(y[2][i], y[3][i]));
      constexpr float third = 1.0F / 3;
      block.middle[0][i] = (x[0][i] + x[1][i] + x[2][i]) * third;
      block.middle[1][i] = (y[0][i] + y[1][i] + y[2][i]) * third;
    }
    for (std::size_t i = 0; i < size; ++i) {
      const float of_x = block.high[0][i] - block.low[0][i], of_y = block.high[1][i] - block.low[1][i];
      const float longer = larger(of_x, of_y);
      extent.sum[i] += longer < nowhere ? longer : 0;
      // Comparisons written so that NaN is skipped.
      for (std::size_t a = 0; a < 2; ++a) {
        extent.low[a][i] = smaller(block.low[a][i], extent.low[a][i]);
        extent.high[a][i] = larger(block.high[a][i], extent.high[a][i]);
      }
      const float bx = x[1][i] - x[0][i], by = y[1][i] - y[0][i], cx = x[2][i] - x[0][i], cy = y[2][i] - y[0][i],
                  dx = x[3][i] - x[0][i], dy = y[3][i] - y[0][i];
      const float abc = bx * cy - by * cx, of_second = cx * dy - cy * dx;
      const bool is_triangle = (corner[2][0][i] == corner[3][0][i]) & (corner[2][1][i] == corner[3][1][i]) &
                               (corner[2][2][i] == corner[3][2][i]);
      const float acd = is_triangle ? abc : of_second;
      // When each corner moves by the margin, an edge changes by twice that along either axis, and
      // the area by 8 margins times size and margin.
      const float least = 16 * margin * (longer + margin);
      is_up[i] = (abc > least) & (acd > least), is_down[i] = (abc < -least) & (acd < -least);
      const float of_all = (x[0][i] + x[1][i]) + (x[2][i] + x[3][i]) + (y[0][i] + y[1][i]) + (y[2][i] + y[3][i]);
      is_number[i] = of_all - of_all == 0;
    }
    block.is_up = bits_of_block(is_up), block.is_down = bits_of_block(is_down),
    block.is_number = bits_of_block(is_number);
  }
}

}  // namespace

FrontFacing::FrontFacing(Machine machine, const SeenFromLight& seen, double margin, const FacetBlock* blocks,
                         std::size_t count)
    : seen_(seen), facets_(blocks), count_(count) {
  if (count == 0) return;
  const std::size_t block_count = (count + size - 1) / size;
  blocks_ = std::make_unique_for_overwrite<SeenBlock[]>(block_count);
  Extent extent;
  compiled_for<see>(machine)(blocks, block_count, seen, static_cast<float>(margin), blocks_.get(), extent);
  double last[2], sum = 0;
  for (int a = 0; a < 2; ++a) {
    const float first = *std::min_element(extent.low[a], extent.low[a] + size) - static_cast<float>(margin);
    squares_.first[a] = static_cast<double>(first);
    last[a] = static_cast<double>(*std::max_element(extent.high[a], extent.high[a] + size)) + margin;
    if (!(last[a] >= squares_.first[a])) return;
  }
  for (const float of_lane : extent.sum) sum += static_cast<double>(of_lane);
  // Smaller squares take longer to fill than they save.
  squares_.divide(last, 0.7 * sum / static_cast<double>(block_count * size));
}

}  // namespace rhoray::render::wide

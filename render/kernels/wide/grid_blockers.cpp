#include "render/kernels/wide/grid_blockers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"
#include "render/kernels/wide/isosurface.h"
#include "render/volumes/volume.h"

namespace rhoray::render::wide {

namespace {

template <class View>
inline constexpr bool is_uniform_grid = false;
template <class T>
inline constexpr bool is_uniform_grid<GridVolume<T>> = true;

/// 5 x 5 x 5 samples around 4 x 4 x 4 cells, x + 5 y + 25 z, and room for those beyond.
constexpr std::size_t sample_count = 125, room = 160;
constexpr std::size_t stride[3] = {1, 5, 25};

/// Samples that are the lowest corner of a cell of the block.
constexpr std::array<std::uint8_t, sample_count> lowest_corners = [] {
  std::array<std::uint8_t, sample_count> is_lowest{};
  for (std::size_t z = 0; z < 4; ++z)
    for (std::size_t y = 0; y < 4; ++y)
      for (std::size_t x = 0; x < 4; ++x) is_lowest[x + 5 * y + 25 * z] = 1;
  return is_lowest;
}();

/// The samples of a block, and which of its cells the grid has: `cells` of them along each axis.
struct BlockOfSamples {
  double value[room];
  std::array<std::size_t, 3> cells;
};

/// The cells of a block that have corners on both sides.
RHORAY_INLINE void find_active(const BlockOfSamples& block, double isovalue, std::uint8_t* active) {
  std::uint8_t inside[room];
  for (std::size_t i = 0; i < room; ++i) inside[i] = block.value[i] >= isovalue;
  for (std::size_t i = 0; i < sample_count; ++i) {
    const std::uint8_t *a = inside + i, *b = a + 25;
    const auto all = a[0] & a[1] & a[5] & a[6] & b[0] & b[1] & b[5] & b[6];
    const auto any = a[0] | a[1] | a[5] | a[6] | b[0] | b[1] | b[5] | b[6];
    active[i] = static_cast<std::uint8_t>(any & ~all & lowest_corners[i]);
  }
}

/// Adds a block's cells to those of its neighbours.
void add_slopes(const BlockOfSamples& samples, double isovalue, BlockSlopes::Block& block,
                std::vector<BlockSlopes::Cell>& cells) {
  std::uint8_t active[sample_count];
  find_active(samples, isovalue, active);
  struct Differences {
    double least[3], greatest[3];
  } of[64];
  std::uint8_t places[64];
  std::size_t count = 0;
  double largest = 0;
  for (std::size_t z = 0; z < samples.cells[2]; ++z)
    for (std::size_t y = 0; y < samples.cells[1]; ++y)
      for (std::size_t x = 0; x < samples.cells[0]; ++x) {
        const std::size_t lowest = x + 5 * y + 25 * z;
        if (active[lowest] == 0) continue;
        const double* value = samples.value + lowest;
        for (std::size_t a = 0; a < 3; ++a) {
          const std::size_t up = stride[a], one = stride[(a + 1) % 3], other = stride[(a + 2) % 3];
          double least = value[up] - value[0], greatest = least;
          for (const std::size_t edge : {one, other, one + other}) {
            const double difference = value[edge + up] - value[edge];
            least = std::min(least, difference), greatest = std::max(greatest, difference);
          }
          of[count].least[a] = least, of[count].greatest[a] = greatest;
          largest = std::max({largest, std::abs(least), std::abs(greatest)});
        }
        places[count++] = static_cast<std::uint8_t>(x + 4 * y + 16 * z);
      }
  block.first_cell = static_cast<std::uint32_t>(cells.size());
  block.cell_count = static_cast<std::uint32_t>(count);
  // As a float it is no smaller, so that differences are 127 units at most.
  block.unit = static_cast<float>(largest / 126);
  const double unit = static_cast<double>(block.unit);
  if (!(unit >= double{std::numeric_limits<float>::min()} && unit <= double{std::numeric_limits<float>::max()}))
    block.unit = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t c = 0; c < count; ++c) {
    BlockSlopes::Cell& cell = cells.emplace_back(BlockSlopes::Cell{places[c], {}, {}});
    for (std::size_t a = 0; a < 3 && block.unit > 0; ++a) {
      cell.least[a] = static_cast<std::int8_t>(std::floor(of[c].least[a] / unit));
      cell.greatest[a] = static_cast<std::int8_t>(std::ceil(of[c].greatest[a] / unit));
    }
  }
}

template <class T>
void read_block(const GridVolume<T>& view, const Index3& block, BlockOfSamples& out) {
  const auto& tables = view.tables();
  const Index3 samples = view.description().layout.sample_count;
  const std::uint64_t* const address[3] = {tables.x.data(), tables.y.data(), tables.z.data()};
  std::uint64_t of[3][5];
  for (int a = 0; a < 3; ++a) {
    for (std::int64_t i = 0; i < 5; ++i) of[a][i] = address[a][std::min(4 * block[a] + i, samples[a] - 1)];
    out.cells[static_cast<std::size_t>(a)] =
        static_cast<std::size_t>(std::min<std::int64_t>(4, samples[a] - 1 - 4 * block[a]));
  }
  const T* from = view.samples().data();
  double* to = out.value;
  for (std::size_t z = 0; z < 5; ++z)
    for (std::size_t y = 0; y < 5; ++y)
      for (std::size_t x = 0; x < 5; ++x) *to++ = static_cast<double>(from[of[0][x] + of[1][y] + of[2][z]]);
  std::fill(to, out.value + room, 0.0);
}

std::vector<Index3> blocks_of(const Occupancy& occupancy) {
  std::vector<Index3> blocks;
  const auto& count = occupancy.node_count();
  std::size_t at = 0;
  for (std::int64_t z = 0; z < count[2]; ++z)
    for (std::int64_t y = 0; y < count[1]; ++y)
      for (std::int64_t x = 0; x < count[0]; ++x, ++at)
        for (std::uint64_t bits = occupancy.nodes()[at]; bits != 0; bits &= bits - 1) {
          const int bit = std::countr_zero(bits);
          blocks.emplace_back(4 * x + (bit & 3), 4 * y + (bit >> 2 & 3), 4 * z + (bit >> 4));
        }
  return blocks;
}

struct Slopes {
  std::vector<BlockSlopes::Block> blocks;
  std::vector<BlockSlopes::Cell> cells;
};

template <class T>
Slopes slopes_of(const GridVolume<T>& view, const Occupancy& occupancy, double isovalue, unsigned threads) {
  const std::vector<Index3> places = blocks_of(occupancy);
  constexpr std::uint64_t blocks_each = 1024;
  std::vector<Slopes> parts((places.size() + blocks_each - 1) / blocks_each);
  for_each_range(parts.size(), 1, threads, [&](std::uint64_t first_part, std::uint64_t end_part) {
    BlockOfSamples samples;
    for (std::uint64_t part = first_part; part < end_part; ++part) {
      const std::uint64_t end = std::min<std::uint64_t>(places.size(), (part + 1) * blocks_each);
      for (std::uint64_t b = part * blocks_each; b < end; ++b) {
        BlockSlopes::Block& block = parts[part].blocks.emplace_back();
        for (int a = 0; a < 3; ++a) block.corner[a] = static_cast<float>(4 * places[b][a]);
        read_block(view, places[b], samples);
        add_slopes(samples, isovalue, block, parts[part].cells);
      }
    }
  });
  Slopes all;
  for (Slopes& part : parts) {
    for (BlockSlopes::Block& block : part.blocks) block.first_cell += static_cast<std::uint32_t>(all.cells.size());
    all.blocks.insert(all.blocks.end(), part.blocks.begin(), part.blocks.end());
    all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
    part = {};
  }
  return all;
}

/// Whether the field may rise in a cell along rays of a direction; their unit drops out. The kernel's single precision
/// is off by far less than the margin.
bool may_rise(const BlockSlopes::Cell& cell, const Vec3& direction) {
  constexpr double margin = 0x1p-16;
  double rise = 0, steepness = 0;
  for (int a = 0; a < 3; ++a) {
    const double low = direction[a] * cell.least[a], high = direction[a] * cell.greatest[a];
    rise += std::max(low, high), steepness += std::max(std::abs(low), std::abs(high));
  }
  return !(rise < -margin * steepness);
}

/// What the cells that may hold light back cover.
std::vector<Footprint> footprints_of(const BlockSlopes& slopes, const SeenFromLight& seen, const Vec3& falling) {
  // Of all cells the same, but for where they stand.
  Footprint of_cell = Footprint::of_nothing();
  for (unsigned corner = 0; corner < 8; ++corner) {
    const float point[3] = {static_cast<float>(corner & 1), static_cast<float>(corner >> 1 & 1),
                            static_cast<float>(corner >> 2 & 1)};
    of_cell.add(seen, point);
  }
  std::vector<Footprint> footprints;
  for (const BlockSlopes::Block& block : slopes.blocks())
    for (const BlockSlopes::Cell& cell : slopes.cells().subspan(block.first_cell, block.cell_count)) {
      if (block.unit > 0 && !may_rise(cell, falling)) continue;
      const float point[3] = {block.corner[0] + static_cast<float>(cell.place & 3),
                              block.corner[1] + static_cast<float>(cell.place >> 2 & 3),
                              block.corner[2] + static_cast<float>(cell.place >> 4)};
      Footprint at = Footprint::of_nothing();
      at.add(seen, point);
      footprints.push_back({.low = {at.low[0] + of_cell.low[0], at.low[1] + of_cell.low[1]},
                            .high = {at.high[0] + of_cell.high[0], at.high[1] + of_cell.high[1]},
                            .height = at.height + of_cell.height});
    }
  return footprints;
}

}  // namespace

std::shared_ptr<const BlockSlopes> BlockSlopes::of(const VolumeImplementation& volume, const Question& question,
                                                   unsigned threads) {
  if (!prepare_occupancy(volume, question, threads) || volume.field.no_data_count > 0) return nullptr;
  return std::visit(
      [&]<class View>(const View& view) -> std::shared_ptr<const BlockSlopes> {
        if constexpr (is_uniform_grid<View>) {
          const auto slopes = std::make_shared<BlockSlopes>();
          slopes->occupancy_ = volume.occupancies->of(view.levels(), question.isovalue);
          Slopes found = slopes_of(view, *slopes->occupancy_, question.isovalue, threads);
          slopes->blocks_ = std::move(found.blocks), slopes->cells_ = std::move(found.cells);
          return slopes;
        }
        return nullptr;
      },
      volume.view);
}

BlockersOfSides grid_blockers_of(const BlockSlopes& slopes, const LightPlace& light) {
  BlockersOfSides of_sides;
  if (!light.is_one_direction()) return of_sides;
  const SeenFromLight seen(light.at);
  // Far above what rounding moves points and rays by, as in prepare_occupancy.
  float farthest = 0;
  for (const BlockSlopes::Block& block : slopes.blocks())
    for (const float low : block.corner) farthest = std::max(farthest, low + 4);
  const double margin = 1.0 / 64 + 0x1p-21 * static_cast<double>(farthest);
  for (const StartSide side : {StartSide::outside, StartSide::inside}) {
    const auto blockers = std::make_shared<Blockers>();
    blockers->heights.emplace(seen, BlockerHeights::Frame{.margin = margin},
                              footprints_of(slopes, seen, side == StartSide::outside ? light.at : -light.at));
    of_sides[side == StartSide::inside] = blockers;
  }
  return of_sides;
}

GridBlockersMemory::Kept* GridBlockersMemory::find(const VolumeImplementation& volume, const Question& question,
                                                   unsigned threads) {
  const auto occupancy = std::visit(
      [&]<class View>(const View& view) -> std::shared_ptr<const Occupancy> {
        if constexpr (is_uniform_grid<View>) return volume.occupancies->of(view.levels(), question.isovalue);
        return nullptr;
      },
      volume.view);
  if (!occupancy) return nullptr;
  const auto found =
      std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.slopes->occupancy() == occupancy; });
  if (found != kept_.end()) {
    std::rotate(kept_.begin(), found, found + 1);
    return &kept_.front();
  }
  auto slopes = BlockSlopes::of(volume, question, threads);
  if (!slopes) return nullptr;
  if (kept_.size() == most_kept) kept_.pop_back();
  kept_.insert(kept_.begin(), Kept{std::move(slopes), {}});
  return &kept_.front();
}

BlockersOfSides GridBlockersMemory::of(const VolumeImplementation& volume, const Question& question,
                                       const LightPlace& light, unsigned threads) {
  if (!light.is_one_direction()) return {};
  Kept* kept = find(volume, question, threads);
  if (kept == nullptr) return {};
  std::vector<OfLight>& lights = kept->lights;
  const auto found =
      std::find_if(lights.begin(), lights.end(), [&](const OfLight& of) { return of.towards == light.at; });
  if (found != lights.end()) {
    std::rotate(lights.begin(), found, found + 1);
  } else {
    if (lights.size() == most_kept) lights.pop_back();
    lights.insert(lights.begin(), {light.at, grid_blockers_of(*kept->slopes, light)});
  }
  return lights.front().blockers;
}

}  // namespace rhoray::render::wide

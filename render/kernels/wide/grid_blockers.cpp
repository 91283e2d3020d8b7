#include "render/kernels/wide/grid_blockers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"
#include "render/kernels/compiled_for.h"
#include "render/kernels/wide/isosurface.h"
#include "render/volumes/volume.h"

namespace rhoray::render::wide {

namespace {

template <class View>
inline constexpr bool is_uniform_grid = false;
template <class T>
inline constexpr bool is_uniform_grid<GridVolume<T>> = true;

/// 5 x 5 x 5 samples around 4 x 4 x 4 cells, x + 5 y + 25 z, and room for those beyond.
constexpr std::size_t sample_count = 125, room = 160, before = 32;
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
  std::array<std::int64_t, 3> cells;
};

/// @param edge  differences of corners beside each other along an axis, of cells that have corners on both sides
RHORAY_INLINE void find_slopes(const BlockOfSamples& block, double isovalue, BlockSlopes::Block& out,
                               std::uint8_t& any_active) {
  std::uint8_t inside[room], active[before + room] = {};
  for (std::size_t i = 0; i < room; ++i) inside[i] = block.value[i] >= isovalue;
  for (std::size_t i = 0; i < sample_count; ++i) {
    const std::uint8_t *a = inside + i, *b = a + stride[2];
    const auto all = a[0] & a[1] & a[5] & a[6] & b[0] & b[1] & b[5] & b[6];
    const auto any = a[0] | a[1] | a[5] | a[6] | b[0] | b[1] | b[5] | b[6];
    active[before + i] = static_cast<std::uint8_t>(any & ~all & lowest_corners[i]);
  }
  for (std::size_t z = 0, i = 0; z < 5; ++z)
    for (std::size_t y = 0; y < 5; ++y)
      for (std::size_t x = 0; x < 5; ++x, ++i)
        if (static_cast<std::int64_t>(x) >= block.cells[0] || static_cast<std::int64_t>(y) >= block.cells[1] ||
            static_cast<std::int64_t>(z) >= block.cells[2])
          active[before + i] = 0;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  any_active = 0;
  for (std::size_t i = 0; i < sample_count; ++i) any_active |= active[before + i];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // An edge belongs to the four cells around it.
    const std::size_t one = stride[(axis + 1) % 3], other = stride[(axis + 2) % 3];
    double least = infinity, greatest = -infinity;
    for (std::size_t i = 0; i < sample_count; ++i) {
      const std::uint8_t* cell = active + before + i;
      const bool counts = (cell[0] | *(cell - one) | *(cell - other) | *(cell - one - other)) != 0;
      const double difference = block.value[i + stride[axis]] - block.value[i];
      const double low = counts ? difference : infinity, high = counts ? difference : -infinity;
      least = low < least ? low : least, greatest = high > greatest ? high : greatest;
    }
    constexpr float outward = 0x1p-22F;
    out.least[axis] = static_cast<float>(least) - outward * std::abs(static_cast<float>(least));
    out.greatest[axis] = static_cast<float>(greatest) + outward * std::abs(static_cast<float>(greatest));
    std::size_t first = 4, last = 0;
    for (std::size_t i = 0; i < sample_count; ++i) {
      const std::size_t at = i / stride[axis] % 5;
      if (active[before + i] != 0) first = std::min(first, at), last = std::max(last, at + 1);
    }
    out.cell_low[axis] = static_cast<float>(first), out.cell_high[axis] = static_cast<float>(last);
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
    out.cells[static_cast<std::size_t>(a)] = std::min<std::int64_t>(4, samples[a] - 1 - 4 * block[a]);
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

template <class T>
std::vector<BlockSlopes::Block> slopes_of(const GridVolume<T>& view, const Occupancy& occupancy, double isovalue,
                                          unsigned threads) {
  const std::vector<Index3> places = blocks_of(occupancy);
  std::vector<BlockSlopes::Block> all(places.size());
  const auto find = compiled_for<find_slopes>(chosen_machine());
  constexpr std::uint64_t blocks_each = 256;
  for_each_range(places.size(), blocks_each, threads, [&](std::uint64_t first, std::uint64_t end) {
    BlockOfSamples samples;
    for (std::uint64_t b = first; b < end; ++b) {
      read_block(view, places[b], samples);
      std::uint8_t any_active = 0;
      find(samples, isovalue, all[b], any_active);
      for (int a = 0; a < 3; ++a) {
        all[b].cell_low[a] += static_cast<float>(4 * places[b][a]);
        all[b].cell_high[a] += static_cast<float>(4 * places[b][a]);
      }
      if (any_active == 0) all[b].cell_high[0] = -1;
    }
  });
  std::erase_if(all, [](const BlockSlopes::Block& block) { return block.cell_high[0] < 0; });
  return all;
}

/// Whether the field may rise along rays of this direction, times the sign. The kernel's single precision is off by far
/// less than the margin.
bool may_rise(const BlockSlopes::Block& block, const Vec3& direction, double sign) {
  constexpr double margin = 0x1p-16;
  double rise = 0, steepness = 0;
  for (int a = 0; a < 3; ++a) {
    const double low = sign * direction[a] * static_cast<double>(block.least[a]),
                 high = sign * direction[a] * static_cast<double>(block.greatest[a]);
    rise += std::max(low, high), steepness += std::max(std::abs(low), std::abs(high));
  }
  return !(rise < -margin * steepness);  // written so that what is no number may
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
          slopes->blocks_ = slopes_of(view, *slopes->occupancy_, question.isovalue, threads);
          return slopes;
        }
        return nullptr;
      },
      volume.view);
}

std::shared_ptr<const BlockSlopes> BlockSlopesMemory::of(const VolumeImplementation& volume, const Question& question,
                                                         unsigned threads) {
  const auto occupancy = std::visit(
      [&]<class View>(const View& view) -> std::shared_ptr<const Occupancy> {
        if constexpr (is_uniform_grid<View>) return volume.occupancies->of(view.levels(), question.isovalue);
        return nullptr;
      },
      volume.view);
  if (!occupancy) return nullptr;
  const auto found =
      std::find_if(kept_.begin(), kept_.end(), [&](const auto& slopes) { return slopes->occupancy() == occupancy; });
  if (found != kept_.end()) {
    std::rotate(kept_.begin(), found, found + 1);
    return kept_.front();
  }
  auto slopes = BlockSlopes::of(volume, question, threads);
  if (!slopes) return nullptr;
  if (kept_.size() == most_kept) kept_.pop_back();
  kept_.insert(kept_.begin(), std::move(slopes));
  return kept_.front();
}

std::array<std::shared_ptr<const Blockers>, 2> grid_blockers_of(const BlockSlopes& slopes, const LightPlace& light) {
  std::array<std::shared_ptr<const Blockers>, 2> of_sides;
  if (!light.is_one_direction()) return of_sides;
  const SeenFromLight seen(light.at);
  // Far above what rounding moves points and rays by, as in prepare_occupancy.
  float farthest = 0;
  for (const BlockSlopes::Block& block : slopes.blocks())
    for (const float high : block.cell_high) farthest = std::max(farthest, high);
  const double margin = 1.0 / 64 + 0x1p-22 * static_cast<double>(farthest);
  for (const StartSide side : {StartSide::outside, StartSide::inside}) {
    std::vector<Footprint> footprints;
    footprints.reserve(slopes.blocks().size());
    for (const BlockSlopes::Block& block : slopes.blocks()) {
      if (!may_rise(block, light.at, side == StartSide::outside ? 1 : -1)) continue;
      Footprint& of = footprints.emplace_back(Footprint::of_nothing());
      for (unsigned corner = 0; corner < 8; ++corner) {
        float point[3];
        for (unsigned a = 0; a < 3; ++a) point[a] = (corner >> a & 1) != 0 ? block.cell_high[a] : block.cell_low[a];
        of.add(seen, point);
      }
    }
    const auto blockers = std::make_shared<Blockers>();
    blockers->heights.emplace(seen, BlockerHeights::Frame{.margin = margin}, footprints);
    of_sides[side == StartSide::inside] = blockers;
  }
  return of_sides;
}

}  // namespace rhoray::render::wide

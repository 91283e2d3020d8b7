#include "render/grid/shadow/grid_occluders.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/base/stopping.h"
#include "render/grid/brick_samples.h"
#include "render/grid/isosurface/grid_surface.h"
#include "render/query/compiled_for.h"

namespace rhoray::render::wide {

namespace {

/// 5 x 5 x 5 samples around 4 x 4 x 4 cells, at x + 5 y + 25 z, with padding at the end.
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

/// The samples of a block, and the number of its cells inside the grid along each axis (`cells`).
struct BlockOfSamples {
  double value[room];
  std::array<std::size_t, 3> cells;
};

/// Finds the cells of a block that have corners on both sides.
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

/// Returns the corners as integers in a unit in which the one farthest from the isovalue is 127.
SurfaceCells::Cell cell_of(std::size_t place, const double* lowest, double isovalue) {
  double above[8], farthest = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    above[c] = lowest[(c & 1) * stride[0] + (c >> 1 & 1) * stride[1] + (c >> 2) * stride[2]] - isovalue;
    farthest = std::max(farthest, std::abs(above[c]));
  }
  SurfaceCells::Cell cell{.place = static_cast<std::uint8_t>(place), .corner = {}};
  const double per_length = 127 / farthest;
  if (!(farthest <= std::numeric_limits<double>::max() && per_length <= std::numeric_limits<double>::max())) {
    cell.place |= SurfaceCells::Cell::unknown;
    return cell;
  }
  for (std::size_t c = 0; c < 8; ++c) cell.corner[c] = static_cast<std::int8_t>(std::lrint(above[c] * per_length));
  return cell;
}

/// Appends a block's cells to those found so far.
void add_cells(const BlockOfSamples& samples, double isovalue, SurfaceCells::Block& block,
               std::vector<SurfaceCells::Cell>& cells) {
  std::uint8_t active[sample_count];
  find_active(samples, isovalue, active);
  block.first_cell = static_cast<std::uint32_t>(cells.size());
  for (std::size_t z = 0; z < samples.cells[2]; ++z)
    for (std::size_t y = 0; y < samples.cells[1]; ++y)
      for (std::size_t x = 0; x < samples.cells[0]; ++x) {
        const std::size_t lowest = x + 5 * y + 25 * z;
        if (active[lowest] != 0) cells.push_back(cell_of(x + 4 * y + 16 * z, samples.value + lowest, isovalue));
      }
  block.cell_count = static_cast<std::uint32_t>(cells.size()) - block.first_cell;
}

template <class T>
void read_block_of_dense(const SampleSource& source, const int* first, T* values) {
  std::uint64_t address[3][5];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 5; ++i) address[a][i] = source.address[a][std::min(first[a] + i, source.count[a] - 1)];
  const T* from = static_cast<const T*>(source.samples);
  for (std::size_t z = 0; z < 5; ++z)
    for (std::size_t y = 0; y < 5; ++y)
      for (std::size_t x = 0; x < 5; ++x) *values++ = from[address[0][x] + address[1][y] + address[2][z]];
}

template <class T>
void read_samples(const SampleSource& source, const int* first, double* out) {
  T values[sample_count];
  if (source.bricks.slots != nullptr)
    read_block_from_bricks(source, first, values);
  else
    read_block_of_dense(source, first, values);
  std::copy(values, values + sample_count, out);
}

void read_block(const SampleSource& source, const Index3& block, BlockOfSamples& out) {
  int first[3];
  for (int a = 0; a < 3; ++a) {
    first[a] = static_cast<int>(4 * block[a]);
    out.cells[static_cast<std::size_t>(a)] = static_cast<std::size_t>(std::min(4, source.count[a] - 1 - first[a]));
  }
  formats::with_exact_type(source.type, [&]<class T>(T) { read_samples<T>(source, first, out.value); });
  std::fill(out.value + sample_count, out.value + room, 0.0);
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

struct Found {
  std::vector<SurfaceCells::Block> blocks;
  std::vector<SurfaceCells::Cell> cells;
};

Found cells_of(const SampleSource& source, const Occupancy& occupancy, double isovalue, unsigned threads,
               const std::stop_token& stop) {
  const std::vector<Index3> places = blocks_of(occupancy);
  constexpr std::uint64_t blocks_each = 1024;
  std::vector<Found> parts((places.size() + blocks_each - 1) / blocks_each);
  for_each_range(parts.size(), 1, threads, [&](std::uint64_t first_part, std::uint64_t end_part) {
    BlockOfSamples samples;
    for_each_until_stopped(first_part, end_part, 1, stop, [&](std::uint64_t part) {
      const std::uint64_t end = std::min<std::uint64_t>(places.size(), (part + 1) * blocks_each);
      for (std::uint64_t b = part * blocks_each; b < end; ++b) {
        SurfaceCells::Block& block = parts[part].blocks.emplace_back();
        for (int a = 0; a < 3; ++a) block.corner[a] = static_cast<float>(4 * places[b][a]);
        read_block(source, places[b], samples);
        add_cells(samples, isovalue, block, parts[part].cells);
      }
    });
  });
  Found all;
  for (Found& part : parts) {
    end_if_stopped(stop);
    for (SurfaceCells::Block& block : part.blocks) block.first_cell += static_cast<std::uint32_t>(all.cells.size());
    all.blocks.insert(all.blocks.end(), part.blocks.begin(), part.blocks.end());
    all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
    part = {};
  }
  return all;
}

/// The direction of rays in cells, along which the field's slope is computed, and a bound of the
/// slope's error. The error comes from rounding the corners; that of the kernel's single precision
/// is far smaller.
struct Slope {
  float x, y, z, doubt;
};

/// Determines whether the field may rise in cells along rays of a direction: 1 or 0 for each. The
/// slope along the direction is linear along each axis, so it is greatest at a corner. There it is
/// computed from the differences along the three edges. The unit cancels out.
RHORAY_INLINE void find_rising(const SurfaceCells::Cell* cells, std::size_t count, const Slope& along,
                               std::uint8_t* rises) {
  constexpr std::size_t size = 16;
  for (std::size_t first = 0; first < count; first += size) {
    const std::size_t here = count - first < size ? count - first : size;
    std::uint8_t is_unknown[size] = {}, is_rising[size];
    float f[8][size] = {}, greatest[size];
    for (std::size_t i = 0; i < here; ++i) {
      const SurfaceCells::Cell& cell = cells[first + i];
      is_unknown[i] = (cell.place & SurfaceCells::Cell::unknown) != 0;
      for (std::size_t c = 0; c < 8; ++c) f[c][i] = cell.corner[c];
    }
    for (std::size_t i = 0; i < size; ++i) greatest[i] = -std::numeric_limits<float>::infinity();
    for (std::size_t c = 0; c < 8; ++c)
      for (std::size_t i = 0; i < size; ++i) {
        const float slope = along.x * (f[c | 1][i] - f[c & 6][i]) + along.y * (f[c | 2][i] - f[c & 5][i]) +
                            along.z * (f[c | 4][i] - f[c & 3][i]);
        greatest[i] = slope > greatest[i] ? slope : greatest[i];
      }
    for (std::size_t i = 0; i < size; ++i) is_rising[i] = (is_unknown[i] != 0) | !(greatest[i] < -along.doubt);
    for (std::size_t i = 0; i < here; ++i) rises[first + i] = is_rising[i];
  }
}

/// Returns the footprints of the cells that may occlude.
std::vector<Footprint> footprints_of(Machine machine, const SurfaceCells& active, const SeenFromLight& seen,
                                     const Vec3& falling, const std::stop_token& stop) {
  // The same for all cells, except for their position.
  Footprint of_cell = Footprint::of_nothing();
  for (unsigned corner = 0; corner < 8; ++corner) {
    const float point[3] = {static_cast<float>(corner & 1), static_cast<float>(corner >> 1 & 1),
                            static_cast<float>(corner >> 2 & 1)};
    of_cell.add(seen, point);
  }
  const double fastest = std::abs(falling[seen.height_axis()]);
  float direction[3], doubt = 0;
  for (int a = 0; a < 3; ++a) {
    direction[a] = static_cast<float>(falling[a] / fastest);
    // Two halves of a unit, and 2^-15 of the steepest slope, 254 units.
    doubt += (1 + 0x1p-7F) * std::abs(direction[a]);
  }
  std::vector<std::uint8_t> rises(active.cells().size());
  constexpr std::size_t cells_each = 1 << 14;
  for (std::size_t first = 0; first < rises.size(); first += cells_each) {
    end_if_stopped(stop);
    compiled_for<find_rising>(machine)(active.cells().data() + first, std::min(cells_each, rises.size() - first),
                                       Slope{direction[0], direction[1], direction[2], doubt}, rises.data() + first);
  }
  std::vector<Footprint> footprints;
  footprints.reserve(static_cast<std::size_t>(std::count(rises.begin(), rises.end(), std::uint8_t{1})));
  for_each_until_stopped(0, active.blocks().size(), 1 << 8, stop, [&](std::uint64_t b) {
    const SurfaceCells::Block& block = active.blocks()[b];
    for (std::uint32_t c = block.first_cell; c < block.first_cell + block.cell_count; ++c) {
      if (rises[c] == 0) continue;
      const SurfaceCells::Cell& cell = active.cells()[c];
      const float point[3] = {block.corner[0] + static_cast<float>(cell.place & 3),
                              block.corner[1] + static_cast<float>(cell.place >> 2 & 3),
                              block.corner[2] + static_cast<float>(cell.place >> 4 & 3)};
      Footprint at = Footprint::of_nothing();
      at.add(seen, point);
      footprints.push_back({.low = {at.low[0] + of_cell.low[0], at.low[1] + of_cell.low[1]},
                            .high = {at.high[0] + of_cell.high[0], at.high[1] + of_cell.high[1]},
                            .height = at.height + of_cell.height});
    }
  });
  return footprints;
}

/// The dataset's grid where every rise of the field along a ray lies in a cell, else null.
const UniformGrid* grid_with_occluders(const LoadedDataset& dataset, const RayQuery& query) {
  const UniformGrid* grid = fit_grid(dataset);
  return grid != nullptr && is_answerable_wide(*grid, query) && !grid->has_gaps() ? grid : nullptr;
}

class OccludingCells final : public OccludingSurface {
 public:
  explicit OccludingCells(std::shared_ptr<const SurfaceCells> cells) : cells_(std::move(cells)) {}

  std::shared_ptr<const LightOccluders> of_light(Machine machine, const LightPlace& light, Shadows) const override {
    return grid_occluders_of(machine, cells_, light);
  }
  /// Certain shadows of cells are not known.
  std::shared_ptr<const LightOccluders> with_shadows(Machine, std::shared_ptr<const LightOccluders> before,
                                                     const LightPlace&) const override {
    return before;
  }

 private:
  std::shared_ptr<const SurfaceCells> cells_;
};

std::shared_ptr<const void> source_of_light(const LoadedDataset& dataset, const RayQuery& query,
                                            const LightPlace& light, unsigned, const std::stop_token& stop) {
  const UniformGrid* grid = light.is_one_direction() ? grid_with_occluders(dataset, query) : nullptr;
  return grid != nullptr ? dataset.occupancies->of(grid->ranges(), query.isovalue, stop) : nullptr;
}

std::shared_ptr<const OccludingSurface> occluding_cells(const LoadedDataset& dataset, const RayQuery& query,
                                                        std::shared_ptr<const void>, unsigned threads,
                                                        const std::stop_token& stop) {
  return std::make_shared<const OccludingCells>(SurfaceCells::of(dataset, query, threads, stop));
}

}  // namespace

const OccluderSearch grid_occluder_search{.source = source_of_light, .surface = occluding_cells};

std::shared_ptr<const SurfaceCells> SurfaceCells::of(const LoadedDataset& dataset, const RayQuery& query,
                                                     unsigned threads, const std::stop_token& stop) {
  const UniformGrid* grid = grid_with_occluders(dataset, query);
  if (grid == nullptr) return nullptr;
  const auto active = std::make_shared<SurfaceCells>();
  const auto occupancy = dataset.occupancies->of(grid->ranges(), query.isovalue, stop);
  Found found = cells_of(*grid->source(), *occupancy, query.isovalue, threads, stop);
  active->blocks_ = std::move(found.blocks), active->cells_ = std::move(found.cells);
  return active;
}

std::shared_ptr<const LightOccluders> grid_occluders_of(Machine machine, std::shared_ptr<const SurfaceCells> cells,
                                                        const LightPlace& light) {
  return std::make_shared<const LightOccluders>(
      [machine, cells = std::move(cells), light](StartSide side, const std::stop_token& stop) {
        // Far above the rounding of points and rays, as in prepare_occupancy.
        float farthest = 0;
        for (const SurfaceCells::Block& block : cells->blocks())
          for (const float low : block.corner) farthest = std::max(farthest, low + 4);
        const double margin = 1.0 / 64 + 0x1p-21 * static_cast<double>(farthest);
        const SeenFromLight seen(light.at);
        Occluders occluders;
        occluders.heights.emplace(
            seen, OccluderHeights::Frame{.margin = margin, .ends_rays = true},
            footprints_of(machine, *cells, seen, side == StartSide::outside ? light.at : -light.at, stop), stop);
        return occluders;
      });
}

}  // namespace rhoray::render::wide

#include "render/triangles/facets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "formats/base/stopping.h"
#include "render/cell/side.h"
#include "render/cell/triangle_crossing.h"
#include "render/tets/active_cells.h"
#include "render/triangles/facet_levels.h"

namespace rhoray::render {

namespace {

/// Number of candidates that a thread takes at a time.
constexpr std::size_t candidates_per_part = 256;

/// Number of blocks between looks at the stop token.
constexpr std::uint64_t blocks_per_check = 64;

/// 64 cells, some of which the surface may pass through.
struct Candidates {
  std::uint32_t first;
  std::uint64_t bits;
};

std::vector<Candidates> candidates_of(const TetData& view, double isovalue) {
  std::vector<Candidates> all;
  for_each_candidate(view, isovalue, [&](std::uint32_t first, std::uint64_t bits) { all.push_back({first, bits}); });
  return all;
}

/// Returns a vertex's contribution to its cell: the cell is active when the four contributions add
/// up to 1, 2 or 3.
std::uint8_t count_of(double value, double isovalue) {
  return std::isfinite(value) ? value >= isovalue : 4;
}

/// Appends a cell if it is active, without a branch, which would be unpredictable.
struct ActiveList {
  std::uint32_t* cells;
  std::size_t count = 0;

  void add(std::uint32_t cell, unsigned counted) {
    cells[count] = cell;
    count += counted - 1 < 3;
  }
};

/// Finds the active ones of 64 cells that are in clusters: each vertex of a cluster is evaluated
/// once.
void find_active_in_clusters(const TetData& view, const Candidates& candidates, double isovalue, ActiveList& active) {
  const formats::CellClustersView& clusters = view.clusters();
  for (std::uint64_t bits = candidates.bits; bits != 0;) {
    const std::uint64_t cluster =
        clusters.cluster_of(candidates.first + static_cast<std::uint64_t>(std::countr_zero(bits)));
    const std::span<const std::uint32_t> table = clusters.table(cluster);
    std::array<std::uint8_t, 256> counts;
    for (std::size_t v = 0; v < table.size(); ++v) counts[v] = count_of(view.value_at(table[v]), isovalue);
    const std::uint64_t end = clusters.end_cell(cluster);
    for (std::uint64_t cell = clusters.first_cell(cluster); cell < end; ++cell) {
      const std::array<std::uint8_t, 4>& v = clusters.corners[cell];
      active.add(static_cast<std::uint32_t>(cell),
                 static_cast<unsigned>(counts[v[0]]) + counts[v[1]] + counts[v[2]] + counts[v[3]]);
    }
    bits = end >= candidates.first + 64 ? 0 : bits & ~std::uint64_t{0} << (end - candidates.first);
  }
}

void find_active(const TetData& view, const Candidates& candidates, double isovalue, ActiveList& active) {
  if (view.has_clusters()) return find_active_in_clusters(view, candidates, isovalue, active);
  for (std::uint64_t bits = candidates.bits; bits != 0; bits &= bits - 1) {
    const std::uint32_t cell = candidates.first + static_cast<std::uint32_t>(std::countr_zero(bits));
    unsigned counted = 0;
    for (const std::uint32_t v : view.vertices(cell)) counted += count_of(view.value_at(v), isovalue);
    active.add(cell, counted);
  }
}

/// Returns the cells with data that have values on both sides, in order.
PooledArray<std::uint32_t> active_cells_of(const TetData& view, double isovalue, unsigned threads,
                                           const std::stop_token& stop, const std::shared_ptr<ArrayPool>& pool) {
  const std::vector<Candidates> candidates = candidates_of(view, isovalue);
  std::vector<std::vector<std::uint32_t>> parts(candidates.size() / candidates_per_part + 1);
  for_each_range(parts.size(), 8, threads, [&](std::uint64_t first_part, std::uint64_t end_part) {
    std::vector<std::uint32_t> found(64 * candidates_per_part + 1);
    for_each_until_stopped(first_part, end_part, 1, stop, [&](std::uint64_t part) {
      ActiveList active{found.data()};
      const std::size_t end = std::min<std::size_t>(candidates.size(), (part + 1) * candidates_per_part);
      for (std::size_t c = part * candidates_per_part; c < end; ++c) find_active(view, candidates[c], isovalue, active);
      parts[part].assign(active.cells, active.cells + active.count);
    });
  });
  std::size_t count = 0;
  for (const auto& part : parts) count += part.size();
  PooledArray<std::uint32_t> all(pool, count);
  std::uint32_t* next = all.begin();
  for (const auto& part : parts) next = std::copy(part.begin(), part.end(), next);
  return all;
}

/// The edges on which a facet's corners are, in order around it, for each set of vertices that are
/// inside. Each edge's lower vertex comes first.
struct FacetEdges {
  std::uint8_t edge[4][2];
};
constexpr std::array<FacetEdges, 16> make_facet_edges() {
  std::array<FacetEdges, 16> all{};
  for (unsigned inside = 1; inside < 15; ++inside) {
    std::uint8_t in[4]{}, out[4]{};
    int in_count = 0, out_count = 0;
    for (std::uint8_t i = 0; i < 4; ++i) (inside >> i & 1) != 0 ? in[in_count++] = i : out[out_count++] = i;
    const auto edge = [&](int corner, std::uint8_t a, std::uint8_t b) {
      all[inside].edge[corner][0] = a < b ? a : b;
      all[inside].edge[corner][1] = a < b ? b : a;
    };
    // Neighbours around the facet share a vertex, so they share a face of the cell.
    if (in_count == 2) {
      edge(0, in[0], out[0]), edge(1, in[0], out[1]), edge(2, in[1], out[1]), edge(3, in[1], out[0]);
    } else {
      const std::uint8_t alone = in_count == 1 ? in[0] : out[0];
      const std::uint8_t* others = in_count == 1 ? out : in;
      for (int corner = 0; corner < 4; ++corner) edge(corner, alone, others[corner < 3 ? corner : 2]);
    }
  }
  return all;
}
constexpr std::array<FacetEdges, 16> facet_edges = make_facet_edges();

std::size_t inside_bits(const std::array<double, 4>& values, double isovalue) {
  std::size_t bits = 0;
  for (std::size_t i = 0; i < 4; ++i) bits |= static_cast<std::size_t>(is_inside(values[i] - isovalue)) << i;
  return bits;
}

/// Moves bits 0 to 9 of x to every third bit.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

/// Returns the index of a point with coordinates from -1 to 1 on a Morton curve of 1024 steps along
/// each axis. Points outside are clamped; a NaN coordinate gets the first step.
std::uint32_t morton_code(const std::array<double, 3>& p) {
  std::uint32_t code = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    code |= spread(static_cast<std::uint32_t>(std::min(std::max(0.0, 512 * (p[axis] + 1)), 1023.0))) << axis;
  return code;
}

/// A cell and its index on the curve.
struct PlacedCell {
  std::uint32_t cell, code;
};

/// Sorts by 30 bits of `code`; the sort is stable.
void sort_by_code(PooledArray<PlacedCell>& cells, const std::shared_ptr<ArrayPool>& pool) {
  PooledArray<PlacedCell> other(pool, cells.size());
  for (int shift = 0; shift < 30; shift += 10) {
    std::array<std::uint32_t, 1024> start{};
    for (const PlacedCell& cell : cells) ++start[cell.code >> shift & 1023];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) sum += std::exchange(s, sum);
    for (const PlacedCell& cell : cells) other[start[cell.code >> shift & 1023]++] = cell;
    std::swap(cells, other);
  }
}

/// Cells of a block of facets, with vertices in increasing order; each component has sixteen
/// numbers side by side.
struct BlockCells {
  static constexpr std::size_t size = FacetBlock::size;
  double point[4][3][size];  ///< [vertex][axis]
  double value[4][size];     ///< [vertex]
};

/// Gathers the cells; unused lanes repeat the last one.
void gather(const TetData& view, std::span<const PlacedCell> placed, BlockCells& cells) {
  for (std::size_t f = 0; f < BlockCells::size; ++f) {
    const auto vertices = view.sorted_vertices(placed[std::min(f, placed.size() - 1)].cell);
    const auto points = view.points_at(vertices);
    for (std::size_t v = 0; v < 4; ++v) {
      cells.value[v][f] = view.value_at(vertices[v]);
      for (std::size_t axis = 0; axis < 3; ++axis) cells.point[v][axis][f] = points[v][axis];
    }
  }
}

void find_corners(const BlockCells& cells, double isovalue, const Vec3& anchor, double scale, FacetBlock& block) {
  constexpr std::size_t size = BlockCells::size;
  double place[4][3][size];
  for (std::size_t v = 0; v < 4; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double middle = anchor[static_cast<int>(axis)];
      for (std::size_t f = 0; f < size; ++f) place[v][axis][f] = (cells.point[v][axis][f] - middle) * scale;
    }
  const FacetEdges* edges[size];
  for (std::size_t f = 0; f < size; ++f)
    edges[f] = &facet_edges[inside_bits({cells.value[0][f], cells.value[1][f], cells.value[2][f], cells.value[3][f]},
                                        isovalue)];
  for (std::size_t corner = 0; corner < 4; ++corner) {
    double from[3][size], to[3][size], value_from[size], value_to[size];
    for (std::size_t f = 0; f < size; ++f) {
      const std::size_t a = edges[f]->edge[corner][0], b = edges[f]->edge[corner][1];
      value_from[f] = cells.value[a][f], value_to[f] = cells.value[b][f];
      for (std::size_t axis = 0; axis < 3; ++axis) from[axis][f] = place[a][axis][f], to[axis][f] = place[b][axis][f];
    }
    double share[size];
    for (std::size_t f = 0; f < size; ++f) share[f] = (isovalue - value_from[f]) / (value_to[f] - value_from[f]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t f = 0; f < size; ++f)
        block.corner[corner][axis][f] = static_cast<float>((1 - share[f]) * from[axis][f] + share[f] * to[axis][f]);
  }
}

/// Computes six times the volumes and the gradients of cells, bit for bit as tet_gradient.
void find_gradients(const BlockCells& cells, double* six_volumes, double (*gradient)[BlockCells::size]) {
  constexpr std::size_t size = BlockCells::size;
  double flat[size];
  for (std::size_t f = 0; f < size; ++f) {
    const auto edge = [&](std::size_t to) {
      return Vec3(cells.point[to][0][f] - cells.point[0][0][f], cells.point[to][1][f] - cells.point[0][1][f],
                  cells.point[to][2][f] - cells.point[0][2][f]);
    };
    const Vec3 a = edge(1), b = edge(2), c = edge(3);
    const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
    const double volumes = a.dot(bc);
    const Vec3 sum = (cells.value[1][f] - cells.value[0][f]) * bc + (cells.value[2][f] - cells.value[0][f]) * ca +
                     (cells.value[3][f] - cells.value[0][f]) * ab;
    gradient[0][f] = sum.x / volumes, gradient[1][f] = sum.y / volumes, gradient[2][f] = sum.z / volumes;
    six_volumes[f] = std::abs(volumes);
    flat[f] = 1 / volumes;
  }
  for (std::size_t f = 0; f < size; ++f) {
    if (std::isfinite(flat[f])) continue;
    std::array<std::array<double, 3>, 4> points;
    for (std::size_t v = 0; v < 4; ++v)
      for (std::size_t axis = 0; axis < 3; ++axis) points[v][axis] = cells.point[v][axis][f];
    const Vec3 g = tet_gradient(points, {cells.value[0][f], cells.value[1][f], cells.value[2][f], cells.value[3][f]});
    for (std::size_t axis = 0; axis < 3; ++axis) gradient[axis][f] = g[static_cast<int>(axis)];
  }
}

/// Computes the fields of cells. A cell's volume may be less than 2^-20 of the product of its
/// edges' lengths. Then the sum of a few rounded products is unreliable and the gradient is in
/// doubt. Above that, its error is less than 2^-53 * 64 * 2^20 of itself, relative to that product.
void find_fields(const BlockCells& cells, double isovalue, const Vec3& anchor, std::span<FacetField> fields) {
  constexpr std::size_t size = BlockCells::size;
  constexpr double largest = std::numeric_limits<double>::max();
  double six_volumes[size], gradient[3][size], value[size], cell_size[size], doubt[size];
  find_gradients(cells, six_volumes, gradient);
  for (std::size_t f = 0; f < size; ++f) {
    Vec3 p[4];
    for (std::size_t v = 0; v < 4; ++v) p[v] = {cells.point[v][0][f], cells.point[v][1][f], cells.point[v][2][f]};
    const Vec3 a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0], g(gradient[0][f], gradient[1][f], gradient[2][f]);
    const auto larger = [](double x, double y) { return x < y ? y : x; };
    const auto smaller = [](double x, double y) { return x < y ? x : y; };
    const double size2 = larger(larger(larger(a.dot(a), b.dot(b)), larger(c.dot(c), (b - a).dot(b - a))),
                                larger((c - a).dot(c - a), (c - b).dot(c - b)));
    const double* v[4] = {cells.value[0], cells.value[1], cells.value[2], cells.value[3]};
    const double low = smaller(smaller(v[0][f], v[1][f]), smaller(v[2][f], v[3][f]));
    const double high = larger(larger(v[0][f], v[1][f]), larger(v[2][f], v[3][f]));
    const double length = std::sqrt(size2), cube = size2 * length, shape = cube / six_volumes[f];
    value[f] = (v[0][f] - isovalue) - g.dot(p[0] - anchor);
    cell_size[f] = length;
    // At least the smallest float: as a float, a smaller number would become 0.
    const double rounding = larger(0x1p-44 * (high - low) * shape * shape, std::numeric_limits<float>::denorm_min());
    const bool is_told = six_volumes[f] > 0x1p-20 * cube && std::abs(value[f]) <= largest;
    doubt[f] = is_told ? rounding : std::numeric_limits<double>::infinity();
  }
  for (std::size_t f = 0; f < fields.size(); ++f)
    fields[f] = {.gradient = {gradient[0][f], gradient[1][f], gradient[2][f]},
                 .value = value[f],
                 .cell = 0,
                 .tet = 0,
                 .cell_size = static_cast<float>(cell_size[f]),
                 .doubt = static_cast<float>(doubt[f])};
}

/// Returns the plane of a triangle as its field. Where its height is less than 2^-20 of its longest
/// edge, rounding makes the normal unreliable.
FacetField plane_of(const TrianglePoints& p, const Vec3& anchor) {
  const Vec3 normal = triangle_normal(p);
  const auto corner = [&](std::size_t i) { return Vec3(p[i][0], p[i][1], p[i][2]); };
  const double longest =
      std::max({(corner(1) - corner(0)).length(), (corner(2) - corner(1)).length(), (corner(0) - corner(2)).length()});
  const bool is_told = normal.length() > 0x1p-20 * longest * longest;
  return {.gradient = {normal.x, normal.y, normal.z},
          .value = -normal.dot(corner(0) - anchor),
          .cell = 0,
          .tet = 0,
          .cell_size = static_cast<float>(longest),
          .doubt = is_told ? 0 : std::numeric_limits<float>::infinity()};
}

/// Returns the smallest and the largest number of lists of sixteen.
Interval<float> range_of(std::span<const float* const> lists) {
  constexpr std::size_t size = FacetBlock::size;
  static_assert(FacetNode::size == size);
  float low[size], high[size];
  std::fill_n(low, size, FacetNode::nowhere);
  std::fill_n(high, size, -FacetNode::nowhere);
  for (const float* list : lists)
    for (std::size_t i = 0; i < size; ++i) {
      low[i] = list[i] < low[i] ? list[i] : low[i];
      high[i] = list[i] > high[i] ? list[i] : high[i];
    }
  for (std::size_t half = size / 2; half > 0; half /= 2)
    for (std::size_t i = 0; i < half; ++i) {
      low[i] = low[i + half] < low[i] ? low[i + half] : low[i];
      high[i] = high[i + half] > high[i] ? high[i + half] : high[i];
    }
  return {low[0], high[0]};
}

}  // namespace

void Facets::set_frame(const Box3& bounds) {
  // Halve first: neither the sum nor the difference of two finite numbers needs to be finite.
  anchor_ = 0.5 * bounds.min + 0.5 * bounds.max;
  const Vec3 half = 0.5 * bounds.max - 0.5 * bounds.min;
  const double largest = std::max({half.x, half.y, half.z});
  if (!(largest > 0)) return;
  int exponent = 0;
  const double fraction = std::frexp(largest, &exponent);
  // After rounding of the middle a point may be slightly farther away than half the size.
  if (fraction * (1 + 0x1p-20) >= 1) ++exponent;
  constexpr int least_exponent = -1022;  // the scale of anything smaller is infinite
  scale_ = std::ldexp(1.0, -std::max(exponent, least_exponent));
}

Vec3 Facets::in_frame(const std::array<double, 3>& p) const {
  return (Vec3(p[0], p[1], p[2]) - anchor_) * scale_;
}

Facets::Facets(const TriangleData& view, const Box3& bounds, unsigned threads, const std::stop_token& stop) {
  set_frame(bounds);
  const std::shared_ptr<ArrayPool> pool;  // none: a surface is prepared once
  PooledArray<PlacedCell> placed(pool, view.triangle_count());
  for_each_range(placed.size(), 1 << 14, threads, [&](std::uint64_t first, std::uint64_t end) {
    for (auto t = static_cast<std::uint32_t>(first); t < end; ++t) {
      const TrianglePoints points = view.points_at(view.vertices(t));
      const Vec3 middle = (in_frame(points[0]) + in_frame(points[1]) + in_frame(points[2])) / 3;
      placed[t] = {t, morton_code({middle.x, middle.y, middle.z})};
    }
  });
  end_if_stopped(stop);
  sort_by_code(placed, pool);

  count_ = static_cast<std::uint32_t>(placed.size());
  blocks_ = {pool, block_count()};
  fields_ = {pool, count_};
  const auto prepare_block = [&](std::uint64_t b) {
    for (std::size_t f = b * FacetBlock::size; f < (b + 1) * FacetBlock::size; ++f) {
      const std::uint32_t triangle = placed[std::min<std::size_t>(f, count_ - 1)].cell;
      const TrianglePoints points = view.points_at(view.vertices(triangle));
      FacetBlock& block = blocks_[f / FacetBlock::size];
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const Vec3 place = in_frame(points[std::min<std::size_t>(corner, 2)]);
        for (std::size_t axis = 0; axis < 3; ++axis)
          block.corner[corner][axis][f % FacetBlock::size] = static_cast<float>(place[static_cast<int>(axis)]);
      }
      if (f >= count_) continue;
      fields_[f] = plane_of(points, anchor_);
      fields_[f].tet = triangle;
      fields_[f].cell = static_cast<std::uint32_t>(view.cell_id(triangle));
    }
  };
  for_each_until_stopped(block_count(), 256, blocks_per_check, threads, stop, prepare_block);
  build_levels();
}

Facets::Facets(const TetData& view, const Box3& bounds, double isovalue, unsigned threads, const std::stop_token& stop,
               const std::shared_ptr<ArrayPool>& pool) {
  set_frame(bounds);
  const PooledArray<std::uint32_t> active = active_cells_of(view, isovalue, threads, stop, pool);
  PooledArray<PlacedCell> placed(pool, active.size());
  for_each_range(active.size(), 1 << 14, threads, [&](std::uint64_t first, std::uint64_t end) {
    for (std::uint64_t i = first; i < end; ++i) {
      const auto points = view.points_at(view.vertices(active[i]));
      const Vec3 middle =
          0.25 * (in_frame(points[0]) + in_frame(points[1]) + in_frame(points[2]) + in_frame(points[3]));
      placed[i] = {active[i], morton_code({middle.x, middle.y, middle.z})};
    }
  });
  end_if_stopped(stop);
  sort_by_code(placed, pool);

  count_ = static_cast<std::uint32_t>(placed.size());
  blocks_ = {pool, block_count()};
  fields_ = {pool, count_};
  for_each_range(block_count(), 256, threads, [&](std::uint64_t first_block, std::uint64_t end_block) {
    BlockCells cells;
    for_each_until_stopped(first_block, end_block, blocks_per_check, stop, [&](std::uint64_t b) {
      const std::size_t first = b * FacetBlock::size;
      const std::size_t in_block = std::min<std::size_t>(FacetBlock::size, placed.size() - first);
      const std::span<FacetField> fields(fields_.data() + first, in_block);
      gather(view, placed.subspan(first, in_block), cells);
      find_corners(cells, isovalue, anchor_, scale_, blocks_[b]);
      find_fields(cells, isovalue, anchor_, fields);
      for (std::size_t f = 0; f < in_block; ++f) {
        fields[f].tet = placed[first + f].cell;
        fields[f].cell = static_cast<std::uint32_t>(view.cell_id(fields[f].tet));
      }
    });
  });
  build_levels();
}

BoxLevels levels_above(const FacetBlock* blocks, std::size_t count) {
  BoxLevels levels;
  std::vector<FacetNode>& lowest = levels.emplace_back(
      std::vector<FacetNode>((count + FacetNode::size - 1) / FacetNode::size, FacetNode::of_empty_boxes()));
  for (std::size_t b = 0; b < count; ++b)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& corner = blocks[b].corner;
      const Interval<float> range =
          range_of(std::array{corner[0][axis], corner[1][axis], corner[2][axis], corner[3][axis]});
      lowest[b / FacetNode::size].low[axis][b % FacetNode::size] = range.lo;
      lowest[b / FacetNode::size].high[axis][b % FacetNode::size] = range.hi;
    }
  add_upper_levels(levels);
  return levels;
}

FloatBox box_of(const BoxLevels& levels) {
  FloatBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = FacetNode::nowhere, box.high[axis] = -FacetNode::nowhere;
    if (levels.back().empty()) continue;
    const FacetNode& top = levels.back().front();
    box.low[axis] = range_of(std::array{top.low[axis]}).lo;
    box.high[axis] = range_of(std::array{top.high[axis]}).hi;
  }
  return box;
}

void Facets::build_levels() {
  levels_ = levels_above(blocks_.data(), block_count());
  const FloatBox box = box_of(levels_);
  low_ = box.low, high_ = box.high;
}

const FacetNeighbours& Facets::neighbours(const std::stop_token& stop) const {
  const StoppableLock lock(neighbours_mutex_, stop);
  if (!neighbours_) neighbours_ = std::make_unique<FacetNeighbours>(blocks_.data(), fields_.data(), count_, stop);
  return *neighbours_;
}

std::size_t Facets::size_bytes() const {
  std::size_t bytes = block_count() * sizeof(FacetBlock) + count_ * sizeof(FacetField);
  for (const auto& nodes : levels_) bytes += nodes.size() * sizeof(FacetNode);
  const StoppableLock lock(neighbours_mutex_, {});
  return bytes + (neighbours_ ? neighbours_->size_bytes() : 0);
}

}  // namespace rhoray::render

#include "render/volumes/facets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"
#include "render/cells/side.h"
#include "render/volumes/active_cells.h"

namespace rhoray::render {

namespace {

/// What a thread takes at a time.
constexpr std::size_t candidates_per_part = 256;

/// 64 cells, some of which the surface may pass through.
struct Candidates {
  std::uint32_t first;
  std::uint64_t bits;
};

template <class T>
std::vector<Candidates> candidates_of(const TetVolume<T>& view, double isovalue) {
  std::vector<Candidates> all;
  for_each_candidate(view, isovalue, [&](std::uint32_t first, std::uint64_t bits) { all.push_back({first, bits}); });
  return all;
}

/// How a vertex counts among a cell's four: the cell is active where they add up to 1, 2 or 3.
std::uint8_t count_of(double value, double isovalue) {
  return std::isfinite(value) ? value >= isovalue : 4;
}

/// Appends a cell that is active, without a branch, which would be a guess.
struct ActiveList {
  std::uint32_t* cells;
  std::size_t count = 0;

  void add(std::uint32_t cell, unsigned counted) {
    cells[count] = cell;
    count += counted - 1 < 3;
  }
};

/// The active ones of 64 cells that are in clusters: each vertex of a cluster is looked at once.
template <class T>
void find_active_in_clusters(const TetVolume<T>& view, const Candidates& candidates, double isovalue,
                             ActiveList& active) {
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

template <class T>
void find_active(const TetVolume<T>& view, const Candidates& candidates, double isovalue, ActiveList& active) {
  if (view.has_clusters()) return find_active_in_clusters(view, candidates, isovalue, active);
  for (std::uint64_t bits = candidates.bits; bits != 0; bits &= bits - 1) {
    const std::uint32_t cell = candidates.first + static_cast<std::uint32_t>(std::countr_zero(bits));
    unsigned counted = 0;
    for (const std::uint32_t v : view.vertices(cell)) counted += count_of(view.value_at(v), isovalue);
    active.add(cell, counted);
  }
}

/// Cells with data that have values on both sides, in their order.
template <class T>
std::vector<std::uint32_t> active_cells_of(const TetVolume<T>& view, double isovalue, unsigned threads) {
  const std::vector<Candidates> candidates = candidates_of(view, isovalue);
  std::vector<std::vector<std::uint32_t>> parts(candidates.size() / candidates_per_part + 1);
  for_each_range(parts.size(), 8, threads, [&](std::uint64_t first_part, std::uint64_t end_part) {
    std::vector<std::uint32_t> found(64 * candidates_per_part + 1);
    for (std::uint64_t part = first_part; part < end_part; ++part) {
      ActiveList active{found.data()};
      const std::size_t end = std::min<std::size_t>(candidates.size(), (part + 1) * candidates_per_part);
      for (std::size_t c = part * candidates_per_part; c < end; ++c) find_active(view, candidates[c], isovalue, active);
      parts[part].assign(active.cells, active.cells + active.count);
    }
  });
  std::vector<std::uint32_t> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// The edges on which a facet's corners lie, round it, by the vertices that are inside; each edge's lower vertex first.
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
    if (in_count == 2) {  // neighbours round it share a vertex: a face of the cell
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

/// Bits 0 to 9 of x moved to every third place.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

/// The place of a point, with coordinates from -1 to 1, on a Morton curve of 1024 steps along each axis.
std::uint32_t morton_code(const std::array<double, 3>& p) {
  std::uint32_t code = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    code |= spread(static_cast<std::uint32_t>(std::clamp(512 * (p[axis] + 1), 0.0, 1023.0))) << axis;
  return code;
}

/// Sorts by 30 bits of `code`; equal ones stay in order.
template <class Item>
void sort_by_code(std::vector<Item>& items) {
  std::vector<Item> other(items.size());
  for (int shift = 0; shift < 30; shift += 10) {
    std::array<std::uint32_t, 1024> start{};
    for (const Item& item : items) ++start[item.code >> shift & 1023];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) sum += std::exchange(s, sum);
    for (const Item& item : items) other[start[item.code >> shift & 1023]++] = item;
    items.swap(other);
  }
}

struct PlacedCell {
  std::uint32_t cell, code;
};

/// The field of a cell, with vertices in rising order. Where the cell's volume is less than 2^-20 of the product of its
/// edges' lengths, and the sum of a few rounded products of them says little, the gradient is in doubt; above, it is
/// off by less than 2^-53 * 64 * 2^20 of itself, taken with that product.
FacetField field_of(const std::array<std::array<double, 3>, 4>& points, const std::array<double, 4>& values,
                    double isovalue, const Vec3& anchor) {
  const auto edge = [&](std::size_t to) {
    return Vec3(points[to][0] - points[0][0], points[to][1] - points[0][1], points[to][2] - points[0][2]);
  };
  const Vec3 a = edge(1), b = edge(2), c = edge(3);
  const double size2 =
      std::max({a.length2(), b.length2(), c.length2(), (b - a).length2(), (c - a).length2(), (c - b).length2()});
  const Vec3 g = tet_gradient(points, values);
  FacetField field{.gradient = {g.x, g.y, g.z},
                   .value = (values[0] - isovalue) - g.dot(Vec3(points[0][0], points[0][1], points[0][2]) - anchor),
                   .cell = 0,
                   .cell_size = static_cast<float>(std::sqrt(size2)),
                   .doubt = std::numeric_limits<float>::infinity()};
  const double six_volumes = std::abs(a.dot(b.cross(c)));
  const auto [lo, hi] = std::minmax({values[0], values[1], values[2], values[3]});
  const double cube = size2 * std::sqrt(size2);
  if (six_volumes > 0x1p-20 * cube && std::isfinite(field.value))
    field.doubt = static_cast<float>(0x1p-44 * (hi - lo) * (cube / six_volumes) * (cube / six_volumes));
  return field;
}

}  // namespace

template <class T>
Facets::Facets(const TetVolume<T>& view, const Box3& bounds, double isovalue, unsigned threads)
    : anchor_(bounds.center()) {
  const Vec3 half = 0.5 * bounds.size();
  const double largest = std::max({half.x, half.y, half.z});
  // Rounding of the middle may leave a point a little farther away than half the size.
  if (largest > 0) scale_ = std::ldexp(1.0, -(std::ilogb(largest * (1 + 0x1p-20)) + 1));

  const auto in_frame = [&](const std::array<double, 3>& p, std::size_t axis) {
    return (p[axis] - anchor_[static_cast<int>(axis)]) * scale_;
  };
  const std::vector<std::uint32_t> active = active_cells_of(view, isovalue, threads);
  std::vector<PlacedCell> placed(active.size());
  for_each_range(active.size(), 1 << 14, threads, [&](std::uint64_t first, std::uint64_t end) {
    for (std::uint64_t i = first; i < end; ++i) {
      const auto points = view.points_at(view.vertices(active[i]));
      std::array<double, 3> middle;
      for (std::size_t axis = 0; axis < 3; ++axis)
        middle[axis] = 0.25 * (in_frame(points[0], axis) + in_frame(points[1], axis) + in_frame(points[2], axis) +
                               in_frame(points[3], axis));
      placed[i] = {active[i], morton_code(middle)};
    }
  });
  sort_by_code(placed);

  count_ = static_cast<std::uint32_t>(placed.size());
  blocks_.resize((placed.size() + FacetBlock::size - 1) / FacetBlock::size);
  fields_.resize(placed.size());
  cells_.resize(placed.size());
  for_each_range(blocks_.size(), 256, threads, [&](std::uint64_t first_block, std::uint64_t end_block) {
    const auto end = static_cast<std::uint32_t>(std::min<std::uint64_t>(count_, end_block * FacetBlock::size));
    for (auto f = static_cast<std::uint32_t>(first_block * FacetBlock::size); f < end; ++f) {
      const std::uint32_t cell = placed[f].cell;
      const auto vertices = view.sorted_vertices(cell);
      const auto points = view.points_at(vertices);
      const auto values = view.values_at(vertices);
      const FacetEdges& edges = facet_edges[inside_bits(values, isovalue)];
      FacetBlock& block = blocks_[f / FacetBlock::size];
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const std::size_t a = edges.edge[corner][0], b = edges.edge[corner][1];
        const double s = (isovalue - values[a]) / (values[b] - values[a]);
        for (std::size_t axis = 0; axis < 3; ++axis)
          block.corner[corner][axis][f % FacetBlock::size] =
              static_cast<float>((1 - s) * in_frame(points[a], axis) + s * in_frame(points[b], axis));
      }
      fields_[f] = field_of(points, values, isovalue, anchor_);
      fields_[f].cell = view.cell_id(cell);
      cells_[f] = cell;
    }
  });
  build_levels();
}

void Facets::build_levels() {
  std::vector<FacetNode>& lowest = levels_.emplace_back(
      std::vector<FacetNode>((blocks_.size() + FacetNode::size - 1) / FacetNode::size, FacetNode::of_empty_boxes()));
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const std::size_t in_block = std::min<std::size_t>(FacetBlock::size, count_ - b * FacetBlock::size);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float& low = lowest[b / FacetNode::size].low[axis][b % FacetNode::size];
      float& high = lowest[b / FacetNode::size].high[axis][b % FacetNode::size];
      for (std::size_t corner = 0; corner < 4; ++corner)
        for (std::size_t f = 0; f < in_block; ++f) {
          low = std::min(low, blocks_[b].corner[corner][axis][f]);
          high = std::max(high, blocks_[b].corner[corner][axis][f]);
        }
    }
  }
  add_upper_levels(levels_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low_[axis] = FacetNode::nowhere, high_[axis] = -FacetNode::nowhere;
    if (levels_.back().empty()) continue;
    const FacetNode& top = levels_.back().front();
    low_[axis] = *std::min_element(top.low[axis], top.low[axis] + FacetNode::size);
    high_[axis] = *std::max_element(top.high[axis], top.high[axis] + FacetNode::size);
  }
}

std::size_t Facets::size_bytes() const {
  std::size_t bytes =
      blocks_.size() * sizeof(FacetBlock) + fields_.size() * (sizeof(FacetField) + sizeof(std::uint32_t));
  for (const auto& nodes : levels_) bytes += nodes.size() * sizeof(FacetNode);
  return bytes;
}

template Facets::Facets(const TetVolume<float>&, const Box3&, double, unsigned);
template Facets::Facets(const TetVolume<double>&, const Box3&, double, unsigned);

}  // namespace rhoray::render

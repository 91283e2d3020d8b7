#include "render/dataset/shown_boxes.h"

#include <algorithm>
#include <variant>

#include "formats/base/stopping.h"

namespace rhoray::render {

namespace {

/// A block of crossed cells, so far.
struct CrossedCells {
  CellBlock block{{0, 0, 0}, {0, 0, 0}};

  bool is_empty() const { return block.first == block.end; }

  void include(const Index3& cell) {
    for (int axis = 0; axis < 3; ++axis) {
      block.first[axis] = is_empty_before(axis) ? cell[axis] : std::min(block.first[axis], cell[axis]);
      block.end[axis] = std::max(block.end[axis], cell[axis] + 1);
    }
  }

  bool contains(const CellBlock& other) const {
    for (int axis = 0; axis < 3; ++axis)
      if (other.first[axis] < block.first[axis] || other.end[axis] > block.end[axis]) return false;
    return true;
  }

 private:
  bool is_empty_before(int axis) const { return block.end[axis] == 0; }
};

template <class Grid>
bool is_crossed(const Grid& view, const Index3& c, double isovalue) {
  const TrilinearCell cell = view.cell(c);
  if (!view.has_data(cell)) return false;
  const auto [lo, hi] = std::minmax_element(cell.corner.begin(), cell.corner.end());
  return *lo < isovalue && isovalue <= *hi;
}

/// Includes the crossed cells of a block.
template <class Grid>
void include_block(const Grid& view, const CellBlock& block, double isovalue, CrossedCells& cells) {
  if (cells.contains(block)) return;
  Index3 c;
  for (c.z = block.first.z; c.z < block.end.z; ++c.z)
    for (c.y = block.first.y; c.y < block.end.y; ++c.y)
      for (c.x = block.first.x; c.x < block.end.x; ++c.x)
        if (is_crossed(view, c, isovalue)) cells.include(c);
}

/// Width of the rows of cells, up to that of a macrocell.
std::int64_t row_width(const WalkLattice& lattice) {
  constexpr std::int64_t enough_rows = 128 * 128;
  const std::int64_t most = lattice.cell_edge(1);
  std::int64_t width = 1;
  while (width < most && lattice.leaf_count.y / width * (lattice.leaf_count.z / width) > enough_rows) width *= 2;
  return std::min(width, most);
}

/// Calls act(macrocells) for each row of lowest-level macrocells along x, with those that may be
/// crossed. The ends come first, because most others lie between them.
template <class Grid, class Act>
void for_each_row(const Grid& view, double isovalue, const Watch& watch, const Act& act) {
  const WalkLattice lattice = view.lattice();
  const Index3 count = whole_level(lattice, lattice.cell_edge(1)).end;
  std::vector<Index3> row;
  ProgressMeter meter(watch.progress, "finding the surface (macrocells)", static_cast<std::uint64_t>(volume(count)));
  Index3 c;
  for (c.z = 0; c.z < count.z; ++c.z)
    for (c.y = 0; c.y < count.y; ++c.y) {
      end_if_stopped(watch.stop);
      row.clear();
      for (c.x = 0; c.x < count.x; ++c.x) {
        const Interval<double> range = view.range(1, c);
        if (range.lo < isovalue && isovalue <= range.hi) row.push_back(c);
      }
      if (row.size() > 1) std::swap(row[1], row.back());
      if (!row.empty()) act(row);
      meter.add(static_cast<std::uint64_t>(count.x));
    }
}

template <class Geometry>
std::vector<Box3> boxes_in(const PlacedGrid<Geometry>& view, const LoadedDataset&, double isovalue,
                           const Watch& watch) {
  const WalkLattice lattice = view.lattice();
  const std::int64_t width = row_width(lattice);
  const auto planes = view.geometry().planes();
  std::vector<Box3> boxes;
  for_each_row(view, isovalue, watch, [&](const std::vector<Index3>& row) {
    const CellBlock of_row = children(lattice, row[0], 1);
    Index3 low = of_row.first;
    for (low.z = of_row.first.z; low.z < of_row.end.z; low.z += width)
      for (low.y = of_row.first.y; low.y < of_row.end.y; low.y += width) {
        CrossedCells cells;
        for (const Index3& macrocell : row) {
          CellBlock block = children(lattice, macrocell, 1);
          for (const int axis : {1, 2}) {
            block.first[axis] = low[axis];
            block.end[axis] = std::min(low[axis] + width, of_row.end[axis]);
          }
          include_block(view, block, isovalue, cells);
        }
        if (cells.is_empty()) continue;
        Box3& box = boxes.emplace_back();
        for (int axis = 0; axis < 3; ++axis) {
          box.min[axis] = planes.position(axis, cells.block.first[axis]);
          box.max[axis] = planes.position(axis, cells.block.end[axis]);
        }
      }
  });
  return boxes;
}

/// Boxes around points, by columns along x of the data's bounds.
class Columns {
 public:
  explicit Columns(const Box3& bounds) : low_(bounds.min), size_(bounds.size()), boxes_(edge * edge) {}

  void include(const Vec3& p) { boxes_[column(1, p) + edge * column(2, p)].extendBy(p); }

  std::vector<Box3> take() {
    std::erase_if(boxes_, [](const Box3& box) { return box.isEmpty(); });
    return std::move(boxes_);
  }

 private:
  static constexpr std::size_t edge = 128;

  std::size_t column(int axis, const Vec3& p) const {
    const double share = (p[axis] - low_[axis]) / size_[axis];
    if (!(share > 0)) return 0;  // written so that a NaN leaves here: the bounds may be flat
    return std::min(static_cast<std::size_t>(share * edge), edge - 1);
  }

  Vec3 low_, size_;
  std::vector<Box3> boxes_;
};

/// A tetrahedron's part of the isosurface is the polygon between the crossings of its edges.
std::vector<Box3> boxes_in(const TetData& view, const LoadedDataset& dataset, double isovalue, const Watch& watch) {
  Columns columns(dataset.bounds_data);
  const auto include = [&](std::uint64_t cell) {
    const auto vertices = view.sorted_vertices(static_cast<std::uint32_t>(cell));
    const auto values = view.values_at(vertices);
    const auto [lo, hi] = std::minmax({values[0], values[1], values[2], values[3]});
    if (!(lo < isovalue && isovalue <= hi) || !has_data(values)) return;
    const auto points = view.points_at(vertices);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b) {
        if ((values[a] >= isovalue) == (values[b] >= isovalue)) continue;
        const double share = (isovalue - values[a]) / (values[b] - values[a]);
        const Vec3 from(points[a][0], points[a][1], points[a][2]), to(points[b][0], points[b][1], points[b][2]);
        columns.include((1 - share) * from + share * to);
      }
  };
  const std::uint64_t cell_count = view.description().cell_count;
  ProgressMeter meter(watch.progress, "finding the surface (cells)", cell_count);
  for_each_until_stopped(0, cell_count, light_piece, watch.stop, include, &meter);
  return columns.take();
}

std::vector<Box3> boxes_in(const TriangleData& view, const LoadedDataset& dataset, double, const Watch& watch) {
  Columns columns(dataset.bounds_data);
  for_each_until_stopped(0, view.triangle_count(), light_piece, watch.stop, [&](std::uint64_t triangle) {
    for (const auto& [x, y, z] : view.points_at(view.vertices(static_cast<std::uint32_t>(triangle))))
      columns.include({x, y, z});
  });
  return columns.take();
}

}  // namespace

std::vector<Box3> shown_boxes(const LoadedDataset& dataset, double isovalue, const Watch& watch) {
  return std::visit([&](const auto& view) { return boxes_in(view, dataset, isovalue, watch); }, dataset.view);
}

}  // namespace rhoray::render

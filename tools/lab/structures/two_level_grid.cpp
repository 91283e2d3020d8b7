#include "tools/lab/structures/two_level_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tools/lab/structures/cell_sides.h"

namespace rhoray::study {
namespace {

constexpr Interval<float> no_value{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};

void extend(Interval<float>& range, const Interval<float>& by) {
  range = {std::min(range.lo, by.lo), std::max(range.hi, by.hi)};
}

/// A division of a box of this size into about this many nearly cubic cells.
Index3 division(const Vec3& size, double cell_count) {
  const double edge = std::cbrt(size.x * size.y * size.z / cell_count);
  Index3 count;
  for (int axis = 0; axis < 3; ++axis)
    count[axis] =
        std::clamp<std::int64_t>(std::llround(size[axis] / edge), 1, std::numeric_limits<std::uint16_t>::max());
  return count;
}

/// Calls visit(cell) for the cells of a lattice that a tetrahedron touches.
/// @param low   the lattice's lowest corner
/// @param size  of its cells
template <class Visit>
void for_each_touched(const CellSides& sides, const Box3& box, const Vec3& low, const Vec3& size, const Index3& count,
                      Visit&& visit) {
  constexpr double margin = 1e-6;  // as in CellSides
  Index3 first, last;
  for (int axis = 0; axis < 3; ++axis) {
    const auto last_cell = static_cast<double>(count[axis] - 1);
    const auto cell_of = [&](double x, double shift) {
      return static_cast<std::int64_t>(std::clamp(std::floor((x - low[axis]) / size[axis] + shift), 0.0, last_cell));
    };
    first[axis] = cell_of(box.min[axis], -margin);
    last[axis] = cell_of(box.max[axis], margin);
  }
  Index3 cell;
  for (cell.z = first.z; cell.z <= last.z; ++cell.z)
    for (cell.y = first.y; cell.y <= last.y; ++cell.y)
      for (cell.x = first.x; cell.x <= last.x; ++cell.x)
        if (sides.touches(low + size * (Vec3(cell) + Vec3(0.5)), size * 0.5)) visit(cell);
}

std::size_t place_in(const Index3& count, const Index3& cell) {
  return static_cast<std::size_t>((cell.z * count.y + cell.y) * count.x + cell.x);
}

}  // namespace

std::size_t RangeLevels::at(int level, const Index3& cell) const {
  const Index3 count = render::whole_level(lattice, lattice.cell_edge(level)).end;
  return place_in(count, cell);
}

std::uint64_t RangeLevels::bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& level : levels) bytes += level.size() * sizeof level[0];
  return bytes;
}

TwoLevelGrid::TwoLevelGrid(const PlainMesh& mesh, double cells_per_top_cell) {
  Box3 box = mesh.bounds();
  const Vec3 rim = box.size() * 0x1p-20 + Vec3(std::numeric_limits<double>::min());
  box = {box.min - rim, box.max + rim};
  upper_.lattice = {division(box.size(), std::max(1.0, mesh.cell_count() / cells_per_top_cell)), 4};
  low_ = box.min;
  top_size_ = box.size() / Vec3(upper_.lattice.leaf_count);
  divide(mesh);
  collect_ranges(mesh);
}

Index3 TwoLevelGrid::top_cell_of(const Vec3& point) const {
  Index3 cell;
  for (int axis = 0; axis < 3; ++axis)
    cell[axis] = std::clamp<std::int64_t>(static_cast<std::int64_t>((point[axis] - low_[axis]) / top_size_[axis]), 0,
                                          upper_.lattice.leaf_count[axis] - 1);
  return cell;
}

/// Makes the lattices of the upper cells, and the lists of their leaf cells.
void TwoLevelGrid::divide(const PlainMesh& mesh) {
  const Index3& count = upper_.lattice.leaf_count;
  std::vector<std::uint32_t> owned(static_cast<std::size_t>(volume(count)), 0);
  for (std::uint32_t cell = 0; cell < mesh.cell_count(); ++cell)
    ++owned[place_in(count, top_cell_of(mesh.center(cell)))];
  std::uint32_t leaf_count = 0;
  for (const std::uint32_t own : owned) {
    const Index3 parts = division(top_size_, std::max(1.0, static_cast<double>(own)));
    top_cells_.push_back({leaf_count,
                          {static_cast<std::uint16_t>(parts.x), static_cast<std::uint16_t>(parts.y),
                           static_cast<std::uint16_t>(parts.z)}});
    leaf_count += static_cast<std::uint32_t>(volume(parts));
  }

  std::vector<std::pair<std::uint32_t, std::uint32_t>> leaf_and_cell;
  starts_.assign(leaf_count + 1, 0);
  for (std::uint32_t cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellSides sides(mesh.points_at(mesh.sorted_vertices(cell)));
    const Box3 box = mesh.box(cell);
    for_each_touched(sides, box, low_, top_size_, count, [&](const Index3& top) {
      const TopCell& divided = top_cells_[place_in(count, top)];
      const Index3 parts{divided.count[0], divided.count[1], divided.count[2]};
      for_each_touched(sides, box, low_ + top_size_ * Vec3(top), top_size_ / Vec3(parts), parts,
                       [&](const Index3& part) {
                         const auto leaf = static_cast<std::uint32_t>(divided.first_leaf + place_in(parts, part));
                         leaf_and_cell.emplace_back(leaf, cell);
                         ++starts_[leaf + 1];
                       });
    });
  }
  for (std::size_t leaf = 0; leaf < leaf_count; ++leaf) starts_[leaf + 1] += starts_[leaf];
  items_.resize(leaf_and_cell.size());
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (const auto& [leaf, cell] : leaf_and_cell) items_[next[leaf]++] = cell;
}

void TwoLevelGrid::collect_ranges(const PlainMesh& mesh) {
  leaf_ranges_.assign(starts_.size() - 1, no_value);
  for (std::size_t leaf = 0; leaf < leaf_ranges_.size(); ++leaf)
    for (std::uint32_t n = starts_[leaf]; n < starts_[leaf + 1]; ++n) extend(leaf_ranges_[leaf], mesh.range(items_[n]));
  upper_.levels.emplace_back(top_cells_.size(), no_value);
  for (std::size_t top = 0; top < top_cells_.size(); ++top) {
    const std::size_t end = top + 1 < top_cells_.size() ? top_cells_[top + 1].first_leaf : leaf_ranges_.size();
    for (std::size_t leaf = top_cells_[top].first_leaf; leaf < end; ++leaf)
      extend(upper_.levels[0][top], leaf_ranges_[leaf]);
  }
  // As many levels of macrocells as leaf lists have by default.
  for (int level = 1; level <= 3; ++level) {
    const Index3 below = render::whole_level(upper_.lattice, upper_.lattice.cell_edge(level - 1)).end;
    const Index3 count = render::whole_level(upper_.lattice, upper_.lattice.cell_edge(level)).end;
    upper_.levels.emplace_back(static_cast<std::size_t>(volume(count)), no_value);
    Index3 cell;
    for (cell.z = 0; cell.z < below.z; ++cell.z)
      for (cell.y = 0; cell.y < below.y; ++cell.y)
        for (cell.x = 0; cell.x < below.x; ++cell.x)
          extend(upper_.levels.back()[place_in(count, cell / upper_.lattice.factor)],
                 upper_.levels[static_cast<std::size_t>(level - 1)][place_in(below, cell)]);
  }
}

std::uint64_t TwoLevelGrid::bytes() const {
  return upper_.bytes() + top_cells_.size() * sizeof top_cells_[0] + leaf_ranges_.size() * sizeof leaf_ranges_[0] +
         starts_.size() * sizeof starts_[0] + items_.size() * sizeof items_[0];
}

}  // namespace rhoray::study

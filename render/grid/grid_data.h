#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <type_traits>

#include "formats/brick_grid.h"
#include "render/cell/trilinear.h"
#include "render/grid/stored_bricks.h"
#include "render/traverse/lattice_walk.h"

namespace rhoray::render {

/// The samples of a grid that stores all of them.
template <class T>
class DenseSamples {
 public:
  DenseSamples(const formats::BrickGrid& grid, std::size_t field)
      : tables_(&grid.tables()), samples_(grid.samples<T>(field)) {}

  RHORAY_INLINE TrilinearCell cell(const Index3& c) const {
    TrilinearCell out;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const std::int64_t i = c.x + static_cast<std::int64_t>(corner & 1),
                         j = c.y + static_cast<std::int64_t>(corner >> 1 & 1),
                         k = c.z + static_cast<std::int64_t>(corner >> 2);
      out.corner[corner] = static_cast<double>(samples_[tables_->address(i, j, k)]);
    }
    return out;
  }

  const formats::AxisTables& tables() const { return *tables_; }
  std::span<const T> samples() const { return samples_; }

 private:
  const formats::AxisTables* tables_;
  std::span<const T> samples_;
};

/// The samples of a grid that stores only some bricks; NaN in the others.
template <class T>
class SparseSamples {
 public:
  SparseSamples(const formats::BrickGrid& grid, std::size_t field)
      : address_(grid.description().layout, grid.tables(), grid.brick_slots()), samples_(grid.samples<T>(field)) {}

  /// The stored bricks of `grid`, which must be the grid of these samples.
  StoredBricks<T> bricks(const formats::BrickGrid& grid) const {
    static constexpr T no_data[] = {std::numeric_limits<T>::quiet_NaN()};
    const formats::BrickLayout& layout = grid.description().layout;
    const formats::AxisTables& tables = grid.tables();
    const auto size = static_cast<std::uint64_t>(layout.brick_edge * layout.brick_edge * layout.brick_edge);
    return {.address = {tables.x.data(), tables.y.data(), tables.z.data()},
            .slots = grid.brick_slots(),
            .shift = std::countr_zero(size),
            .samples = samples_.data(),
            .stride = size,
            .stored_count = static_cast<std::uint32_t>(layout.stored_brick_count),
            .values = no_data};
  }

  RHORAY_INLINE TrilinearCell cell(const Index3& c) const {
    TrilinearCell out;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const std::uint64_t at =
          address_(c.x + static_cast<std::int64_t>(corner & 1), c.y + static_cast<std::int64_t>(corner >> 1 & 1),
                   c.z + static_cast<std::int64_t>(corner >> 2));
      out.corner[corner] = at == formats::SparseAddress::no_sample ? std::numeric_limits<double>::quiet_NaN()
                                                                   : static_cast<double>(samples_[at]);
    }
    return out;
  }

 private:
  formats::SparseAddress address_;
  std::span<const T> samples_;
};

/// A grid whose sample (i, j, k) lies at position (i, j, k) of its frame.
class UniformGeometry {
 public:
  UniformGeometry() = default;
  explicit UniformGeometry(const formats::GridDescription&) {}

  RHORAY_INLINE WholePlanes planes() const { return {}; }

  /// A position on one axis in the cell's own coordinate, 0 to 1 inside.
  RHORAY_INLINE double in_cell(int, double position, std::int64_t cell) const {
    return position - static_cast<double>(cell);
  }

  /// A direction's component in a cell's own coordinates.
  RHORAY_INLINE double direction_in_cell(int, double component, std::int64_t) const { return component; }

  /// Transforms a gradient from a cell's own coordinates to the frame.
  RHORAY_INLINE Vec3 gradient(const Vec3& in_cell, const Index3&) const { return in_cell; }
};

/// A grid whose samples lie at positions given by tables: cells are boxes of different sizes.
class RectilinearGeometry {
 public:
  explicit RectilinearGeometry(const formats::GridDescription& grid);

  RHORAY_INLINE TablePlanes planes() const { return TablePlanes(*tables_); }

  RHORAY_INLINE double in_cell(int axis, double position, std::int64_t cell) const {
    return (position - low(axis, cell)) / width(axis, cell);
  }
  RHORAY_INLINE double direction_in_cell(int axis, double component, std::int64_t cell) const {
    return component / width(axis, cell);
  }

  RHORAY_INLINE Vec3 gradient(const Vec3& in_cell, const Index3& cell) const {
    return {in_cell.x / width(0, cell.x), in_cell.y / width(1, cell.y), in_cell.z / width(2, cell.z)};
  }

 private:
  RHORAY_INLINE double low(int axis, std::int64_t cell) const {
    return (*tables_)[static_cast<std::size_t>(axis)][static_cast<std::size_t>(cell)];
  }
  RHORAY_INLINE double width(int axis, std::int64_t cell) const { return low(axis, cell + 1) - low(axis, cell); }

  std::shared_ptr<const std::array<std::vector<double>, 3>> tables_;  ///< one table per axis
};

/// One field of a packed grid as the kernels read it, in the grid's frame. `Samples` determines
/// where samples are stored in the file, `Geometry` where they lie in space. A dense, uniform grid
/// has no overhead from either.
template <class T, class Samples = DenseSamples<T>, class Geometry = UniformGeometry>
class GridData {
 public:
  using Sample = T;

  GridData(const formats::BrickGrid& grid, std::size_t field)
      : grid_(grid), samples_(grid_, field), geometry_(grid.description()), levels_(grid.macro_levels<T>(field)) {}

  WalkLattice lattice() const { return {levels_.shape.leaf_count, levels_.shape.factor}; }
  int level_count() const { return levels_.shape.level_count; }
  const formats::GridDescription& description() const { return grid_.description(); }
  const formats::BrickGrid& grid() const { return grid_; }
  RHORAY_INLINE const Geometry& geometry() const { return geometry_; }

  // The stored data, for kernels that read it directly. The first two only for a dense grid.
  const formats::AxisTables& tables() const { return samples_.tables(); }
  std::span<const T> samples() const { return samples_.samples(); }
  const formats::MacroLevelsView<T>& levels() const { return levels_; }
  /// Only for a sparse grid.
  StoredBricks<T> bricks() const { return samples_.bricks(grid_); }

  /// The t at which a ray passes the planes between cells.
  RHORAY_INLINE auto plane_times(const Ray& ray) const {
    return PlaneTimesOf<decltype(geometry_.planes())>(ray, geometry_.planes());
  }

  /// The range of values that can occur in a macrocell; level must be at least 1.
  RHORAY_INLINE Interval<double> range(int level, const Index3& cell) const {
    const Interval<T> stored = levels_.range(level, cell.x, cell.y, cell.z);
    if (stored.is_empty()) return {};
    return {static_cast<double>(stored.lo), static_cast<double>(stored.hi)};
  }

  RHORAY_INLINE TrilinearCell cell(const Index3& c) const { return samples_.cell(c); }

  /// False for a cell with a corner that is NaN or infinite; integers always have data.
  RHORAY_INLINE static bool has_data(const TrilinearCell& cell) {
    if constexpr (std::is_floating_point_v<T>)
      return cell.has_data();
    else
      return true;
  }

  RHORAY_INLINE std::uint64_t cell_id(const Index3& c) const {
    const Index3& count = levels_.shape.leaf_count;
    return static_cast<std::uint64_t>((c.z * count.y + c.y) * count.x + c.x);
  }

 private:
  formats::BrickGrid grid_;
  Samples samples_;
  [[no_unique_address]] Geometry geometry_;
  formats::MacroLevelsView<T> levels_;
};

template <class T>
using RectilinearGridData = GridData<T, DenseSamples<T>, RectilinearGeometry>;
template <class T>
using SparseGridData = GridData<T, SparseSamples<T>, UniformGeometry>;
template <class T>
using SparseRectilinearGridData = GridData<T, SparseSamples<T>, RectilinearGeometry>;

}  // namespace rhoray::render

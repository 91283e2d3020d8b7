#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "formats/brick_grid.h"
#include "formats/macro_ranges.h"
#include "render/cell/trilinear.h"
#include "render/grid/sample_source.h"
#include "render/traverse/lattice_walk.h"

namespace rhoray::render {

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

/// One field of a grid as the kernels read it. Where its samples are stored, and in which type, is
/// not seen here: values are handed over as doubles, which hold all of them exactly.
class GridData {
 public:
  /// Reads the values at the corners of a cell.
  using FetchCell = TrilinearCell (*)(const GridData& grid, const Index3& cell);

  /// The parts of a grid, whatever its file format.
  struct Parts {
    formats::MacroRanges ranges;
    FetchCell fetch_cell;
    std::optional<SampleSource> source;        ///< nothing where samples cannot be addressed directly
    Interval<double> values;                   ///< of all samples that have data
    bool has_gaps;                             ///< some samples have no data
    std::shared_ptr<const void> memory;        ///< that the others point to
    std::optional<formats::BrickGrid> packed;  ///< the file; nothing for a NanoVDB grid
  };

  explicit GridData(Parts parts)
      : parts_(std::move(parts)),
        may_have_gaps_(parts_.ranges.type() == formats::ElementType::F32 ||
                       parts_.ranges.type() == formats::ElementType::F64) {}
  /// Refuses (ErrorCode::invalid) a field whose type cannot be rendered.
  GridData(const formats::BrickGrid& grid, std::size_t field);

  WalkLattice lattice() const { return {parts_.ranges.shape().leaf_count, parts_.ranges.shape().factor}; }
  int level_count() const { return parts_.ranges.shape().level_count; }
  const formats::MacroRanges& ranges() const { return parts_.ranges; }
  const std::optional<SampleSource>& source() const { return parts_.source; }
  const std::optional<formats::BrickGrid>& packed() const { return parts_.packed; }
  const Interval<double>& values() const { return parts_.values; }
  bool has_gaps() const { return parts_.has_gaps; }
  const void* memory() const { return parts_.memory.get(); }

  /// The range of values that can occur in a macrocell; level must be at least 1.
  Interval<double> range(int level, const Index3& cell) const { return parts_.ranges.range(level, cell); }

  RHORAY_INLINE TrilinearCell cell(const Index3& c) const { return parts_.fetch_cell(*this, c); }

  /// False for a cell with a corner that is NaN or infinite.
  RHORAY_INLINE bool has_data(const TrilinearCell& cell) const { return !may_have_gaps_ || cell.has_data(); }

  RHORAY_INLINE std::uint64_t cell_id(const Index3& c) const {
    const Index3& count = parts_.ranges.shape().leaf_count;
    return static_cast<std::uint64_t>((c.z * count.y + c.y) * count.x + c.x);
  }

 private:
  Parts parts_;
  bool may_have_gaps_;  ///< false for integers
};

/// A grid whose samples lie where `Geometry` says, in its own frame. A uniform grid has no overhead
/// from it.
template <class Geometry>
class PlacedGrid : public GridData {
 public:
  explicit PlacedGrid(Parts parts) : GridData(std::move(parts)) {}
  PlacedGrid(const formats::BrickGrid& grid, std::size_t field)
      : GridData(grid, field), geometry_(grid.description()) {}

  RHORAY_INLINE const Geometry& geometry() const { return geometry_; }

  /// The t at which a ray passes the planes between cells.
  RHORAY_INLINE auto plane_times(const Ray& ray) const {
    return PlaneTimesOf<decltype(geometry_.planes())>(ray, geometry_.planes());
  }

 private:
  [[no_unique_address]] Geometry geometry_;
};

using UniformGrid = PlacedGrid<UniformGeometry>;
using RectilinearGrid = PlacedGrid<RectilinearGeometry>;

}  // namespace rhoray::render

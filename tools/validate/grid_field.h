#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "formats/brick_grid.h"

namespace rhoray::tools::validate {

/// A packed grid with one of its fields in doubles, trilinear between its samples. There are two
/// frames. In the grid's own frame, samples are at the positions of its axes. In the frame "index",
/// they are at whole numbers and cells are unit cubes.
class GridField {
 public:
  /// @param field  name; empty: the first. An unknown name is refused (ErrorCode::usage).
  GridField(formats::BrickGrid grid, const std::string& field);

  const Index3& sample_count() const { return grid_.description().layout.sample_count; }
  Box3 box_frame() const;

  /// NaN where the grid stores nothing.
  double sample(std::int64_t i, std::int64_t j, std::int64_t k) const { return sample_(i, j, k); }
  double position(int axis, std::int64_t i) const { return grid_.description().position(axis, i); }

  Vec3 frame_from_index(const Vec3& p_index) const;
  Vec3 index_from_frame(const Vec3& p_frame) const;

  struct Cell {
    Index3 at;
    std::array<double, 8> corner;  ///< (i, j, k) at index i + 2 j + 4 k

    bool has_data() const;
    double range() const;  ///< largest minus smallest corner
    double value(const Vec3& local) const;
    Vec3 gradient(const Vec3& local) const;  ///< with respect to the local coordinates, 0 to 1
  };
  Cell cell(const Index3& at) const;
  /// The cell that contains a point, the lower one at a face; nothing outside the grid.
  std::optional<Index3> cell_at(const Vec3& p_index) const;
  /// The cell that a hit reports (render/framebuffer.h), or nothing if there is no such id.
  std::optional<Index3> cell_of_id(std::uint64_t id) const;
  Vec3 widths(const Index3& cell) const;  ///< in the grid's frame
  /// Length in cells of a vector in the grid's frame, at a point or at the nearest point of the
  /// grid.
  double in_cells(const Vec3& v_frame, const Vec3& p_frame) const;

  /// Nothing outside the grid, and nothing where a corner of the cell has no data.
  std::optional<double> value(const Vec3& p_index) const;

 private:
  formats::BrickGrid grid_;
  std::function<double(std::int64_t, std::int64_t, std::int64_t)> sample_;
};

}  // namespace rhoray::tools::validate

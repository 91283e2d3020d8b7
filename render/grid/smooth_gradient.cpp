#include "render/grid/smooth_gradient.h"

#include <limits>

#include "formats/macro_ranges.h"

namespace rhoray::render {

namespace {

/// Stores samples as rows. A sample is given by its steps from the cell's lower corner.
class Rows {
 public:
  explicit Rows(CellSurroundings& out) : out_(out) {}

  void put_corner(const int (&at)[3], double value) const {
    for (int axis = 0; axis < 3; ++axis) put(axis, at, value);
  }
  void put(int axis, const int (&at)[3], double value) const {
    out_.rows[axis][at[axis == 0 ? 1 : 0] + 2 * at[axis == 2 ? 1 : 2]][at[axis] + 1] = value;
  }

 private:
  CellSurroundings& out_;
};

/// Reads samples one by one. Every corner is read once.
/// @param read  (address)
template <class Read>
RHORAY_INLINE void read_samples(const SampleSource& source, const Index3& cell, CellSurroundings& out,
                                const Read& read) {
  const Rows rows(out);
  const auto address = [&](int axis, int step) { return source.address[axis][cell[axis] + step]; };
  std::uint64_t of[3][2];
  for (int axis = 0; axis < 3; ++axis)
    for (int step = 0; step < 2; ++step) of[axis][step] = address(axis, step);
  for (int corner = 0; corner < 8; ++corner) {
    const int at[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    rows.put_corner(at, static_cast<double>(read(of[0][at[0]] + of[1][at[1]] + of[2][at[2]])));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    for (const int step : {-1, 2}) {
      const std::int64_t sample = cell[axis] + step;
      const bool exists = sample >= 0 && sample < source.count[axis];
      const std::uint64_t beyond = exists ? address(axis, step) : 0;
      for (int row = 0; row < 4; ++row) {
        const int j = row & 1, k = row >> 1;
        out.rows[axis][row][step + 1] = exists ? static_cast<double>(read(beyond + of[first][j] + of[second][k]))
                                               : std::numeric_limits<double>::quiet_NaN();
      }
    }
  }
}

template <class T>
void read_dense(const GridData& grid, const Index3& cell, CellSurroundings& out) {
  const T* samples = static_cast<const T*>(grid.source()->samples);
  read_samples(*grid.source(), cell, out, [&](std::uint64_t address) { return samples[address]; });
}

template <class T>
void read_in_bricks(const GridData& grid, const Index3& cell, CellSurroundings& out) {
  const SampleSource& source = *grid.source();
  read_samples(source, cell, out, [&](std::uint64_t address) { return sample_in_brick<T>(source, address); });
}

/// Reads cells: the cell's own and the six beside it.
void read_cells(const GridData& grid, const Index3& cell, CellSurroundings& out) {
  const Rows rows(out);
  const Index3 count = grid.lattice().leaf_count;
  const TrilinearCell own = grid.cell(cell);
  for (int corner = 0; corner < 8; ++corner)
    rows.put_corner({corner & 1, corner >> 1 & 1, corner >> 2}, own.corner[static_cast<std::size_t>(corner)]);
  for (int axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 2}) {
      Index3 beside = cell;
      beside[axis] += step == 2 ? 1 : -1;
      const bool exists = beside[axis] >= 0 && beside[axis] < count[axis];
      const TrilinearCell samples = exists ? grid.cell(beside) : own;
      for (int corner = 0; corner < 8; ++corner) {
        int at[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
        if (at[axis] != (step == 2 ? 1 : 0)) continue;
        at[axis] = step;
        rows.put(axis, at,
                 exists ? samples.corner[static_cast<std::size_t>(corner)] : std::numeric_limits<double>::quiet_NaN());
      }
    }
}

}  // namespace

ReadSurroundings surroundings_reader(const GridData& grid) {
  if (!grid.source()) return read_cells;
  const bool is_dense = grid.source()->bricks.slots == nullptr;
  return formats::with_exact_type(grid.source()->type, [&]<class T>(T) -> ReadSurroundings {
    return is_dense ? read_dense<T> : read_in_bricks<T>;
  });
}

}  // namespace rhoray::render

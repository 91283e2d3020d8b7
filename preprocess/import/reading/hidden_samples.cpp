#include "preprocess/import/reading/hidden_samples.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>

#include "formats/base/text.h"
#include "preprocess/import/reading/ghost_values.h"
#include "preprocess/import/reading/samples.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

using Marks = Array<std::uint8_t>;  ///< 1 for each point or cell that is hidden

std::size_t count_of(const Index3& size) {
  return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}

/// The marks of a vtkGhostType array; empty if there is none of bytes, as VTK has them.
Marks marks_in(const std::vector<GridArray>& ghosts, bool in_cells, std::uint8_t mask, const Index3& size,
               const std::filesystem::path& path) {
  for (const GridArray& array : ghosts) {
    if (array.in_cells != in_cells || array.type != ElementType::U8 || array.component_count != 1) continue;
    const Array<std::byte> values = array.load ? array.load() : array.values;
    if (values.size() != count_of(size))
      refuse_input(path, concat("array '", array.name, "'"), concat(values.size(), " bytes"), concat(count_of(size)));
    Marks marks(values.size());
    std::transform(values.begin(), values.end(), marks.begin(), [&](std::byte value) {
      return static_cast<std::uint8_t>((std::to_integer<std::uint8_t>(value) & mask) != 0);
    });
    return marks;
  }
  return {};
}

/// Marks the cells with a hidden point.
void add_cells_of_points(Marks& cells, const Index3& cell_count, const Marks& points, const Index3& point_count) {
  if (points.empty()) return;
  cells.resize(count_of(cell_count), 0);
  std::size_t cell = 0;
  for (std::int64_t z = 0; z < cell_count.z; ++z)
    for (std::int64_t y = 0; y < cell_count.y; ++y)
      for (std::int64_t x = 0; x < cell_count.x; ++x, ++cell)
        for (std::int64_t k = z; k < std::min(z + 2, point_count.z); ++k)
          for (std::int64_t j = y; j < std::min(y + 2, point_count.y); ++j)
            for (std::int64_t i = x; i < std::min(x + 2, point_count.x); ++i)
              cells[cell] |= points[static_cast<std::size_t>((k * point_count.y + j) * point_count.x + i)];
}

/// Samples of type T where NaN stands for the marked ones.
template <class T>
Array<std::byte> with_holes(const NeutralVolume& volume, const Marks& marks) {
  Array<double> numbers(marks.size());
  copy_as_doubles(volume.type, volume.samples, numbers.data());
  Array<std::byte> bytes(marks.size() * sizeof(T));
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const T value = marks[i] != 0 ? std::numeric_limits<T>::quiet_NaN() : static_cast<T>(numbers[i]);
    std::memcpy(bytes.data() + i * sizeof(T), &value, sizeof value);
  }
  return bytes;
}

}  // namespace

std::vector<GridArray> take_ghosts(std::vector<GridArray>& arrays) {
  const auto first = std::stable_partition(arrays.begin(), arrays.end(),
                                           [](const GridArray& array) { return array.name != "vtkGhostType"; });
  std::vector<GridArray> ghosts(std::make_move_iterator(first), std::make_move_iterator(arrays.end()));
  arrays.erase(first, arrays.end());
  return ghosts;
}

void hide_samples(NeutralVolume& volume, const std::vector<GridArray>& ghosts, const PointGrid& points, bool in_cells,
                  const std::filesystem::path& path) {
  Index3 cell_count = points.point_count;
  for (int axis = 0; axis < 3; ++axis) cell_count[axis] = std::max<std::int64_t>(1, cell_count[axis] - 1);
  Marks marks = marks_in(ghosts, false, ghost_hidden_point, points.point_count, path);
  if (in_cells) {
    const Marks hidden_points = std::move(marks);
    marks = marks_in(ghosts, true, ghost_hidden_cell | ghost_refined, cell_count, path);
    add_cells_of_points(marks, cell_count, hidden_points, points.point_count);
  }
  const auto count = std::count(marks.begin(), marks.end(), 1);
  if (count == 0) return;
  const bool is_wide = volume.type == ElementType::F64 || volume.type == ElementType::I32 ||
                       volume.type == ElementType::U32 || formats::element_bytes(volume.type) == 8;
  Array<std::byte> samples = is_wide ? with_holes<double>(volume, marks) : with_holes<float>(volume, marks);
  volume.type = is_wide ? ElementType::F64 : ElementType::F32;
  set_samples(volume, std::move(samples));
  volume.notes.push_back(in_cells ? count_text(count, "hidden cell, or cell with a hidden point, has no data",
                                               "hidden cells, or cells with a hidden point, have no data")
                                  : count_text(count, "hidden point has no data", "hidden points have no data"));
}

}  // namespace rhoray::preprocess

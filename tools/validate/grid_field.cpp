#include "tools/validate/grid_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "formats/base/error.h"
#include "tools/validate/geometry.h"

namespace rhoray::tools::validate {

namespace {

std::function<double(std::int64_t, std::int64_t, std::int64_t)> reader(const formats::BrickGrid& grid,
                                                                       std::size_t field) {
  using formats::SparseAddress;
  return formats::with_element_type(
      grid.description().fields[field].type,
      [&]<class T>(T) -> std::function<double(std::int64_t, std::int64_t, std::int64_t)> {
        const std::span<const T> samples = grid.samples<T>(field);
        if (!grid.description().layout.is_sparse)
          return [samples, &tables = grid.tables()](std::int64_t i, std::int64_t j, std::int64_t k) {
            return static_cast<double>(samples[tables.address(i, j, k)]);
          };
        const SparseAddress address(grid.description().layout, grid.tables(), grid.brick_slots());
        return [samples, address](std::int64_t i, std::int64_t j, std::int64_t k) {
          const std::uint64_t at = address(i, j, k);
          return at == SparseAddress::no_sample ? std::numeric_limits<double>::quiet_NaN()
                                                : static_cast<double>(samples[at]);
        };
      });
}

double between(double a, double b, double w) {
  return (1 - w) * a + w * b;
}

}  // namespace

GridField::GridField(formats::BrickGrid grid, const std::string& field) : grid_(std::move(grid)) {
  const auto found = field.empty() ? std::optional<std::size_t>(0) : grid_.find_field(field);
  if (!found) throw Error(ErrorCode::usage, concat(grid_.file().name(), ": no field '", field, "'"));
  sample_ = reader(grid_, *found);
}

Box3 GridField::box_frame() const {
  Box3 box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = position(axis, 0);
    box.max[axis] = position(axis, sample_count()[axis] - 1);
  }
  return box;
}

Vec3 GridField::frame_from_index(const Vec3& p_index) const {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) {
    const auto last = static_cast<double>(sample_count()[axis] - 2);
    const double low = std::clamp(std::floor(p_index[axis]), 0.0, last);
    const auto i = static_cast<std::int64_t>(low);
    p[axis] = position(axis, i) + (p_index[axis] - low) * (position(axis, i + 1) - position(axis, i));
  }
  return p;
}

Vec3 GridField::index_from_frame(const Vec3& p_frame) const {
  Vec3 p = p_frame;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& table = grid_.description().axes[static_cast<std::size_t>(axis)];
    if (table.empty()) continue;
    const auto beyond = std::upper_bound(table.begin() + 1, table.end() - 1, p_frame[axis]);
    const double low = *(beyond - 1);
    p[axis] = static_cast<double>(beyond - 1 - table.begin()) + (p_frame[axis] - low) / (*beyond - low);
  }
  return p;
}

GridField::Cell GridField::cell(const Index3& at) const {
  Cell cell{at, {}};
  for (std::size_t corner = 0; corner < 8; ++corner)
    cell.corner[corner] =
        sample_(at.x + static_cast<std::int64_t>(corner & 1), at.y + static_cast<std::int64_t>(corner >> 1 & 1),
                at.z + static_cast<std::int64_t>(corner >> 2));
  return cell;
}

std::optional<Index3> GridField::cell_at(const Vec3& p_index) const {
  Index3 at;
  for (int axis = 0; axis < 3; ++axis) {
    const auto last = static_cast<double>(sample_count()[axis] - 1);
    if (!(p_index[axis] >= 0 && p_index[axis] <= last)) return std::nullopt;
    at[axis] = static_cast<std::int64_t>(std::min(std::floor(p_index[axis]), last - 1));
  }
  return at;
}

std::optional<Index3> GridField::cell_of_id(std::uint64_t id) const {
  const Index3 cells = sample_count() - Index3(1);
  if (id >= static_cast<std::uint64_t>(volume(cells))) return std::nullopt;
  const auto number = static_cast<std::int64_t>(id);
  return Index3(number % cells.x, number / cells.x % cells.y, number / cells.x / cells.y);
}

Vec3 GridField::widths(const Index3& cell) const {
  Vec3 widths;
  for (int axis = 0; axis < 3; ++axis) widths[axis] = position(axis, cell[axis] + 1) - position(axis, cell[axis]);
  return widths;
}

double GridField::in_cells(const Vec3& v_frame, const Vec3& p_frame) const {
  const Vec3 p_index = index_from_frame(p_frame);
  Index3 at;
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = static_cast<std::int64_t>(
        std::clamp(std::floor(p_index[axis]), 0.0, static_cast<double>(sample_count()[axis] - 2)));
  return (v_frame / widths(at)).length();
}

std::optional<double> GridField::value(const Vec3& p_index) const {
  const std::optional<Index3> at = cell_at(p_index);
  if (!at) return std::nullopt;
  const Cell found = cell(*at);
  if (!found.has_data()) return std::nullopt;
  return found.value(p_index - to_vec3(*at));
}

bool GridField::Cell::has_data() const {
  return std::all_of(corner.begin(), corner.end(), [](double v) { return std::isfinite(v); });
}

double GridField::Cell::range() const {
  const auto [lo, hi] = std::minmax_element(corner.begin(), corner.end());
  return *hi - *lo;
}

double GridField::Cell::value(const Vec3& local) const {
  const double low = between(between(corner[0], corner[1], local.x), between(corner[2], corner[3], local.x), local.y);
  const double high = between(between(corner[4], corner[5], local.x), between(corner[6], corner[7], local.x), local.y);
  return between(low, high, local.z);
}

Vec3 GridField::Cell::gradient(const Vec3& local) const {
  Vec3 gradient(0, 0, 0);
  for (std::size_t c = 0; c < 8; ++c) {
    const bool up[3] = {(c & 1) != 0, (c & 2) != 0, (c & 4) != 0};
    for (int axis = 0; axis < 3; ++axis) {
      double weight = up[axis] ? 1 : -1;
      for (int other = 0; other < 3; ++other)
        if (other != axis) weight *= up[other] ? local[other] : 1 - local[other];
      gradient[axis] += weight * corner[c];
    }
  }
  return gradient;
}

}  // namespace rhoray::tools::validate

#include "preprocess/workers/tetgen/sizes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/base/error.h"

namespace rhoray::preprocess {

namespace {

using Point = std::array<double, 3>;

/// Cell and fraction on one axis, or nothing outside.
struct Place {
  std::int64_t cell;
  double fraction;
};
std::optional<Place> place_on(const std::vector<double>& positions, std::int64_t count, double x) {
  if (count < 2) return std::nullopt;
  if (positions.empty()) {
    if (!(x >= 0 && x <= static_cast<double>(count - 1))) return std::nullopt;
    const auto cell = std::min(static_cast<std::int64_t>(x), count - 2);
    return Place{cell, x - static_cast<double>(cell)};
  }
  if (!(x >= positions.front() && x <= positions.back())) return std::nullopt;
  const auto above = std::upper_bound(positions.begin() + 1, positions.end() - 1, x);
  return Place{above - positions.begin() - 1, (x - above[-1]) / (above[0] - above[-1])};
}

class VolumeSizes {
 public:
  explicit VolumeSizes(const NeutralVolume& volume)
      : volume_(volume), grid_from_world_(volume.world_from_grid.inverse()) {}

  std::optional<double> operator()(const Point& p) const {
    const Vec3 grid = grid_from_world_.point(Vec3(p[0], p[1], p[2]));
    std::array<Place, 3> places;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int a = static_cast<int>(axis);
      const auto place = place_on(volume_.axes[axis], volume_.sample_count[a], grid[a]);
      if (!place) return std::nullopt;
      places[axis] = *place;
    }
    double size = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<std::int64_t, 3> index;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool upper = (corner >> axis & 1U) != 0;
        index[axis] = places[axis].cell + upper;
        weight *= upper ? places[axis].fraction : 1 - places[axis].fraction;
      }
      if (weight > 0) size += weight * sample(index);
    }
    if (std::isnan(size)) return std::nullopt;
    return size;
  }

 private:
  double sample(const std::array<std::int64_t, 3>& i) const {
    const Index3& n = volume_.sample_count;
    const auto at = static_cast<std::size_t>((i[2] * n.y + i[1]) * n.x + i[0]);
    return formats::with_element_type(volume_.type, [&]<class T>(T value) {
      std::memcpy(&value, volume_.samples.data() + at * sizeof value, sizeof value);
      return static_cast<double>(value);
    });
  }

  const NeutralVolume& volume_;
  Affine grid_from_world_;
};

double determinant(const Point& p, const Point& a, const Point& b, const Point& c) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    sum += (a[i] - p[i]) * ((b[j] - p[j]) * (c[k] - p[k]) - (b[k] - p[k]) * (c[j] - p[j]));
  }
  return sum;
}

/// Tetrahedra sorted into the boxes of a lattice that their own boxes touch.
class MeshSizes {
 public:
  explicit MeshSizes(const NeutralMesh& mesh) : mesh_(mesh), values_(mesh.point_fields.at(0).values) {
    for (const auto& cell : mesh.cells)
      for (const std::uint64_t corner : cell)
        if (corner >= mesh.points.size() || corner >= values_.size())
          throw Error(ErrorCode::invalid, concat("size field: the mesh names point ", corner, "; it has ",
                                                 std::min(mesh.points.size(), values_.size())));
    set_lattice();
    lists_.resize(edge_ * edge_ * edge_);
    for (std::uint32_t cell = 0; cell < mesh.cells.size(); ++cell) {
      Point lo, hi;
      box_of(cell, lo, hi);
      const auto first = box_at(lo), last = box_at(hi);
      for (std::size_t z = first[2]; z <= last[2]; ++z)
        for (std::size_t y = first[1]; y <= last[1]; ++y)
          for (std::size_t x = first[0]; x <= last[0]; ++x) lists_[(z * edge_ + y) * edge_ + x].push_back(cell);
    }
  }

  std::optional<double> operator()(const Point& p) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!(p[axis] >= lo_[axis] && p[axis] <= hi_[axis])) return std::nullopt;
    const auto box = box_at(p);
    for (const std::uint32_t cell : lists_[(box[2] * edge_ + box[1]) * edge_ + box[0]])
      if (const auto size = in_cell(cell, p); size && !std::isnan(*size)) return size;
    return std::nullopt;
  }

 private:
  const Point& corner(std::uint32_t cell, std::size_t i) const { return mesh_.points[mesh_.cells[cell][i]]; }

  void box_of(std::uint32_t cell, Point& lo, Point& hi) const {
    lo = hi = corner(cell, 0);
    for (std::size_t i = 1; i < 4; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lo[axis] = std::min(lo[axis], corner(cell, i)[axis]);
        hi[axis] = std::max(hi[axis], corner(cell, i)[axis]);
      }
  }

  void set_lattice() {
    if (mesh_.cells.empty()) throw Error(ErrorCode::invalid, "size field: the mesh has no cells");
    box_of(0, lo_, hi_);
    for (std::uint32_t cell = 1; cell < mesh_.cells.size(); ++cell) {
      Point lo, hi;
      box_of(cell, lo, hi);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lo_[axis] = std::min(lo_[axis], lo[axis]);
        hi_[axis] = std::max(hi_[axis], hi[axis]);
      }
    }
    // About one tetrahedron for each box.
    edge_ =
        std::clamp<std::size_t>(static_cast<std::size_t>(std::cbrt(static_cast<double>(mesh_.cells.size()))), 1, 256);
  }

  std::array<std::size_t, 3> box_at(const Point& p) const {
    std::array<std::size_t, 3> box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double width = hi_[axis] - lo_[axis];
      if (width > 0)
        box[axis] =
            std::min(static_cast<std::size_t>((p[axis] - lo_[axis]) / width * static_cast<double>(edge_)), edge_ - 1);
    }
    return box;
  }

  std::optional<double> in_cell(std::uint32_t cell, const Point& p) const {
    const Point &a = corner(cell, 0), &b = corner(cell, 1), &c = corner(cell, 2), &d = corner(cell, 3);
    const double whole = determinant(a, b, c, d);
    const std::array<double, 4> share{determinant(p, b, c, d) / whole, -determinant(p, a, c, d) / whole,
                                      determinant(p, a, b, d) / whole, -determinant(p, a, b, c) / whole};
    double size = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!(share[i] >= -1e-9)) return std::nullopt;  // also leaves with the NaN of a flat cell
      size += share[i] * values_[mesh_.cells[cell][i]];
    }
    return size;
  }

  const NeutralMesh& mesh_;
  const Array<double>& values_;
  Point lo_{}, hi_{};
  std::size_t edge_ = 1;
  std::vector<std::vector<std::uint32_t>> lists_;
};

}  // namespace

SizeAt size_at(const SizeField& field) {
  if (const auto* volume = std::get_if<NeutralVolume>(&field)) return VolumeSizes(*volume);
  if (const auto* mesh = std::get_if<NeutralMesh>(&field)) return MeshSizes(*mesh);
  return size_by_distance(std::get<SizeByDistance>(field));
}

}  // namespace rhoray::preprocess

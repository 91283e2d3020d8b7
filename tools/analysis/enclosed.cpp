#include "tools/analysis/enclosed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "preprocess/unpack_mesh.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr int most_halvings = 6;

using Values4 = std::array<double, 4>;
using Values8 = std::array<double, 8>;  ///< (i, j, k) at index i + 2 j + 4 k

/// Scales the values of a cell and the isovalue by a power of two if sums of a few values would
/// overflow. Values below 2^-990 lose bits, far below the rounding of the largest value.
void keep_sums_finite(std::span<double> values, double& isovalue) {
  double largest = std::abs(isovalue);
  for (const double value : values) largest = std::max(largest, std::abs(value));
  if (largest < 0x1p1000) return;
  constexpr double scale = 0x1p-32;
  isovalue *= scale;
  for (double& value : values) value *= scale;
}

/// Share of a tetrahedron where a linear field with these values at its corners, ascending, is
/// below a number. Each case is a sum of products of shares, so that nothing cancels.
double share_below(const Values4& v, double t) {
  const auto share = [&](std::size_t a, std::size_t b) { return (t - v[a]) / (v[b] - v[a]); };
  if (t <= v[0]) return 0;
  if (t > v[3]) return 1;
  if (t <= v[1]) return share(0, 1) * share(0, 2) * share(0, 3);
  if (t > v[2]) return 1 - (1 - share(0, 3)) * (1 - share(1, 3)) * (1 - share(2, 3));
  // A wedge: the triangles at corners 0 and 1, as three tetrahedra.
  const double p = share(0, 2), q = share(0, 3), u = share(1, 2), w = share(1, 3);
  return p * q + u * w * (1 - q) + u * q * (1 - p);
}

/// Area of the plane in a tetrahedron where the linear field takes a value.
double area_at(const std::array<Vec3, 4>& points, const Values4& v, double t) {
  std::array<Vec3, 4> crossings;
  std::size_t count = 0;
  std::array<std::size_t, 4> below{}, above{};
  std::size_t below_count = 0, above_count = 0;
  for (std::size_t i = 0; i < 4; ++i) v[i] < t ? below[below_count++] = i : above[above_count++] = i;
  for (std::size_t b = 0; b < below_count; ++b)
    for (std::size_t a = 0; a < above_count; ++a) {
      const std::size_t from = below[b], to = above[b % 2 == 0 ? a : above_count - 1 - a];  // around a quadrangle
      crossings[count++] = points[from] + (t - v[from]) / (v[to] - v[from]) * (points[to] - points[from]);
    }
  double area = 0;
  for (std::size_t i = 2; i < count; ++i)
    area += (crossings[i - 1] - crossings[0]).cross(crossings[i] - crossings[0]).length() / 2;
  return area;
}

/// Sums of one thread. In long double, whose rounding does not show beside that of the terms.
struct Sums {
  long double inside = 0, undecided = 0, area = 0, whole = 0, rounding = 0;
  std::uint64_t crossed = 0, without_data = 0, cells = 0;

  Sums& operator+=(const Sums& other) {
    inside += other.inside, undecided += other.undecided, area += other.area, whole += other.whole;
    rounding += other.rounding;
    crossed += other.crossed, without_data += other.without_data, cells += other.cells;
    return *this;
  }
};

/// The six tetrahedra around the diagonal from corner 0 to corner 7 of a cell.
constexpr std::array<std::array<std::size_t, 4>, 6> tetrahedra_of_cell{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

/// A cell of a grid, or a part of one after halving.
struct Part {
  Values8 corner;
  std::array<Vec3, 8> points;  ///< world
  double volume;               ///< world
};

class CellMeasure {
 public:
  /// @param rounding  of a cell's volume, relative to it
  CellMeasure(double isovalue, double undecided_share, double rounding, Sums& sums)
      : field_isovalue_(isovalue), undecided_share_(undecided_share), rounding_(rounding), sums_(sums) {}

  void add(Part part) {
    sums_.whole += part.volume;
    sums_.rounding += rounding_ * part.volume;
    const auto [lo, hi] = std::minmax_element(part.corner.begin(), part.corner.end());
    if (*lo >= field_isovalue_) {  // also where all are the isovalue, as in masks
      sums_.inside += part.volume;
      return;
    }
    if (*hi < field_isovalue_) return;
    ++sums_.crossed;
    isovalue_ = field_isovalue_;
    keep_sums_finite(part.corner, isovalue_);
    visit(part, 0);
  }

 private:
  void visit(const Part& part, int halvings) {
    const Values8& c = part.corner;
    double lo = c[0], hi = c[0], largest = 0;
    for (const double value : c)
      lo = std::min(lo, value), hi = std::max(hi, value), largest = std::max(largest, std::abs(value));
    // of the halvings before, and of the sums below
    const double rounding = 16 * (halvings + 1) * epsilon * largest;
    if (lo - rounding >= isovalue_) {
      sums_.inside += part.volume;
      return;
    }
    if (hi + rounding < isovalue_) return;
    const double xy = c[0] - c[1] - c[2] + c[3], xz = c[0] - c[1] - c[4] + c[5], yz = c[0] - c[2] - c[4] + c[6];
    const double xyz = -c[0] + c[1] + c[2] - c[3] + c[4] - c[5] - c[6] + c[7];
    const double distance = (std::abs(xy) + std::abs(xz) + std::abs(yz)) / 4 + 0.385 * std::abs(xyz) + rounding;
    double surely = 0, perhaps = 0;
    for (const auto& corners : tetrahedra_of_cell) {
      Values4 v{c[corners[0]], c[corners[1]], c[corners[2]], c[corners[3]]};
      std::sort(v.begin(), v.end());
      surely += (1 - share_below(v, isovalue_ + distance)) / 6;
      perhaps += (1 - share_below(v, isovalue_ - distance)) / 6;
    }
    if (perhaps - surely <= undecided_share_ || halvings == most_halvings) {
      sums_.inside += surely * part.volume;
      sums_.undecided += std::max(0.0, perhaps - surely) * part.volume;
      add_area(part);
      return;
    }
    for (int octant = 0; octant < 8; ++octant) visit(octant_of(part, octant), halvings + 1);
  }

  void add_area(const Part& part) {
    for (const auto& corners : tetrahedra_of_cell) {
      std::array<Vec3, 4> points;
      Values4 values{};
      for (std::size_t i = 0; i < 4; ++i) points[i] = part.points[corners[i]], values[i] = part.corner[corners[i]];
      sums_.area += area_at(points, values, isovalue_);
    }
  }

  static Part octant_of(const Part& part, int octant) {
    Part half = part;
    half.volume = part.volume / 8;
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t bit = std::size_t{1} << axis;
      const bool upper = (octant >> axis & 1) != 0;
      for (std::size_t i = 0; i < 8; ++i) {
        if ((i & bit) != 0) continue;
        const double middle = half.corner[i] / 2 + half.corner[i | bit] / 2;
        const Vec3 between = (half.points[i] + half.points[i | bit]) / 2.0;
        half.corner[upper ? i : i | bit] = middle;
        half.points[upper ? i : i | bit] = between;
      }
    }
    return half;
  }

  double field_isovalue_, isovalue_ = 0;  ///< given, and in the unit of the cell's values
  double undecided_share_, rounding_;
  Sums& sums_;
};

/// The sum of the absolute products of a determinant. Its rounding is relative to this; the products
/// of sheared axes may cancel.
double absolute_products(const Affine& affine) {
  const auto absolute = [](const Vec3& v) { return Vec3(std::abs(v.x), std::abs(v.y), std::abs(v.z)); };
  const Vec3 x = absolute(affine.x_axis), y = absolute(affine.y_axis), z = absolute(affine.z_axis);
  return x.dot(Vec3(y.y * z.z + y.z * z.y, y.z * z.x + y.x * z.z, y.x * z.y + y.y * z.x));
}

Enclosed result_of(const Sums& sums) {
  // Terms are rounded a few times each; sums of n of them in long double by n half units.
  const long double summing = static_cast<long double>(sums.cells) * 8 * std::numeric_limits<long double>::epsilon();
  const long double error = sums.undecided / 2 + sums.rounding + summing * sums.whole;
  return {.volume = static_cast<double>(sums.inside + sums.undecided / 2),
          .volume_error = static_cast<double>(error * (1 + 4 * epsilon)),
          .area = static_cast<double>(sums.area),
          .whole_volume = static_cast<double>(sums.whole),
          .crossed_cells = sums.crossed,
          .cells_without_data = sums.without_data};
}

/// Adds what `measure(index, sums)` adds for all indices, in parallel.
template <class Measure>
Sums sum_over(std::uint64_t count, std::uint64_t least, const EnclosedOptions& options, const Measure& measure) {
  Sums all;
  std::mutex guard;
  ProgressMeter meter(options.progress, "measuring", count);
  for_each_range(count, least, options.threads, [&](std::uint64_t first, std::uint64_t last) {
    Sums part;
    for (std::uint64_t index = first; index < last; ++index) measure(index, part);
    const std::lock_guard lock(guard);
    all += part;
    meter.add(last - first);
  });
  return all;
}

Enclosed enclosed_in_grid(const formats::PackedFile& file, const EnclosedOptions& options) {
  const formats::BrickGrid grid(file);
  const validate::GridField field(grid, options.field);
  const Affine& world_from_grid = grid.description().world_from_grid;
  const double scale = std::abs(world_from_grid.determinant());
  const double rounding = 16 * epsilon * absolute_products(world_from_grid) / scale;
  const Index3 cells = field.sample_count() - Index3(1, 1, 1);
  const auto measure_row = [&](std::uint64_t row, Sums& sums) {
    Index3 at(0, static_cast<std::int64_t>(row) % cells.y, static_cast<std::int64_t>(row) / cells.y);
    CellMeasure measure(options.isovalue, options.undecided_share, rounding, sums);
    for (; at.x < cells.x; ++at.x) {
      const validate::GridField::Cell cell = field.cell(at);
      ++sums.cells;
      if (!cell.has_data()) {
        ++sums.without_data;
        continue;
      }
      const Vec3 widths = field.widths(at);
      Part part{.corner = cell.corner, .points = {}, .volume = scale * widths.x * widths.y * widths.z};
      for (std::size_t i = 0; i < 8; ++i)
        part.points[i] = world_from_grid.point({field.position(0, at.x + static_cast<std::int64_t>(i & 1)),
                                                field.position(1, at.y + static_cast<std::int64_t>(i >> 1 & 1)),
                                                field.position(2, at.z + static_cast<std::int64_t>(i >> 2))});
      measure.add(part);
    }
  };
  return result_of(sum_over(static_cast<std::uint64_t>(cells.y * cells.z), 16, options, measure_row));
}

const preprocess::NeutralField& field_named(const preprocess::NeutralMesh& mesh, const std::string& name,
                                            const std::string& file) {
  if (name.empty()) return mesh.point_fields.front();
  for (const preprocess::NeutralField& field : mesh.point_fields)
    if (field.name == name) return field;
  throw Error(ErrorCode::usage, concat(file, ": no field '", name, "'"));
}

Enclosed enclosed_in_mesh(const formats::PackedFile& file, const EnclosedOptions& options) {
  const preprocess::NeutralMesh mesh = preprocess::unpack_mesh(formats::TetMesh(file));
  const preprocess::NeutralField& field = field_named(mesh, options.field, file.name());
  const auto measure_cell = [&](std::uint64_t index, Sums& sums) {
    const auto& cell = mesh.cells[index];
    std::array<Vec3, 4> points;
    Values4 values{};
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& p = mesh.points[cell[i]];
      points[i] = Vec3(p[0], p[1], p[2]);
      values[i] = field.values[cell[i]];
    }
    ++sums.cells;
    if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); })) {
      ++sums.without_data;
      return;
    }
    const Vec3 a = points[1] - points[0], b = points[2] - points[0], c = points[3] - points[0];
    const double volume = std::abs(a.dot(b.cross(c))) / 6;
    sums.whole += volume;
    // of the differences, the products and the share; a sliver's volume may be rounding alone
    double reach = 0;
    for (const Vec3& p : points) reach = std::max(reach, p.length());
    sums.rounding += 16 * epsilon *
                     (a.length() * b.length() * c.length() +
                      reach * (a.length() * b.length() + b.length() * c.length() + c.length() * a.length()));
    double isovalue = options.isovalue;
    keep_sums_finite(values, isovalue);
    const Values4 unsorted = values;
    std::sort(values.begin(), values.end());
    const double inside = 1 - share_below(values, isovalue);
    sums.inside += inside * volume;
    if (inside <= 0 || inside >= 1) return;
    ++sums.crossed;
    sums.area += area_at(points, unsorted, isovalue);
  };
  return result_of(sum_over(mesh.cells.size(), 4096, options, measure_cell));
}

}  // namespace

Enclosed measure_enclosed(const formats::PackedFile& file, const EnclosedOptions& options) {
  const std::string& kind = file.description().kind;
  if (kind == "grid") return enclosed_in_grid(file, options);
  if (kind == "tets") return enclosed_in_mesh(file, options);
  throw Error(ErrorCode::unsupported, concat(file.name(), ": holds a ", kind, "; expected a grid or a mesh"));
}

}  // namespace rhoray::tools

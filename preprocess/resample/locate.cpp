#include "preprocess/resample/locate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "preprocess/inspect/orientation.h"
#include "preprocess/resample/points.h"

namespace rhoray::preprocess {
namespace {

constexpr auto edge = static_cast<std::int64_t>(PointRows::edge);

/// Weights of a point in a tetrahedron so flat that a double's rounding reaches them: in 113 bits.
std::array<double, 4> careful_weights(const std::array<Point, 4>& p, const Point& q) {
  __extension__ using Wide = __float128;
  using WidePoint = std::array<Wide, 3>;
  const auto wide_minus = [](const Point& a, const Point& b) {
    return WidePoint{Wide(a[0]) - Wide(b[0]), Wide(a[1]) - Wide(b[1]), Wide(a[2]) - Wide(b[2])};
  };
  const auto volume_with = [&](std::size_t vertex) {
    std::array<Point, 4> moved = p;
    moved[vertex] = q;
    const WidePoint a = wide_minus(moved[1], moved[0]), b = wide_minus(moved[2], moved[0]),
                    c = wide_minus(moved[3], moved[0]);
    return c[0] * (a[1] * b[2] - a[2] * b[1]) + c[1] * (a[2] * b[0] - a[0] * b[2]) + c[2] * (a[0] * b[1] - a[1] * b[0]);
  };
  std::array<Wide, 4> f;
  Wide sum = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    f[v] = std::max(Wide(0), volume_with(v));
    sum += f[v];
  }
  if (!(sum > 0)) return {0.25, 0.25, 0.25, 0.25};
  return {static_cast<double>(f[0] / sum), static_cast<double>(f[1] / sum), static_cast<double>(f[2] / sum),
          static_cast<double>(f[3] / sum)};
}

/// One tetrahedron, and the points of some rows in it.
class Scan {
 public:
  Scan(const SampleLattice& lattice, const PointRows& rows, const std::array<Point, 4>& points)
      : lattice_(lattice), rows_(rows), p_(points) {}

  /// Calls claim(point, weights, is_strict) for every point inside.
  template <class Claim>
  void run(Claim&& claim) {
    if (!place()) return;
    find_planes();
    const std::int64_t step = rows_.row_step;
    for (std::int64_t k = (low_[2] + step - 1) / step * step; k <= high_[2]; k += step)
      for (std::int64_t j = (low_[1] + step - 1) / step * step; j <= high_[1]; j += step) scan_row(k * edge + j, claim);
  }

 private:
  static constexpr double unbounded = std::numeric_limits<double>::infinity();
  using Two = double __attribute__((vector_size(16)));

  static Two larger(const Two& a, const Two& b) { return a > b ? a : b; }
  static Two smaller(const Two& a, const Two& b) { return a < b ? a : b; }

  static constexpr double index_slack = 1e-6;  ///< of a step; rounding reaches 1e-9 at 2^20 samples on an axis

  /// The points' range on each axis that the tetrahedron's box meets; false when there is none.
  bool place() {
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = static_cast<int>(a);
      const double lo = std::min(std::min(p_[0][a], p_[1][a]), std::min(p_[2][a], p_[3][a]));
      const double hi = std::max(std::max(p_[0][a], p_[1][a]), std::max(p_[2][a], p_[3][a]));
      const double inverse = rows_.inverse_spacing[axis], first = static_cast<double>(rows_.first[axis]);
      const double u_lo = (lo - lattice_.low[axis]) * inverse - first - index_slack - rows_.spread;
      const double u_hi = (hi - lattice_.low[axis]) * inverse - first + index_slack;
      const double last = static_cast<double>(rows_.size[axis] - 1);
      if (!(u_lo <= last && u_hi >= 0)) return false;
      low_[a] = u_lo <= 0 ? 0 : ceiling(u_lo);
      high_[a] = u_hi >= last ? rows_.size[axis] - 1 : static_cast<std::int64_t>(u_hi);
      if (low_[a] > high_[a]) return false;
      reach_[a] = hi - lo + (rows_.spread + 2 * index_slack) * lattice_.spacing[axis];
    }
    return true;
  }

  static std::int64_t ceiling(double x) {  // of a number that is not negative
    const auto below = static_cast<std::int64_t>(x);
    return below + (static_cast<double>(below) < x);
  }

  void find_planes() {
    const Point e1 = minus(p_[1], p_[0]), e2 = minus(p_[2], p_[0]), e3 = minus(p_[3], p_[0]);
    normal_ = {cross(minus(p_[3], p_[1]), minus(p_[2], p_[1])), cross(e2, e3), cross(e3, e1), cross(e1, e2)};
    volume_ = dot(normal_[3], e3);
    // Every product of three differences is at most this box; the bound of inspect/orientation.cpp, doubled, and what
    // an underflow may lose.
    error_ = 0x1p-49 * 6 * (reach_[0] * reach_[1] * reach_[2]) + 1e-290;
    for (std::size_t f = 0; f < 4; ++f) {
      const Point& on_face = f == 0 ? p_[1] : p_[0];
      const std::size_t v = f / 2, lane = f % 2;
      ny_[v][lane] = normal_[f][1];
      nz_[v][lane] = normal_[f][2];
      y_[v][lane] = on_face[1];
      z_[v][lane] = on_face[2];
      const bool sees_x = std::abs(normal_[f][0]) * reach_[0] > error_;
      const double inverse = sees_x ? rows_.inverse_spacing.x / normal_[f][0] : 0;
      const double unsure = error_ * std::abs(inverse) + index_slack;
      inverse_[v][lane] = inverse;
      u_[v][lane] = (on_face[0] - lattice_.low.x) * rows_.inverse_spacing.x - static_cast<double>(rows_.first.x);
      below_[v][lane] = inverse > 0 ? unsure : unbounded;
      above_[v][lane] = inverse < 0 ? unsure : unbounded;
      blind_[f] = !sees_x;
    }
  }

  template <class Claim>
  void scan_row(std::int64_t row, Claim&& claim) {
    const auto r = static_cast<std::size_t>(row);
    const double y = rows_.y[r], z = rows_.z[r], shift_steps = rows_.shift[r] * rows_.inverse_spacing.x;
    // Where the point may be inside, and where it surely is, in points of the row: two faces at once. A face that the
    // row meets on its way in bounds it from below, one on its way out from above.
    std::array<Two, 2> crossing;
    for (std::size_t v = 0; v < 2; ++v) {
      const Two rest = ny_[v] * (y - y_[v]) + nz_[v] * (z - z_[v]);
      rest_[2 * v] = rest[0];
      rest_[2 * v + 1] = rest[1];
      crossing[v] = (u_[v] - shift_steps) - rest * inverse_[v];
    }
    const Two from = larger(crossing[0] - below_[0], crossing[1] - below_[1]);
    const Two to = smaller(crossing[0] + above_[0], crossing[1] + above_[1]);
    const double outer_lo = std::max(static_cast<double>(low_[0]), std::max(from[0], from[1]));
    const double outer_hi = std::min(static_cast<double>(high_[0]), std::min(to[0], to[1]));
    if (!(outer_lo <= outer_hi)) return;
    double inner_lo = static_cast<double>(low_[0]), inner_hi = static_cast<double>(high_[0]);
    for (std::size_t f = 0; f < 4; ++f) {
      const double at = crossing[f / 2][f % 2], below = below_[f / 2][f % 2], above = above_[f / 2][f % 2];
      if (below < unbounded) inner_lo = std::max(inner_lo, at + below);
      if (above < unbounded) inner_hi = std::min(inner_hi, at - above);
      if (!blind_[f]) continue;
      if (rest_[f] < -2 * error_) return;
      if (rest_[f] <= 2 * error_) inner_hi = -1;
    }
    const std::int64_t first = ceiling(outer_lo), last = static_cast<std::int64_t>(outer_hi);
    for (std::int64_t i = first; i <= last; ++i) {
      const double at = static_cast<double>(i);
      const bool is_sure = at >= inner_lo && at <= inner_hi;
      const double x = rows_.x[static_cast<std::size_t>(i)] + rows_.shift[r];
      std::array<double, 4> f = heights(x);
      bool is_strict = true;
      if (!is_sure && !holds({x, y, z}, f, is_strict)) continue;
      claim(static_cast<std::uint32_t>(row * edge + i), weights(f, {x, y, z}), is_strict);
    }
  }

  std::array<double, 4> heights(double x) const {
    const double from_0 = x - p_[0][0];
    return {normal_[0][0] * (x - p_[1][0]) + rest_[0], normal_[1][0] * from_0 + rest_[1],
            normal_[2][0] * from_0 + rest_[2], normal_[3][0] * from_0 + rest_[3]};
  }

  /// The exact decision.
  bool holds(const Point& q, const std::array<double, 4>& f, bool& is_strict) const {
    for (std::size_t a = 0; a < 4; ++a)
      if (f[a] < -error_) return false;
    for (std::size_t a = 0; a < 4; ++a) {
      if (f[a] > error_) continue;
      std::array<Point, 4> moved = p_;
      moved[a] = q;
      const int side = orientation(moved[0], moved[1], moved[2], moved[3]);
      if (side < 0) return false;
      if (side == 0) is_strict = false;
    }
    return true;
  }

  std::array<double, 4> weights(std::array<double, 4> f, const Point& q) const {
    if (!(volume_ > 1e6 * error_)) return careful_weights(p_, q);
    for (double& height : f) height = std::max(height, 0.0);
    const double inverse = 1 / (f[0] + f[1] + f[2] + f[3]);
    return {f[0] * inverse, f[1] * inverse, f[2] * inverse, f[3] * inverse};
  }

  const SampleLattice& lattice_;
  const PointRows& rows_;
  const std::array<Point, 4>& p_;
  std::array<std::int64_t, 3> low_{}, high_{};
  Point reach_{};                  ///< no point looked at is farther from a vertex
  std::array<Point, 4> normal_{};  ///< of the face opposite a vertex, inward, twice its area long
  std::array<double, 4> rest_{};
  // Of faces 0 and 1, and of 2 and 3: a point on each, its normal, and how it bounds a row from below and from above.
  std::array<Two, 2> ny_{}, nz_{}, y_{}, z_{}, u_{}, inverse_{}, below_{}, above_{};
  std::array<bool, 4> blind_{};  ///< a face along the rows
  double volume_ = 0, error_ = 0;
};

}  // namespace

PointRows rows_of_samples(const SampleLattice& lattice, const Index3& brick) {
  PointRows rows;
  rows.first = brick * edge;
  for (int a = 0; a < 3; ++a) rows.inverse_spacing[a] = 1 / lattice.spacing[a];
  for (int a = 0; a < 3; ++a) rows.size[a] = std::min(edge, lattice.count[a] - rows.first[a]);
  const auto place = [&](std::size_t axis, std::int64_t i) {
    return lattice.places[axis][static_cast<std::size_t>(rows.first[static_cast<int>(axis)] + i)];
  };
  for (std::int64_t i = 0; i < rows.size.x; ++i) rows.x[static_cast<std::size_t>(i)] = place(0, i);
  for (std::int64_t k = 0; k < rows.size.z; ++k)
    for (std::int64_t j = 0; j < rows.size.y; ++j) {
      const auto row = static_cast<std::size_t>(k * edge + j);
      rows.shift[row] = 0;
      rows.y[row] = place(1, j);
      rows.z[row] = place(2, k);
    }
  return rows;
}

PointRows rows_of_probes(const SampleLattice& lattice, const Index3& brick, bool in_every_row) {
  PointRows rows = rows_of_samples(lattice, brick);
  rows.spread = 1;
  rows.row_step = in_every_row ? 1 : 2;
  for (int a = 0; a < 3; ++a) rows.size[a] = std::min(edge, lattice.count[a] - 1 - rows.first[a]);
  const std::int64_t rows_per_axis = edge / rows.row_step, row_count = rows_per_axis * rows_per_axis;
  const std::array<std::int64_t, 3> steps =
      in_every_row ? std::array<std::int64_t, 3>{1, 19, 41} : std::array<std::int64_t, 3>{1, 3, 7};
  for (std::int64_t k = 0; k < rows.size.z; k += rows.row_step)
    for (std::int64_t j = 0; j < rows.size.y; j += rows.row_step) {
      const std::int64_t number = k / rows.row_step * rows_per_axis + j / rows.row_step;
      const auto place = [&](std::size_t axis) {
        return (static_cast<double>(number * steps[axis] % row_count) + 0.5) / static_cast<double>(row_count);
      };
      const auto row = static_cast<std::size_t>(k * edge + j);
      rows.shift[row] = place(0) * lattice.spacing.x;
      rows.y[row] += place(1) * lattice.spacing.y;
      rows.z[row] += place(2) * lattice.spacing.z;
    }
  return rows;
}

void locate(std::span<const std::array<double, 3>> points, std::span<const std::array<std::uint32_t, 4>> cells,
            std::span<const std::uint32_t> touched, const SampleLattice& lattice, const PointRows& rows, Places& places,
            std::vector<SecondClaim>* second) {
  places.cell.fill(Places::outside);
  for (const std::uint32_t c : touched) {
    const auto& cell = cells[c];
    const std::array<Point, 4> corners{points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]};
    // What is flat is seen only where a claim comes up: few are, and the exact sign of all of them would cost more.
    int side = 2;
    Scan(lattice, rows, corners).run([&](std::uint32_t point, const std::array<double, 4>& weights, bool is_strict) {
      if (!is_strict && side == 2) side = orientation(corners[0], corners[1], corners[2], corners[3]);
      if (!is_strict && side == 0) return;
      if (places.cell[point] == Places::outside) {
        places.cell[point] = c;
        places.weights[point] = weights;
        places.is_strict[point] = is_strict;
      } else if (second != nullptr) {
        second->push_back({point, c, weights, is_strict || places.is_strict[point]});
      }
    });
  }
}

}  // namespace rhoray::preprocess

#include "preprocess/grid/resample/locate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "preprocess/grid/resample/points.h"
#include "preprocess/mesh/inspect/orientation.h"

namespace rhoray::preprocess {
namespace {

constexpr auto edge = static_cast<std::int64_t>(PointRows::edge);

/// Weights of a point in a tetrahedron so flat that rounding in double affects them: computed in
/// 113 bits.
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

using Two = double __attribute__((vector_size(16)));
using Four = float __attribute__((vector_size(16)));

Two magnitude(const Two& a) {
  return larger(a, -a);
}

/// A number for each face of a tetrahedron: 0 and 1, 2 and 3.
struct OfFaces {
  std::array<Two, 2> pair;

  double at(std::size_t f) const { return pair[f / 2][f % 2]; }
};

/// One tetrahedron, and the points of some rows in it.
class Scan {
 public:
  Scan(const SampleLattice& lattice, const PointRows& rows, const std::array<Point, 4>& points)
      : lattice_(lattice), rows_(rows), p_(points) {}

  /// Calls claim(point, weights, is_strict) for every point inside.
  template <class Claim>
  void run(Claim&& claim) {
    if (!place()) return;
    const auto step = static_cast<std::size_t>(rows_.row_step), rows_in_layer = edge_rows / step;
    const std::size_t first = (low_[1] + step - 1) / step, last = high_[1] / step;
    const std::size_t first_layer = (low_[2] + step - 1) / step, last_layer = high_[2] / step;
    if (first > last || first_layer > last_layer) return;
    find_planes();
    find_lines();
    for (std::size_t layer = first_layer; layer <= last_layer; ++layer)
      for (std::size_t j = first / 4 * 4; j <= last; j += 4) {
        unsigned near = rows_near(layer * rows_in_layer + j);
        if (j < first) near &= 15U << (first - j);
        if (j + 3 > last) near &= 15U >> (j + 3 - last);
        for (; near != 0; near &= near - 1)
          scan_row((layer * edge_rows + j + static_cast<std::size_t>(std::countr_zero(near))) * step, claim);
      }
  }

 private:
  static constexpr std::size_t edge_rows = PointRows::edge;
  static constexpr double unbounded = std::numeric_limits<double>::infinity();
  /// of a step; rounding reaches 1e-9 at 2^20 samples on an axis
  static constexpr double index_slack = 1e-6;

  /// Finds the points' range on each axis that the tetrahedron's box meets; returns false when
  /// there is none.
  bool place() {
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = static_cast<int>(a);
      const double lo = smaller(smaller(p_[0][a], p_[1][a]), smaller(p_[2][a], p_[3][a]));
      const double hi = larger(larger(p_[0][a], p_[1][a]), larger(p_[2][a], p_[3][a]));
      const double inverse = rows_.inverse_spacing[axis], first = static_cast<double>(rows_.first[axis]);
      const double u_lo = (lo - lattice_.low[axis]) * inverse - first - index_slack - rows_.spread;
      const double u_hi = (hi - lattice_.low[axis]) * inverse - first + index_slack;
      const double last = static_cast<double>(rows_.size[axis] - 1);
      if (!(u_lo <= last && u_hi >= 0 && last >= 0)) return false;
      low_[a] = ceiling(larger(u_lo, 0.0));
      high_[a] = static_cast<std::size_t>(static_cast<std::int64_t>(smaller(u_hi, last)));
      if (low_[a] > high_[a]) return false;
      reach_[a] = hi - lo + (rows_.spread + 2 * index_slack) * lattice_.spacing[axis];
    }
    return true;
  }

  static std::size_t ceiling(double x) {  // of a number that is not negative
    const auto below = static_cast<std::size_t>(static_cast<std::int64_t>(x));
    return below + (static_cast<double>(below) < x);
  }

  void find_planes() {
    std::array<OfFaces, 3> a, b;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double p = p_[0][axis], q = p_[1][axis], r = p_[2][axis], s = p_[3][axis];
      a[axis] = {Two{s - q, r - p}, Two{s - p, q - p}};
      b[axis] = {Two{r - q, s - p}, Two{q - p, r - p}};
      on_face_[axis] = {Two{q, p}, Two{p, p}};
    }
    // Every product of three differences is at most this box. The bound is twice that of
    // inspect/orientation.cpp, plus the largest loss by underflow.
    error_ = 0x1p-49 * 6 * (reach_[0] * reach_[1] * reach_[2]) + 1e-290;
    for (std::size_t v = 0; v < 2; ++v) {
      normal_[0].pair[v] = a[1].pair[v] * b[2].pair[v] - a[2].pair[v] * b[1].pair[v];
      normal_[1].pair[v] = a[2].pair[v] * b[0].pair[v] - a[0].pair[v] * b[2].pair[v];
      normal_[2].pair[v] = a[0].pair[v] * b[1].pair[v] - a[1].pair[v] * b[0].pair[v];
      const Two along_x = normal_[0].pair[v], none{};
      const auto sees_x = magnitude(along_x) * reach_[0] > error_;
      const Two inverse = sees_x ? rows_.inverse_spacing.x / along_x : none;
      const Two unsure = error_ * magnitude(inverse) + index_slack;
      inverse_.pair[v] = inverse;
      u_.pair[v] =
          (on_face_[0].pair[v] - lattice_.low.x) * rows_.inverse_spacing.x - static_cast<double>(rows_.first.x);
      below_.pair[v] = inverse > 0 ? unsure : none + unbounded;
      above_.pair[v] = inverse < 0 ? unsure : none + unbounded;
      sees_all_ = sees_all_ && sees_x[0] != 0 && sees_x[1] != 0;
    }
    volume_ = normal_[0].pair[1][1] * a[0].pair[1][0] + normal_[1].pair[1][1] * a[1].pair[1][0] +
              normal_[2].pair[1][1] * a[2].pair[1][0];
  }

  /// Finds where rows cross the faces' planes, in steps, for a first test in single precision:
  /// start + y * j + z * k. The bounds are widened by its rounding.
  void find_lines() {
    for (std::size_t v = 0; v < 2; ++v) {
      const Two y = -normal_[1].pair[v] * inverse_.pair[v] * lattice_.spacing.y,
                z = -normal_[2].pair[v] * inverse_.pair[v] * lattice_.spacing.z;
      const Two start =
          u_.pair[v] +
          y * (static_cast<double>(rows_.first.y) - (on_face_[1].pair[v] - lattice_.low.y) * rows_.inverse_spacing.y) +
          z * (static_cast<double>(rows_.first.z) - (on_face_[2].pair[v] - lattice_.low.z) * rows_.inverse_spacing.z);
      const Two rounding = 1e-6 * (magnitude(start) + 16 * (magnitude(y) + magnitude(z) + 1));
      const Two below = below_.pair[v] + rounding, above = above_.pair[v] + rounding;
      for (std::size_t lane = 0; lane < 2; ++lane)
        lines_[2 * v + lane] = {static_cast<float>(start[lane] - below[lane]),
                                static_cast<float>(start[lane] + above[lane]), static_cast<float>(y[lane]),
                                static_cast<float>(z[lane])};
    }
  }

  /// Returns as bits which of four rows may have points inside. A NaN counts as a row that may.
  /// @param n  the first row's index among those that have points
  unsigned rows_near(std::size_t n) const {
    using FourBits = std::int32_t __attribute__((vector_size(16)));
    Four y, z, shift;
    std::memcpy(&y, rows_.y_steps.data() + n, sizeof y);
    std::memcpy(&z, rows_.z_steps.data() + n, sizeof z);
    std::memcpy(&shift, rows_.shift_steps.data() + n, sizeof shift);
    Four from = shift + static_cast<float>(low_[0]), to = shift + static_cast<float>(high_[0]);
    for (const Line& line : lines_) {
      const Four rise = line.y * y + line.z * z;
      const Four lowest = line.low + rise, highest = line.high + rise;
      from = lowest > from ? lowest : from;
      to = highest < to ? highest : to;
    }
    const FourBits near = ~(from > to) & FourBits{1, 2, 4, 8};
    return static_cast<unsigned>(near[0] | near[1] | near[2] | near[3]);
  }

  template <class Claim>
  void scan_row(std::size_t r, Claim&& claim) {
    const double y = rows_.y[r], z = rows_.z[r], shift_steps = rows_.shift[r] * rows_.inverse_spacing.x;
    // Find where the point may be inside, and where it surely is, in points of the row: two faces
    // at once. A face through which the row enters bounds it from below, one through which it exits
    // from above.
    OfFaces crossing;
    for (std::size_t v = 0; v < 2; ++v) {
      rest_.pair[v] = normal_[1].pair[v] * (y - on_face_[1].pair[v]) + normal_[2].pair[v] * (z - on_face_[2].pair[v]);
      crossing.pair[v] = (u_.pair[v] - shift_steps) - rest_.pair[v] * inverse_.pair[v];
    }
    const Two from = larger(crossing.pair[0] - below_.pair[0], crossing.pair[1] - below_.pair[1]);
    const Two to = smaller(crossing.pair[0] + above_.pair[0], crossing.pair[1] + above_.pair[1]);
    const double outer_lo = larger(static_cast<double>(low_[0]), larger(from[0], from[1]));
    const double outer_hi = smaller(static_cast<double>(high_[0]), smaller(to[0], to[1]));
    if (!(outer_lo <= outer_hi)) return;
    double inner_lo = static_cast<double>(low_[0]), inner_hi = static_cast<double>(high_[0]);
    for (std::size_t f = 0; f < 4; ++f) {
      const double at = crossing.at(f), below = below_.at(f), above = above_.at(f);
      inner_lo = larger(inner_lo, below < unbounded ? at + below : inner_lo);
      inner_hi = smaller(inner_hi, above < unbounded ? at - above : inner_hi);
    }
    if (!sees_all_ && !holds_blind_faces(inner_hi)) return;
    const auto last = static_cast<std::size_t>(static_cast<std::int64_t>(outer_hi));
    for (std::size_t i = ceiling(outer_lo); i <= last; ++i) {
      const double at = static_cast<double>(i);
      const bool is_sure = at >= inner_lo && at <= inner_hi;
      const double x = rows_.x[i] + rows_.shift[r];
      const OfFaces f = heights(x);
      bool is_strict = true;
      if (!is_sure && !holds({x, y, z}, f, is_strict)) continue;
      claim(static_cast<std::uint32_t>(r * edge_rows + i), weights(f, {x, y, z}), is_strict);
    }
  }

  /// Returns false when the row is outside a face parallel to it. When it is too near to tell, no
  /// point is sure.
  bool holds_blind_faces(double& inner_hi) const {
    for (std::size_t f = 0; f < 4; ++f) {
      if (inverse_.at(f) != 0) continue;
      if (rest_.at(f) < -2 * error_) return false;
      if (rest_.at(f) <= 2 * error_) inner_hi = -1;
    }
    return true;
  }

  OfFaces heights(double x) const {
    return {normal_[0].pair[0] * (x - on_face_[0].pair[0]) + rest_.pair[0],
            normal_[0].pair[1] * (x - on_face_[0].pair[1]) + rest_.pair[1]};
  }

  /// The exact decision.
  bool holds(const Point& q, const OfFaces& f, bool& is_strict) const {
    for (std::size_t a = 0; a < 4; ++a)
      if (f.at(a) < -error_) return false;
    for (std::size_t a = 0; a < 4; ++a) {
      if (f.at(a) > error_) continue;
      std::array<Point, 4> moved = p_;
      moved[a] = q;
      const int side = orientation(moved[0], moved[1], moved[2], moved[3]);
      if (side < 0) return false;
      if (side == 0) is_strict = false;
    }
    return true;
  }

  std::array<double, 4> weights(const OfFaces& f, const Point& q) const {
    if (!(volume_ > 1e6 * error_)) return careful_weights(p_, q);
    const Two low = larger(f.pair[0], Two{}), high = larger(f.pair[1], Two{});
    const double inverse = 1 / ((low[0] + low[1]) + (high[0] + high[1]));
    return {low[0] * inverse, low[1] * inverse, high[0] * inverse, high[1] * inverse};
  }

  /// A face's plane in single precision. No row has points inside below low + y * j + z * k, or
  /// above the same expression with high.
  struct Line {
    float low, high, y, z;
  };

  const SampleLattice& lattice_;
  const PointRows& rows_;
  const std::array<Point, 4>& p_;
  std::array<std::size_t, 3> low_{}, high_{};
  Point reach_{};  ///< largest distance of an examined point from a vertex
  /// of the face opposite a vertex, inward; its length is twice the face's area
  std::array<OfFaces, 3> normal_{};
  std::array<OfFaces, 3> on_face_{};  ///< a vertex
  OfFaces rest_{};                    ///< of the row
  /// how a face bounds a row from below and from above
  OfFaces u_{}, inverse_{}, below_{}, above_{};
  std::array<Line, 4> lines_{};
  bool sees_all_ = true;  ///< no face is parallel to the rows
  double volume_ = 0, error_ = 0;
};

/// Adds the data of the first test for the rows that have points, one after another.
void add_steps(const SampleLattice& lattice, PointRows& rows) {
  const auto step = static_cast<std::size_t>(rows.row_step);
  std::size_t n = 0;
  for (std::size_t k = 0; k < PointRows::edge; k += step)
    for (std::size_t j = 0; j < PointRows::edge; j += step, ++n) {
      const std::size_t row = k * PointRows::edge + j;
      const auto in_steps = [&](const std::array<double, PointRows::edge * PointRows::edge>& places, int axis) {
        return static_cast<float>((places[row] - lattice.low[axis]) * rows.inverse_spacing[axis] -
                                  static_cast<double>(rows.first[axis]));
      };
      rows.y_steps[n] = in_steps(rows.y, 1);
      rows.z_steps[n] = in_steps(rows.z, 2);
      rows.shift_steps[n] = static_cast<float>(rows.shift[row] * rows.inverse_spacing.x);
    }
}

}  // namespace

PointRows rows_of_samples(const SampleLattice& lattice, const Index3& brick) {
  PointRows rows;
  rows.first = brick * edge;
  for (int a = 0; a < 3; ++a) rows.inverse_spacing[a] = 1 / lattice.spacing[a];
  for (int a = 0; a < 3; ++a) rows.size[a] = std::min(edge, lattice.count[a] - rows.first[a]);
  const auto place = [&](std::size_t axis, std::int64_t i) {
    return lattice.places[axis][static_cast<std::size_t>(rows.first[static_cast<int>(axis)] + i)];
  };
  rows.shift.fill(0);
  rows.y.fill(place(1, 0));
  rows.z.fill(place(2, 0));
  for (std::int64_t i = 0; i < rows.size.x; ++i) rows.x[static_cast<std::size_t>(i)] = place(0, i);
  for (std::int64_t k = 0; k < rows.size.z; ++k)
    for (std::int64_t j = 0; j < rows.size.y; ++j) {
      const auto row = static_cast<std::size_t>(k * edge + j);
      rows.y[row] = place(1, j);
      rows.z[row] = place(2, k);
    }
  add_steps(lattice, rows);
  return rows;
}

PointRows rows_of_probes(const SampleLattice& lattice, const Index3& brick, std::int64_t row_step) {
  PointRows rows = rows_of_samples(lattice, brick);
  rows.spread = 1;
  rows.row_step = row_step;
  for (int a = 0; a < 3; ++a) rows.size[a] = std::min(edge, lattice.count[a] - 1 - rows.first[a]);
  constexpr std::array<std::int64_t, 3> steps{1, 19, 41};
  constexpr std::int64_t place_count = edge * edge;
  const std::int64_t rows_per_axis = edge / row_step, brick_count = row_step * row_step;
  const std::int64_t turn = (brick.x % 4 + brick.y % 2 * 4 + brick.z % 2 * 8) % brick_count;
  for (std::int64_t k = 0; k < rows.size.z; k += row_step)
    for (std::int64_t j = 0; j < rows.size.y; j += row_step) {
      const std::int64_t number = (k / row_step * rows_per_axis + j / row_step) * brick_count + turn;
      const auto place = [&](std::size_t axis) {
        return (static_cast<double>(number * steps[axis] % place_count) + 0.5) / static_cast<double>(place_count);
      };
      const auto row = static_cast<std::size_t>(k * edge + j);
      rows.shift[row] = place(0) * lattice.spacing.x;
      rows.y[row] += place(1) * lattice.spacing.y;
      rows.z[row] += place(2) * lattice.spacing.z;
    }
  add_steps(lattice, rows);
  return rows;
}

void locate(std::span<const std::array<double, 3>> points, std::span<const std::array<std::uint32_t, 4>> cells,
            std::span<const std::uint32_t> touched, const SampleLattice& lattice, const PointRows& rows, Places& places,
            std::vector<SecondClaim>* second) {
  places.cell.fill(Places::outside);
  for (const std::uint32_t c : touched) {
    const auto& cell = cells[c];
    const std::array<Point, 4> corners{points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]};
    // Flat cells are detected only where a claim occurs. Claims are few, and the exact sign of all
    // cells would cost more.
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

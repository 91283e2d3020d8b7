#include "preprocess/resample/certify.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "preprocess/inspect/has_data.h"
#include "preprocess/resample/locate.h"
#include "preprocess/resample/neighborhood.h"
#include "preprocess/resample/trilinear_patch.h"

namespace rhoray::preprocess {
namespace {

using Range = tbb::blocked_range<std::size_t>;
using Point = std::array<double, 3>;
constexpr std::size_t edge = PointRows::edge;
constexpr auto brick_samples = static_cast<std::size_t>(SampleLattice::brick_samples);

constexpr double relative_gap = 0.05;  // what a bound may exceed an attained difference by
constexpr double gap_of_range = 1e-6;  // or this share of the field's range
constexpr std::size_t fully_probed_bricks = 1024;
constexpr std::size_t largest_piece_count = 4096;  // of one leaf cell's faces; a fold of ten would take a few hundred

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double sum_of_magnitudes(const Point& a) {
  return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]);
}

/// A cell's linear function: how it rises with each step of the lattice.
struct Gradient {
  Point slope{};
  double error = std::numeric_limits<double>::infinity();  ///< of each component; infinite when the cell has no volume
  bool has_values = false;                                 ///< at all four vertices
};

/// A field as the certificate needs it.
struct FieldView {
  std::vector<double> values;  ///< at the mesh's points
  std::vector<Gradient> gradients;
  double range = 0;
  double unit = 1;   ///< of the sums over faces, which are in single precision
  double noise = 0;  ///< what rounding may do to a difference
  std::span<const Conflict> conflicts;
};

Gradient gradient_of(const std::array<Point, 4>& p, const std::array<double, 4>& v) {
  Gradient gradient;
  gradient.has_values = has_data(v[0]) && has_data(v[1]) && has_data(v[2]) && has_data(v[3]);
  const Point e1 = minus(p[1], p[0]), e2 = minus(p[2], p[0]), e3 = minus(p[3], p[0]);
  const Point n1 = cross(e2, e3), n2 = cross(e3, e1), n3 = cross(e1, e2);
  const double six_volumes = dot(n3, e3);
  if (!gradient.has_values || !(six_volumes > 0)) return gradient;
  double change = 0, box = 1, inverse_sides = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    gradient.slope[a] = ((v[1] - v[0]) * n1[a] + (v[2] - v[0]) * n2[a] + (v[3] - v[0]) * n3[a]) / six_volumes;
    const double side = std::max(std::max(p[0][a], p[1][a]), std::max(p[2][a], p[3][a])) -
                        std::min(std::min(p[0][a], p[1][a]), std::min(p[2][a], p[3][a]));
    box *= side;
    inverse_sides += 1 / side;
  }
  for (std::size_t a = 1; a < 4; ++a) change = std::max(change, std::abs(v[a] - v[0]));
  // As in locate.cpp: products of three differences, their rounding bounded by the box.
  const double relative_error = 0x1p-49 * 6 * box / six_volumes;
  gradient.error = relative_error * (8 * change * inverse_sides + 2 * sum_of_magnitudes(gradient.slope));
  return gradient;
}

FieldView view_of(const CleanMesh& mesh, const PointField& field, const std::vector<Point>& steps,
                  const SampleLattice& lattice, std::span<const Conflict> conflicts) {
  FieldView view;
  view.conflicts = conflicts;
  bool is_single = false;
  std::visit(
      [&]<class T>(const Array<T>& values) {
        view.values.assign(values.begin(), values.end());
        is_single = std::is_same_v<T, float>;
      },
      field.values);
  Interval<double> range;
  for (const double value : view.values)
    if (has_data(value)) range.include(value);
  if (range.is_empty()) range = {0, 0};
  view.range = range.hi - range.lo;
  if (view.range > 0 && has_data(1 / view.range) && has_data(view.range)) view.unit = view.range;
  const double largest = std::max(std::abs(range.lo), std::abs(range.hi));
  const auto axis = static_cast<double>(std::max({lattice.count.x, lattice.count.y, lattice.count.z}));
  view.noise = largest * ((is_single ? 0x1p-24 : 0) + 0x1p-50 * axis);
  view.gradients.resize(mesh.cells.size());
  tbb::parallel_for(Range(0, mesh.cells.size(), 4096), [&](const Range& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      const auto& cell = mesh.cells[c];
      view.gradients[c] =
          gradient_of({steps[cell[0]], steps[cell[1]], steps[cell[2]], steps[cell[3]]},
                      {view.values[cell[0]], view.values[cell[1]], view.values[cell[2]], view.values[cell[3]]});
    }
  });
  return view;
}

/// A face of the mesh that may touch leaf cells of the brick, in steps from the brick's first sample.
struct BrickFace {
  std::array<Point, 3> corners;
  std::array<std::uint32_t, 3> vertices;
  std::array<std::int8_t, 3> low, high;  ///< leaf cells of the brick in the face's box
  std::uint32_t cell;
  std::uint32_t neighbor;      ///< or FaceNeighbors::none
  Point normal;                ///< twice the face's area long
  std::array<Point, 3> sides;  ///< directions in the face's plane, normal to an edge, inward

  double normal_error;  ///< of each component, from rounding
  double normal_reach;  ///< how far a leaf cell's corners are from its centre along these directions
  std::array<double, 3> side_reaches;

  void measure() {
    const Point e0 = minus(corners[1], corners[0]), e1 = minus(corners[2], corners[1]),
                e2 = minus(corners[0], corners[2]);
    normal = cross(e0, e1);
    normal_error = 0x1p-48 * sum_of_magnitudes(e0) * sum_of_magnitudes(e1);
    sides = {cross(normal, e0), cross(normal, e1), cross(normal, e2)};
    constexpr double half = 0.5 + 1e-6;
    normal_reach = half * sum_of_magnitudes(normal);
    for (std::size_t e = 0; e < 3; ++e) side_reaches[e] = half * sum_of_magnitudes(sides[e]);
  }

  /// False when the leaf cell that has `center` in its middle is clear of the face.
  bool may_touch(const Point& center) const {
    if (std::abs(dot(normal, minus(center, corners[0]))) > normal_reach) return false;
    for (std::size_t e = 0; e < 3; ++e)
      if (dot(sides[e], minus(center, corners[e])) < -side_reaches[e]) return false;
    return true;
  }
};

/// A leaf cell's trilinear function, split at the cell's middle into a linear function and the rest.
class CellPlane {
 public:
  /// @param corners  the function there, x fastest
  explicit CellPlane(const std::array<double, 8>& corners) {
    for (std::size_t c = 0; c < 8; ++c) {
      value_ += 0.125 * corners[c];
      for (std::size_t a = 0; a < 3; ++a) slope_[a] += (c >> a & 1) != 0 ? 0.25 * corners[c] : -0.25 * corners[c];
    }
    for (std::size_t c = 0; c < 8; ++c) {
      double linear = value_;
      for (std::size_t a = 0; a < 3; ++a) linear += (c >> a & 1) != 0 ? 0.5 * slope_[a] : -0.5 * slope_[a];
      rest_ = std::max(rest_, std::abs(corners[c] - linear));
    }
  }

  /// What the difference cannot exceed on a face: in its plane the linear function is off by some value and slope, and
  /// the rest, being trilinear, is largest at a corner of the cell. Infinite or NaN where the face's cell has no
  /// gradient.
  /// @param low  the leaf cell's first sample
  double bound_on(const BrickFace& face, const FieldView& field, const Point& low) const {
    const Gradient& gradient = field.gradients[face.cell];
    double distance = 0, along = 0, at_middle = value_ - field.values[face.vertices[0]], reach = 1.5;
    Point middle, half, off;
    for (std::size_t a = 0; a < 3; ++a) {
      const double p = face.corners[0][a] - low[a], q = face.corners[1][a] - low[a], r = face.corners[2][a] - low[a];
      const double lo = std::max(0.0, std::min(std::min(p, q), r)), hi = std::min(1.0, std::max(std::max(p, q), r));
      middle[a] = 0.5 * (lo + hi);
      half[a] = 0.5 * std::abs(hi - lo) + 1e-6;
      off[a] = slope_[a] - gradient.slope[a];
      at_middle += slope_[a] * (middle[a] - 0.5) - gradient.slope[a] * (middle[a] - p);
      distance += face.normal[a] * (p - middle[a]);
      along += face.normal[a] * off[a];
      reach += std::abs(middle[a] - p);
    }
    const double area = dot(face.normal, face.normal);
    double bound = std::abs(at_middle + along * distance / area);
    for (std::size_t a = 0; a < 3; ++a) bound += half[a] * std::abs(off[a] - along * face.normal[a] / area);
    const double rounding = reach * (gradient.error + std::abs(along) / area * face.normal_error);
    return (bound + rest_ + rounding) * (1 + 1e-9);
  }

 private:
  double value_ = 0, rest_ = 0;
  Point slope_{};
};

/// What one brick's leaf cells say about one field.
struct BrickErrors {
  double bound = 0, attained = 0, sum_of_squares = 0;
  Point attained_at{};  ///< in steps of the lattice
  std::uint32_t point_count = 0;
};

/// Works on one brick after another; one for each thread.
class BrickCertifier {
 public:
  BrickCertifier(const CleanMesh& mesh, const FaceNeighbors& neighbors, const std::vector<Point>& steps,
                 const SampleLattice& lattice, const TouchedBricks& touched, const BrickSamples& samples)
      : mesh_(mesh), neighbors_(neighbors), steps_(steps), lattice_(lattice), touched_(touched), samples_(samples) {}

  void enter(std::size_t slot) {
    slot_ = slot;
    brick_ = touched_.at(slot);
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = static_cast<int>(a);
      const std::int64_t first = brick_[axis] * SampleLattice::brick_edge;
      first_[a] = static_cast<double>(first);
      cell_count_[a] =
          static_cast<std::size_t>(std::min<std::int64_t>(SampleLattice::brick_edge, lattice_.count[axis] - 1 - first));
    }
  }

  /// Finds where the probes of the brick lie, for all fields.
  void find_probes(bool in_every_row) {
    probes_ = rows_of_probes(lattice_, brick_, in_every_row);
    locate(mesh_.points, mesh_.cells, cells(), lattice_, probes_, places_, nullptr);
  }
  BrickErrors probe(const FieldView& field, std::size_t f) {
    BrickErrors errors;
    samples_nearby_.gather(touched_, brick_, samples_.fields[f]);
    if (samples_nearby_.covered_count() > 0) take_probes(field, errors);
    return errors;
  }
  /// After probe: probes in the mesh, and those of them in leaf cells without a trilinear field.
  std::size_t probes_in_mesh() const {
    return static_cast<std::size_t>(std::count_if(places_.cell.begin(), places_.cell.end(),
                                                  [](std::uint32_t cell) { return cell != Places::outside; }));
  }
  std::size_t uncovered_probes() const {
    std::size_t count = 0;
    for (std::size_t p = 0; p < brick_samples; ++p)
      count += places_.cell[p] != Places::outside && !samples_nearby_.is_covered(p);
    return count;
  }

  /// Finds the faces in the brick, for all fields.
  void find_faces() {
    faces_.clear();
    for (auto& layer : layers_) layer.clear();
    for (const std::uint32_t c : cells()) {
      if (neighbors_.is_flat[c]) continue;
      for (std::size_t f = 0; f < 4; ++f) {
        const std::uint32_t neighbor = neighbors_.cells[c][f];
        if (neighbor < c) continue;  // its turn is with the other cell; none is above all
        add_face(c, f, neighbor);
      }
    }
  }
  /// Adds the bound, and what is attained on the way to it, to what probes have attained.
  /// @param good_enough  a bound up to this is taken as it is
  void bound(const FieldView& field, std::size_t f, double good_enough, BrickErrors& errors) {
    samples_nearby_.gather(touched_, brick_, samples_.fields[f]);
    if (samples_nearby_.covered_count() == 0) return;
    sum_bounds(field);
    for (std::size_t p = 0; p < brick_samples; ++p)
      bounds_[p] = (std::max(sums_[0][p], sums_[1][p]) + common_error_) * (1 + 1e-4F);
    take_conflicts(field, errors);
    refine(field, good_enough, errors);
    errors.bound += field.noise;
  }

 private:
  std::span<const std::uint32_t> cells() const { return touched_.lists.view().list(touched_.bricks[slot_]); }

  void add_face(std::uint32_t c, std::size_t f, std::uint32_t neighbor) {
    BrickFace face;
    face.cell = c;
    face.neighbor = neighbor;
    for (std::size_t v = 0; v < 3; ++v) {
      face.vertices[v] = mesh_.cells[c][face_vertices[f][v]];
      face.corners[v] = minus(steps_[face.vertices[v]], first_);
    }
    constexpr double margin = 1e-6;  // of a step, as in leaf_lists/touched_leaves.h
    for (std::size_t a = 0; a < 3; ++a) {
      const double lo = std::min({face.corners[0][a], face.corners[1][a], face.corners[2][a]}) - margin;
      const double hi = std::max({face.corners[0][a], face.corners[1][a], face.corners[2][a]}) + margin;
      const auto count = static_cast<double>(cell_count_[a]);
      if (hi < 0 || lo >= count) return;
      face.low[a] = static_cast<std::int8_t>(std::max(lo, 0.0));
      face.high[a] = static_cast<std::int8_t>(std::min(hi, count - 1));
    }
    face.measure();
    const FaceInLayer in_layer{cells_in_box(face), static_cast<std::uint32_t>(faces_.size())};
    for (auto k = face.low[2]; k <= face.high[2]; ++k) layers_[static_cast<std::size_t>(k)].push_back(in_layer);
    faces_.push_back(face);
  }

  /// A face whose box has leaf cells in a layer: bit 8 * j + i of those.
  struct FaceInLayer {
    std::uint64_t cells;
    std::uint32_t number;
  };

  static std::uint64_t cells_in_box(const BrickFace& face) {
    const std::uint64_t row = (std::uint64_t{2} << face.high[0]) - (std::uint64_t{1} << face.low[0]);
    std::uint64_t cells = 0;
    for (int j = face.low[1]; j <= face.high[1]; ++j) cells |= row << (8 * j);
    return cells;
  }

  static double trilinear(const std::array<double, 8>& c, double x, double y, double z) {
    const double x0 = c[0] + x * (c[1] - c[0]), x1 = c[2] + x * (c[3] - c[2]);
    const double x2 = c[4] + x * (c[5] - c[4]), x3 = c[6] + x * (c[7] - c[6]);
    const double y0 = x0 + y * (x1 - x0), y1 = x2 + y * (x3 - x2);
    return y0 + z * (y1 - y0);
  }

  /// A difference that is attained in leaf cell (i, j, k) at a place from 0 to 1.
  void attain(double difference, std::size_t i, std::size_t j, std::size_t k, const Point& in_cell,
              BrickErrors& errors) const {
    if (!(difference > errors.attained)) return;
    errors.attained = difference;
    errors.attained_at = {first_[0] + static_cast<double>(i) + in_cell[0],
                          first_[1] + static_cast<double>(j) + in_cell[1],
                          first_[2] + static_cast<double>(k) + in_cell[2]};
  }

  void take_probes(const FieldView& field, BrickErrors& errors) const {
    for (std::size_t k = 0; k < cell_count_[2]; ++k)
      for (std::size_t j = 0; j < cell_count_[1]; ++j) {
        const std::size_t row = k * edge + j;
        const double y = (probes_.y[row] - row_place(1, j)) / lattice_.spacing.y;
        const double z = (probes_.z[row] - row_place(2, k)) / lattice_.spacing.z;
        const double x = probes_.shift[row] / lattice_.spacing.x;
        for (std::size_t i = 0; i < cell_count_[0]; ++i) {
          const std::size_t p = Neighborhood::place(i, j, k);
          if (places_.cell[p] == Places::outside || !samples_nearby_.is_covered(p)) continue;
          const auto& cell = mesh_.cells[places_.cell[p]];
          const auto& weights = places_.weights[p];
          const double linear = weights[0] * field.values[cell[0]] + weights[1] * field.values[cell[1]] +
                                weights[2] * field.values[cell[2]] + weights[3] * field.values[cell[3]];
          const double difference = std::abs(trilinear(samples_nearby_.corners(i, j, k), x, y, z) - linear);
          if (!has_data(difference)) continue;
          errors.sum_of_squares += difference * difference;
          ++errors.point_count;
          attain(difference, i, j, k, {x, y, z}, errors);
        }
      }
  }

  double row_place(std::size_t axis, std::size_t i) const {
    return lattice_.places[axis][static_cast<std::size_t>(probes_.first[static_cast<int>(axis)]) + i];
  }

  /// Every leaf cell's sum over the faces in it; infinite where a face has no neighbour to say how the gradient jumps.
  void sum_bounds(const FieldView& field) {
    for (auto& sums : sums_) sums.fill(0);
    common_error_ = 0;
    for (const BrickFace& face : faces_) {
      const Gradient& own = field.gradients[face.cell];
      const bool has_both =
          face.neighbor != FaceNeighbors::none && own.has_values && field.gradients[face.neighbor].has_values;
      const double area = dot(face.normal, face.normal);
      if (!has_both || !(area > 1e-200)) {
        mark(face);
        continue;
      }
      const Gradient& other = field.gradients[face.neighbor];
      const Point jump = minus(own.slope, other.slope);
      const double along = dot(jump, face.normal) / area, scaled = along / field.unit;
      const Point in_plane = minus(jump, {along * face.normal[0], along * face.normal[1], along * face.normal[2]});
      const Point ramp{scaled * face.normal[0], scaled * face.normal[1], scaled * face.normal[2]};
      const double error = (own.error + other.error + sum_of_magnitudes(in_plane)) / field.unit;
      if (!(error < 1e30 && sum_of_magnitudes(ramp) < 1e30)) {
        mark(face);
        continue;
      }
      add_ramp(face, ramp, error, along < 0 ? 0 : 1);
    }
  }

  /// A linear function at the centres of leaf cells: start + i * x + j * y + k * z. In single precision, but for the
  /// start, so that it is near its zero as precise as far from it.
  struct Heights {
    float start, x, y, z;

    Heights(const Point& direction, const Point& zero)
        : start(static_cast<float>(direction[0] * (0.5 - zero[0]) + direction[1] * (0.5 - zero[1]) +
                                   direction[2] * (0.5 - zero[2]))),
          x(static_cast<float>(direction[0])),
          y(static_cast<float>(direction[1])),
          z(static_cast<float>(direction[2])) {}
    float row(std::size_t j, std::size_t k) const {
      return start + static_cast<float>(j) * y + static_cast<float>(k) * z;
    }
  };

  using Four = float __attribute__((vector_size(16)));
  static constexpr Four lanes{0, 1, 2, 3};

  /// What is infinite stays so: single precision has room for sums of it.
  static constexpr float infinite = 1e37F;

  void mark(const BrickFace& face) {
    const auto [i0, j0, k0] = face.low;
    const auto [i1, j1, k1] = face.high;
    for (int k = k0; k <= k1; ++k)
      for (int j = j0; j <= j1; ++j)
        for (int i = i0; i <= i1; ++i)
          if (face.may_touch({i + 0.5, j + 0.5, k + 0.5}))
            sums_[0][Neighborhood::place(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                                         static_cast<std::size_t>(k))] = infinite;
  }

  /// Adds min(|ramp| / 4, (w^2 - s^2) / 2w) to the leaf cells that the face touches: s is the height of the cell's
  /// centre, w what its corners differ from that; with s_max = s + w and s_min = s - w this is the bound of certify.h.
  /// In single precision, with more than its rounding added, four leaf cells at once.
  void add_ramp(const BrickFace& face, const Point& ramp, double error, std::size_t ramp_side) {
    const double w = 0.5 * sum_of_magnitudes(ramp);
    add_error(face, error + 1e-30);
    if (w < 1e-30) return;
    constexpr double rounding = 1e-4;
    const auto level = static_cast<float>(0.25 * std::sqrt(dot(ramp, ramp)) * (1 + rounding));
    const auto top = static_cast<float>(0.5 * w * (1 + 4 * rounding));
    const auto bend = static_cast<float>(0.5 / w);
    const Heights heights(ramp, face.corners[0]);
    std::array<Heights, 3> sides{Heights(face.sides[0], face.corners[0]), Heights(face.sides[1], face.corners[1]),
                                 Heights(face.sides[2], face.corners[2])};
    for (std::size_t e = 0; e < 3; ++e)
      sides[e].start += static_cast<float>((0.5 + rounding) * sum_of_magnitudes(face.sides[e]));
    const std::size_t first_lane = static_cast<std::size_t>(face.low[0]) / 4 * 4,
                      last_lane = static_cast<std::size_t>(face.high[0]);
    constexpr float middle = 0.5F * (edge - 1);
    const float reach = static_cast<float>(w * (1 + 4 * rounding)) + middle * std::abs(heights.x);
    for (auto k = static_cast<std::size_t>(face.low[2]); k <= static_cast<std::size_t>(face.high[2]); ++k)
      for (auto j = static_cast<std::size_t>(face.low[1]); j <= static_cast<std::size_t>(face.high[1]); ++j) {
        const float start = heights.row(j, k);
        if (std::abs(start + middle * heights.x) > reach) continue;
        const std::array<float, 3> side{sides[0].row(j, k), sides[1].row(j, k), sides[2].row(j, k)};
        float* sums = sums_[ramp_side].data() + Neighborhood::place(0, j, k);
        for (std::size_t i = first_lane; i <= last_lane; i += 4) {
          const Four at = lanes + static_cast<float>(i);
          const Four s = start + at * heights.x;
          Four bound = top - bend * s * s;
          bound = bound < level ? bound : lanes * 0 + level;
          bound = bound > 0 ? bound : lanes * 0;
          const Four a = side[0] + at * sides[0].x, b = side[1] + at * sides[1].x, c = side[2] + at * sides[2].x;
          Four inside = a < b ? a : b;
          inside = inside < c ? inside : c;
          Four sum;
          std::memcpy(&sum, sums + i, sizeof sum);
          sum += inside >= 0 ? bound : lanes * 0;
          std::memcpy(sums + i, &sum, sizeof sum);
        }
      }
  }

  /// What rounding may do to a face's jump, whichever way it bends: next to nothing counts for the whole brick.
  void add_error(const BrickFace& face, double error) {
    constexpr double negligible = 1e-10;
    if (error < negligible) {
      common_error_ += static_cast<float>(2 * error);
      return;
    }
    for (auto k = static_cast<std::size_t>(face.low[2]); k <= static_cast<std::size_t>(face.high[2]); ++k)
      for (auto j = static_cast<std::size_t>(face.low[1]); j <= static_cast<std::size_t>(face.high[1]); ++j)
        for (auto i = static_cast<std::size_t>(face.low[0]); i <= static_cast<std::size_t>(face.high[0]); ++i)
          for (auto& sums : sums_) sums[Neighborhood::place(i, j, k)] += static_cast<float>(2 * error);
  }

  /// Leaf cells around samples for which cells of the mesh compete: their difference is attained, and the sums above
  /// know nothing of it. Those in bricks beside this one count where they are corners of its leaf cells.
  void take_conflicts(const FieldView& field, BrickErrors& errors) {
    if (field.conflicts.empty()) return;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const std::uint32_t slot = touched_.slot(brick_ + Index3(corner & 1, corner >> 1 & 1, corner >> 2));
      if (slot == TouchedBricks::none) continue;
      auto conflict = std::lower_bound(field.conflicts.begin(), field.conflicts.end(), slot,
                                       [](const Conflict& c, std::uint32_t wanted) { return c.slot < wanted; });
      for (; conflict != field.conflicts.end() && conflict->slot == slot; ++conflict) {
        const std::size_t s = conflict->sample;
        const std::array<std::size_t, 3> sample{s % edge + (corner & 1 ? edge : 0),
                                                s / edge % edge + (corner & 2 ? edge : 0),
                                                s / edge / edge + (corner & 4 ? edge : 0)};
        take_conflict(sample, conflict->difference, errors);
      }
    }
  }

  void take_conflict(const std::array<std::size_t, 3>& sample, double difference, BrickErrors& errors) {
    for (std::size_t around = 0; around < 8; ++around) {
      std::array<std::size_t, 3> cell;
      bool is_here = true;
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t back = around >> a & 1;
        is_here = is_here && sample[a] >= back && sample[a] - back < cell_count_[a];
        cell[a] = sample[a] - back;
      }
      if (!is_here || !samples_nearby_.is_covered(Neighborhood::place(cell[0], cell[1], cell[2]))) continue;
      bounds_[Neighborhood::place(cell[0], cell[1], cell[2])] = infinite;
      if (!has_data(difference)) continue;
      attain(difference, cell[0], cell[1], cell[2],
             {static_cast<double>(sample[0] - cell[0]), static_cast<double>(sample[1] - cell[1]),
              static_cast<double>(sample[2] - cell[2])},
             errors);
    }
  }

  struct Piece {
    double upper;
    std::array<PatchPoint, 3> triangle;
    friend bool operator<(const Piece& a, const Piece& b) { return a.upper < b.upper; }
  };

  /// Looks at the faces in leaf cells, those with the largest sums first, until no other can hold more than the goal.
  void refine(const FieldView& field, double good_enough, BrickErrors& errors) {
    candidates_.clear();
    const auto goal = [&] {
      return std::max(
          {errors.attained * (1 + relative_gap), errors.attained + gap_of_range * field.range, good_enough});
    };
    const auto sum_of = [&](std::size_t cell) { return static_cast<double>(bounds_[cell]) * field.unit; };
    errors.bound = errors.attained;
    for (std::size_t k = 0; k < cell_count_[2]; ++k)
      for (std::size_t j = 0; j < cell_count_[1]; ++j)
        for (std::size_t i = 0; i < cell_count_[0]; ++i) {
          const std::size_t p = Neighborhood::place(i, j, k);
          if (!samples_nearby_.is_covered(p)) continue;
          if (sum_of(p) > goal())
            candidates_.push_back(static_cast<std::uint32_t>(p));
          else
            errors.bound = std::max(errors.bound, sum_of(p));
        }
    std::sort(candidates_.begin(), candidates_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return bounds_[a] != bounds_[b] ? bounds_[a] > bounds_[b] : a < b;
    });
    for (const std::uint32_t p : candidates_) {
      if (sum_of(p) <= goal())
        errors.bound = std::max(errors.bound, sum_of(p));
      else
        refine_cell(field, p, goal, errors);
    }
    errors.bound = std::max(errors.bound, errors.attained);
  }

  template <class Goal>
  void refine_cell(const FieldView& field, std::uint32_t p, const Goal& goal, BrickErrors& errors) {
    const std::size_t i = p % edge, j = p / edge % edge, k = p / edge / edge;
    const std::array<double, 8> corners = samples_nearby_.corners(i, j, k);
    const Point low{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
    pieces_.clear();
    const auto add = [&](const std::array<PatchPoint, 3>& triangle) {
      const PatchBounds bounds = patch_bounds(triangle, corners);
      attain(bounds.attained, i, j, k, bounds.at, errors);
      if (bounds.upper <= goal()) {
        errors.bound = std::max(errors.bound, bounds.upper);
        return;
      }
      pieces_.push_back({bounds.upper, triangle});
      std::push_heap(pieces_.begin(), pieces_.end());
    };
    const CellPlane plane(corners);
    const Point center{low[0] + 0.5, low[1] + 0.5, low[2] + 0.5};
    for (const auto& [cells, number] : layers_[k]) {
      if ((cells >> (edge * j + i) & 1) == 0) continue;
      const BrickFace& face = faces_[number];
      if (!face.may_touch(center)) continue;
      const double face_bound = plane.bound_on(face, field, low);
      if (face_bound * (1 + relative_gap) <= goal()) {
        errors.bound = std::max(errors.bound, face_bound);
        continue;
      }
      std::array<PatchPoint, 3> triangle;
      bool has_values = true;
      for (std::size_t v = 0; v < 3; ++v) {
        triangle[v] = {minus(face.corners[v], low), field.values[face.vertices[v]]};
        has_values = has_values && has_data(triangle[v].value);
      }
      if (!has_values) continue;
      const ClippedTriangle clipped(triangle);
      for (std::size_t c = 2; c < clipped.size(); ++c) add({clipped[0], clipped[c - 1], clipped[c]});
    }
    for (std::size_t count = 0; !pieces_.empty() && count < largest_piece_count; ++count) {
      if (pieces_.front().upper <= goal()) break;
      std::pop_heap(pieces_.begin(), pieces_.end());
      const std::array<PatchPoint, 3> t = pieces_.back().triangle;
      pieces_.pop_back();
      const PatchPoint a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      add({t[0], a, c});
      add({a, t[1], b});
      add({c, b, t[2]});
      add({a, b, c});
    }
    if (!pieces_.empty()) errors.bound = std::max(errors.bound, pieces_.front().upper);
  }

  static PatchPoint middle(const PatchPoint& a, const PatchPoint& b) {
    return {{0.5 * (a.at[0] + b.at[0]), 0.5 * (a.at[1] + b.at[1]), 0.5 * (a.at[2] + b.at[2])},
            0.5 * (a.value + b.value)};
  }

  const CleanMesh& mesh_;
  const FaceNeighbors& neighbors_;
  const std::vector<Point>& steps_;
  const SampleLattice& lattice_;
  const TouchedBricks& touched_;
  const BrickSamples& samples_;

  std::size_t slot_ = 0;
  Index3 brick_;
  Point first_{};
  std::array<std::size_t, 3> cell_count_{};
  PointRows probes_;
  Places places_;
  std::vector<BrickFace> faces_;
  std::array<std::vector<FaceInLayer>, edge> layers_;  ///< faces by the leaf cells' k
  Neighborhood samples_nearby_;
  std::array<std::array<float, brick_samples>, 2> sums_{};  ///< of faces that bend one way, and the other
  float common_error_ = 0;                                  ///< in every leaf cell, on top of the sums
  std::array<float, brick_samples> bounds_{};               ///< by leaf cell
  std::vector<std::uint32_t> candidates_;
  std::vector<Piece> pieces_;
};

/// The next number in single precision, as which bounds are kept.
double rounded_up(double value) {
  const auto rounded = static_cast<float>(value);
  const bool is_below = static_cast<double>(rounded) < value;
  return static_cast<double>(is_below ? std::nextafter(rounded, std::numeric_limits<float>::infinity()) : rounded);
}

/// Marks the bricks with the largest errors so far, one in 128.
void mark_worst(const std::vector<BrickErrors>& errors, std::vector<std::uint8_t>& marks) {
  std::vector<std::uint32_t> order(errors.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto count = static_cast<std::ptrdiff_t>(std::min(errors.size(), errors.size() / 128 + 1));
  std::partial_sort(order.begin(), order.begin() + count, order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return errors[a].attained != errors[b].attained ? errors[a].attained > errors[b].attained : a < b;
  });
  for (auto slot = order.begin(); slot != order.begin() + count; ++slot) marks[*slot] = 1;
}

}  // namespace

Certificates certify(const CleanMesh& mesh, const std::vector<PointField>& fields, const FaceNeighbors& neighbors,
                     const SampleLattice& lattice, const TouchedBricks& touched, const BrickSamples& samples,
                     const Progress& progress) {
  std::vector<Point> steps(mesh.points.size());
  for (std::size_t p = 0; p < steps.size(); ++p) steps[p] = lattice.in_steps(mesh.points[p]);
  std::vector<FieldView> views;
  for (std::size_t f = 0; f < fields.size(); ++f)
    views.push_back(view_of(mesh, fields[f], steps, lattice, samples.conflicts[f]));

  const std::size_t slot_count = touched.bricks.size();
  std::vector<std::vector<BrickErrors>> errors(fields.size(), std::vector<BrickErrors>(slot_count));
  std::vector<std::array<std::size_t, 2>> probe_counts(slot_count);
  ProgressMeter meter(progress, "certifying bricks", 3 * slot_count);
  tbb::enumerable_thread_specific<BrickCertifier> certifiers(mesh, neighbors, steps, lattice, touched, samples);
  const auto for_each_brick = [&](auto&& act) {
    tbb::parallel_for(Range(0, slot_count, 16), [&](const Range& part) {
      BrickCertifier& certifier = certifiers.local();
      for (std::size_t slot = part.begin(); slot < part.end(); ++slot) {
        certifier.enter(slot);
        act(certifier, slot);
      }
      meter.add(part.size());
    });
  };
  for_each_brick([&](BrickCertifier& certifier, std::size_t slot) {
    certifier.find_probes(slot_count <= fully_probed_bricks);
    for (std::size_t f = fields.size(); f-- > 0;) errors[f][slot] = certifier.probe(views[f], f);
    probe_counts[slot] = {certifier.probes_in_mesh(), certifier.uncovered_probes()};
  });
  // The bricks with the largest errors first: what is attained there is good enough for the others.
  std::vector<double> largest(fields.size(), 0);
  std::vector<std::uint8_t> is_first(slot_count);
  for (std::size_t f = 0; f < fields.size(); ++f) mark_worst(errors[f], is_first);
  for (const bool first : {true, false}) {
    for_each_brick([&](BrickCertifier& certifier, std::size_t slot) {
      if ((is_first[slot] != 0) != first) return;
      certifier.find_faces();
      for (std::size_t f = 0; f < fields.size(); ++f)
        certifier.bound(views[f], f, (1 + relative_gap) * largest[f], errors[f][slot]);
    });
    for (std::size_t f = 0; f < fields.size(); ++f)
      for (const BrickErrors& brick : errors[f]) largest[f] = std::max(largest[f], brick.attained);
  }

  Certificates certificates;
  std::size_t in_mesh = 0, uncovered = 0;
  for (const auto& [all, bare] : probe_counts) {
    in_mesh += all;
    uncovered += bare;
  }
  if (in_mesh > 0) certificates.uncovered_share = static_cast<double>(uncovered) / static_cast<double>(in_mesh);
  for (const auto& of_bricks : errors) {
    FieldErrors field;
    double sum_of_squares = 0;
    for (const BrickErrors& brick : of_bricks) {
      field.max.push_back(rounded_up(brick.bound));
      field.rms.push_back(brick.point_count == 0 ? 0 : std::sqrt(brick.sum_of_squares / brick.point_count));
      field.max_error = std::max(field.max_error, field.max.back());
      if (brick.attained > field.attained) {
        field.attained = brick.attained;
        field.attained_at = brick.attained_at;
      }
      sum_of_squares += brick.sum_of_squares;
      field.point_count += brick.point_count;
    }
    if (field.point_count > 0) field.rms_error = std::sqrt(sum_of_squares / static_cast<double>(field.point_count));
    certificates.fields.push_back(std::move(field));
  }
  return certificates;
}

}  // namespace rhoray::preprocess

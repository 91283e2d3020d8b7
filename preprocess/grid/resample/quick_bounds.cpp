#include "preprocess/grid/resample/quick_bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace rhoray::preprocess {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

bool lies_in_a_side(const std::array<Point, 3>& face, const SampleLattice& lattice) {
  for (std::size_t a = 0; a < 3; ++a)
    for (const double side : {lattice.places[a].front(), lattice.places[a].back()})
      if (face[0][a] == side && face[1][a] == side && face[2][a] == side) return true;
  return false;
}

}  // namespace

std::vector<std::uint8_t> find_open_faces(const CleanMesh& mesh, const FaceNeighbors& neighbors,
                                          const SampleLattice& lattice) {
  std::vector<std::uint8_t> open(mesh.cells.size(), 0);
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (neighbors.is_flat[c]) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      if (neighbors.cells[c][f] != FaceNeighbors::none) continue;
      std::array<Point, 3> face;
      for (std::size_t v = 0; v < 3; ++v) face[v] = mesh.points[mesh.cells[c][face_vertices[f][v]]];
      if (!lies_in_a_side(face, lattice)) open[c] |= static_cast<std::uint8_t>(1U << f);
    }
  }
  return open;
}

void QuickBounds::enter(const Point& first, std::span<const std::uint32_t> cells) {
  cells_ = cells;
  shapes_.resize(cells.size());
  open_blocks_ = 0;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const auto& cell = mesh_.cells[cells[n]];
    std::array<std::array<float, 4>, 3> points;
    for (std::size_t v = 0; v < 4; ++v)
      for (std::size_t a = 0; a < 3; ++a) points[a][v] = static_cast<float>(steps_[cell[v]][a] - first[a]);
    shapes_[n] = shape_of(points);
    shapes_[n].blocks = neighbors_.is_flat[cells[n]] ? 0 : blocks_of(shapes_[n]);
    if (open_faces_[cells[n]] != 0) open_blocks_ |= shapes_[n].blocks;
  }
}

/// Any direction on which the projections of a cell and a leaf cell are disjoint separates them.
/// The normals therefore need not be precise; only the projections' own rounding counts.
QuickBounds::Shape QuickBounds::shape_of(const std::array<std::array<float, 4>, 3>& points) {
  std::array<Four, 3> a, b;
  float farthest = 0;
  Shape shape;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& [p, q, r, s] = points[axis];
    a[axis] = Four{s - q, r - p, s - p, q - p};
    b[axis] = Four{r - q, s - p, q - p, r - p};
    const float low = smaller(smaller(p, q), smaller(r, s)), high = larger(larger(p, q), larger(r, s));
    farthest = larger(farthest, larger(-low, high));
    constexpr float margin = 1e-5F;
    shape.low[axis] = larger(smaller(low, 9.0F), -1.0F) - margin;
    shape.high[axis] = larger(smaller(high, 9.0F), -1.0F) + margin;
  }
  shape.x = a[1] * b[2] - a[2] * b[1];
  shape.y = a[2] * b[0] - a[0] * b[2];
  shape.z = a[0] * b[1] - a[1] * b[0];
  const auto magnitude = [](const Four& v) { return v < 0 ? -v : v; };
  const Four size = magnitude(shape.x) + magnitude(shape.y) + magnitude(shape.z);
  shape.reach = 0.5F * size;
  const auto along = [&](std::size_t v) {
    return shape.x * points[0][v] + shape.y * points[1][v] + shape.z * points[2][v];
  };
  Four lowest = along(0);
  for (std::size_t v = 1; v < 4; ++v) {
    const Four here = along(v);
    lowest = here < lowest ? here : lowest;
  }
  constexpr float rounding = 1e-6F;  // a dozen roundings of numbers up to size * (farthest + 8)
  shape.offset = size * (rounding * (farthest + 16)) - lowest;
  return shape;
}

/// The centres of the blocks on a row are at 1, 3, 5, 7.
std::uint64_t QuickBounds::blocks_of(const Shape& shape) {
  constexpr Four centers{1, 3, 5, 7};
  std::array<Four, 4> in_x;
  for (std::size_t f = 0; f < 4; ++f) in_x[f] = shape.x[f] * centers + (shape.offset[f] + 2 * shape.reach[f]);
  const FourBits in_box = (centers - 1 <= shape.high[0]) & (centers + 1 >= shape.low[0]);
  const auto first = [](float low) { return low <= 2 ? 0U : std::min(static_cast<unsigned>(low / 2), 4U); };
  const auto end = [](float high) { return high < 0 ? 0U : std::min(static_cast<unsigned>(high / 2) + 1, 4U); };
  std::uint64_t blocks = 0;
  for (unsigned k = first(shape.low[2]); k < end(shape.high[2]); ++k)
    for (unsigned j = first(shape.low[1]); j < end(shape.high[1]); ++j) {
      const Four rest = shape.y * static_cast<float>(2 * j + 1) + shape.z * static_cast<float>(2 * k + 1);
      const Four p = in_x[0] + rest[0], q = in_x[1] + rest[1], r = in_x[2] + rest[2], s = in_x[3] + rest[3];
      const FourBits touched = (p >= 0) & (q >= 0) & (r >= 0) & (s >= 0) & in_box & FourBits{1, 2, 4, 8};
      blocks |= static_cast<std::uint64_t>(touched[0] | touched[1] | touched[2] | touched[3]) << (16 * k + 4 * j);
    }
  return blocks;
}

std::uint8_t QuickBounds::leaf_cells_of(const Shape& shape, std::size_t block) {
  const auto [i, j, k] = place(block, 0);
  const Four x = static_cast<float>(i) + Four{0, 1, 0, 1}, y = static_cast<float>(j) + Four{0, 0, 1, 1};
  const FourBits in_box =
      (x <= shape.high[0]) & (x + 1 >= shape.low[0]) & (y <= shape.high[1]) & (y + 1 >= shape.low[1]);
  const auto z = static_cast<float>(k);
  std::array<Four, 4> heights;
  const Four start = shape.x * (static_cast<float>(i) + 0.5F) + shape.y * (static_cast<float>(j) + 0.5F) +
                     (shape.offset + shape.reach) + shape.z * (z + 0.5F);
  for (std::size_t f = 0; f < 4; ++f)
    heights[f] = start[f] + shape.x[f] * Four{0, 1, 0, 1} + shape.y[f] * Four{0, 0, 1, 1};
  std::uint32_t leaf_cells = 0;
  for (unsigned up = 0; up < 2; ++up) {
    const float bottom = z + static_cast<float>(up);
    if (bottom > shape.high[2] || bottom + 1 < shape.low[2]) continue;
    const float rise = static_cast<float>(up);
    const FourBits touched = (heights[0] + rise * shape.z[0] >= 0) & (heights[1] + rise * shape.z[1] >= 0) &
                             (heights[2] + rise * shape.z[2] >= 0) & (heights[3] + rise * shape.z[3] >= 0) & in_box &
                             FourBits{1, 2, 4, 8};
    leaf_cells |= static_cast<std::uint32_t>(touched[0] | touched[1] | touched[2] | touched[3]) << (4 * up);
  }
  return static_cast<std::uint8_t>(leaf_cells);
}

/// Relative to a base in double precision, so that the difference can be single. Bounds are widened
/// by more than rounding.
QuickBounds::Slope QuickBounds::slope_of(const Gradient& gradient, const Point& base, double unit) {
  Slope slope;
  bool is_known = gradient.has_values;
  for (std::size_t a = 0; a < 3; ++a) {
    const double off = (gradient.slope[a] - base[a]) / unit;
    const double error = gradient.error / unit + std::abs(off) * 0x1p-22 + 1e-30;
    is_known = is_known && std::abs(off) + error < 1e30;
    slope.low[a] = is_known ? static_cast<float>(off - error) : 0;
    slope.high[a] = is_known ? static_cast<float>(off + error) : 0;
  }
  if (is_known) return slope;
  slope.low.fill(-infinite);
  slope.high.fill(infinite);
  return slope;
}

template <std::size_t N>
void QuickBounds::clear(Ranges<N>& ranges) {
  for (std::size_t a = 0; a < 3; ++a) {
    ranges.low[a].fill(infinite);
    ranges.high[a].fill(-infinite);
  }
}

/// Includes the four lanes from `first` on whose bit is set.
template <std::size_t N>
void QuickBounds::include(const Slope& slope, std::uint32_t lanes, std::size_t first, Ranges<N>& ranges) {
  const auto bits = static_cast<std::int32_t>(lanes);
  const FourBits chosen = (FourBits{bits, bits, bits, bits} & FourBits{1, 2, 4, 8}) != 0;
  for (std::size_t a = 0; a < 3; ++a) {
    Four low, high;
    std::memcpy(&low, ranges.low[a].data() + first, sizeof low);
    std::memcpy(&high, ranges.high[a].data() + first, sizeof high);
    low = (chosen & (slope.low[a] < low)) != 0 ? slope.low[a] + Four{} : low;
    high = (chosen & (slope.high[a] > high)) != 0 ? slope.high[a] + Four{} : high;
    std::memcpy(ranges.low[a].data() + first, &low, sizeof low);
    std::memcpy(ranges.high[a].data() + first, &high, sizeof high);
  }
}

template <std::size_t N>
std::array<float, N> QuickBounds::bounds_of(const Ranges<N>& ranges) {
  std::array<float, N> bounds;
  for (std::size_t n = 0; n < N; ++n) {
    float sum = 0;
    for (std::size_t a = 0; a < 3; ++a) sum += ranges.high[a][n] - ranges.low[a][n];
    constexpr float quarter = 0.25F * (1 + 1e-5F);  // and more than rounding
    bounds[n] = sum > 0 ? quarter * sum : 0;
  }
  return bounds;
}

void QuickBounds::bound_blocks(const FieldView& field) {
  Point base{};
  for (const std::uint32_t c : cells_)
    if (field.gradients[c].error < std::numeric_limits<double>::infinity()) {
      base = field.gradients[c].slope;
      break;
    }
  slopes_.resize(cells_.size());
  clear(ranges_);
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    slopes_[n] = slope_of(field.gradients[cells_[n]], base, field.unit);
    for (std::uint64_t left = shapes_[n].blocks; left != 0;) {
      const auto row = static_cast<std::size_t>(std::countr_zero(left)) / 4;
      include(slopes_[n], static_cast<std::uint32_t>(left >> (4 * row) & 15), 4 * row, ranges_);
      left &= ~(std::uint64_t{15} << (4 * row));
    }
  }
  of_blocks_ = bounds_of(ranges_);
  for (std::uint64_t left = open_blocks_; left != 0; left &= left - 1)
    of_blocks_[static_cast<std::size_t>(std::countr_zero(left))] = infinite;
}

void QuickBounds::bound_cells(std::uint64_t blocks, BrickFaces& faces) {
  touches_.clear();
  for (std::uint64_t left = blocks; left != 0; left &= left - 1) {
    const auto block = static_cast<std::size_t>(std::countr_zero(left));
    clear(cell_ranges_[block]);
    last_touch_[block] = none;
  }
  for (std::size_t n = 0; n < cells_.size(); ++n)
    for (std::uint64_t left = shapes_[n].blocks & blocks; left != 0; left &= left - 1) {
      const auto block = static_cast<std::size_t>(std::countr_zero(left));
      const std::uint8_t leaf_cells = leaf_cells_of(shapes_[n], block);
      if (leaf_cells == 0) continue;
      include(slopes_[n], leaf_cells & 15U, 0, cell_ranges_[block]);
      include(slopes_[n], leaf_cells >> 4U, 4, cell_ranges_[block]);
      touches_.push_back({static_cast<std::uint32_t>(n), last_touch_[block], leaf_cells});
      last_touch_[block] = static_cast<std::uint32_t>(touches_.size() - 1);
    }
  for (std::uint64_t left = blocks; left != 0; left &= left - 1) {
    const auto block = static_cast<std::size_t>(std::countr_zero(left));
    of_cells_[block] = bounds_of(cell_ranges_[block]);
    for (std::uint32_t t = last_touch_[block]; t != none; t = touches_[t].previous)
      if (open_faces_[cells_[touches_[t].shape]] != 0)
        mark_open_faces(touches_[t].shape, block, touches_[t].leaf_cells, faces);
  }
}

void QuickBounds::mark_open_faces(std::size_t n, std::size_t block, std::uint8_t leaf_cells, BrickFaces& faces) {
  for (std::size_t f = 0; f < 4; ++f) {
    if ((open_faces_[cells_[n]] >> f & 1) == 0) continue;
    const BrickFace& face = faces.at(n, f);
    for (std::size_t cell = 0; cell < 8; ++cell) {
      const auto [i, j, k] = place(block, cell);
      const Point center{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5};
      if ((leaf_cells >> cell & 1) != 0 && face.may_touch(center)) of_cells_[block][cell] = infinite;
    }
  }
}

}  // namespace rhoray::preprocess

#include "preprocess/mesh/subdivide/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rhoray::preprocess {

Comparison::Comparison(CellMesh& mesh, std::span<const CurvedCell> cells, const std::vector<bool>& counted)
    : mesh_(mesh), cells_(cells) {
  for (const CurvedCell& cell : cells) most_nodes_ = std::max(most_nodes_, cell.shape->node_count());
  measure_box();
  for (std::size_t f = 0; f < mesh.point_fields.size(); ++f) {
    const NeutralField& field = mesh.point_fields[f];
    sample_size_ += static_cast<std::size_t>(field.component_count);
    ranges_.push_back(counted[f] ? range_of(field) : 0);
  }
}

void Comparison::sample_cell(std::uint32_t curved_cell, const CellPlace& place, std::span<double> weights,
                             Sample& out) const {
  const CurvedCell& cell = cells_[curved_cell];
  const std::size_t count = cell.shape->node_count();
  cell.shape->at(place, weights.first(count));
  out.assign(sample_size_, 0);
  const std::uint64_t* nodes = mesh_.cell_nodes.data() + mesh_.cell_offsets[cell.cell];
  for (std::size_t n = 0; n < count; ++n)
    if (weights[n] != 0) add(nodes[n], weights[n], out);
}

void Comparison::raise(const Sample& a, const Sample& b, double factor, Shares& largest) const {
  const auto raise_to = [&](double& share, double found) {
    if (found > share) share = found;
  };
  if (diagonal_ > 0) raise_to(largest[0], factor * std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / diagonal_);
  std::size_t at = 3;
  for (std::size_t f = 0; f < ranges_.size(); ++f)
    for (int c = 0; c < mesh_.point_fields[f].component_count; ++c, ++at)
      if (ranges_[f] > 0 && std::abs(a[at] - b[at]) <= std::numeric_limits<double>::max())
        raise_to(largest[1 + f], factor * std::abs(a[at] - b[at]) / ranges_[f]);
}

void Comparison::store(const Sample& sample, std::uint64_t point) {
  std::copy_n(sample.begin(), 3, mesh_.points[point].begin());
  std::size_t at = 3;
  for (NeutralField& field : mesh_.point_fields) {
    const auto components = static_cast<std::size_t>(field.component_count);
    for (std::size_t c = 0; c < components; ++c, ++at) field.values[point * components + c] = sample[at];
  }
}

void Comparison::add(std::uint64_t point, double weight, Sample& out) const {
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] += weight * mesh_.points[point][axis];
  std::size_t at = 3;
  for (const NeutralField& field : mesh_.point_fields) {
    const auto components = static_cast<std::size_t>(field.component_count);
    for (std::size_t c = 0; c < components; ++c) out[at++] += weight * field.values[point * components + c];
  }
}

void Comparison::measure_box() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  for (std::size_t c = 0; c < mesh_.kinds.size(); ++c) {
    // a stream with counts; other cells cover the box well enough
    if (mesh_.kinds[c] == CellKind::polyhedron) continue;
    for (std::uint64_t i = mesh_.cell_offsets[c]; i < mesh_.cell_offsets[c + 1]; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = mesh_.points[mesh_.cell_nodes[i]][axis];
        if (!std::isfinite(x)) continue;
        low[axis] = std::min(low[axis], x);
        high[axis] = std::max(high[axis], x);
      }
  }
  diagonal_ = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

/// The largest range of its components, so that a component of rounding errors alone does not count
/// by itself.
double Comparison::range_of(const NeutralField& field) const {
  const auto components = static_cast<std::size_t>(field.component_count);
  double largest = 0;
  for (std::size_t c = 0; c < components; ++c) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = c; i < field.values.size(); i += components) {
      if (!std::isfinite(field.values[i])) continue;
      low = std::min(low, field.values[i]);
      high = std::max(high, field.values[i]);
    }
    largest = std::max(largest, high - low);
  }
  return largest;
}

}  // namespace rhoray::preprocess

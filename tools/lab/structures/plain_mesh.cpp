#include "tools/lab/structures/plain_mesh.h"

#include <cmath>
#include <limits>

namespace rhoray::study {

PlainMesh::PlainMesh(const formats::TetMesh& packed) : points_(packed.points()), values_(packed.values<float>(0)) {
  const std::uint64_t count = packed.description().cell_count;
  cells_.reserve(count);
  ids_.reserve(count);
  for (std::uint64_t cell = 0; cell < count; ++cell) {
    cells_.push_back(packed.cell(cell));
    ids_.push_back(static_cast<std::uint32_t>(packed.cell_id(cell)));
  }
}

PlainMesh PlainMesh::reordered(std::span<const std::uint32_t> order) const {
  RHORAY_CHECK(order.size() == cells_.size());
  PlainMesh other = *this;
  for (std::size_t n = 0; n < order.size(); ++n) {
    other.cells_[n] = cells_[order[n]];
    other.ids_[n] = ids_[order[n]];
  }
  return other;
}

Interval<float> PlainMesh::range(std::uint32_t cell) const {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Interval<float> range{infinity, -infinity};
  for (const std::uint32_t v : cells_[cell]) {
    if (!std::isfinite(values_[v])) return {infinity, -infinity};
    range = {std::min(range.lo, values_[v]), std::max(range.hi, values_[v])};
  }
  return range;
}

Box3 PlainMesh::box(std::uint32_t cell) const {
  Box3 box;
  for (const std::uint32_t v : cells_[cell]) box.extendBy(Vec3(points_[v][0], points_[v][1], points_[v][2]));
  return box;
}

Vec3 PlainMesh::center(std::uint32_t cell) const {
  Vec3 sum(0);
  for (const std::uint32_t v : cells_[cell]) sum += Vec3(points_[v][0], points_[v][1], points_[v][2]);
  return sum / 4;
}

Box3 PlainMesh::bounds() const {
  Box3 bounds;
  for (const auto& point : points_) bounds.extendBy(Vec3(point[0], point[1], point[2]));
  return bounds;
}

}  // namespace rhoray::study

#include "preprocess/mesh/subdivide/spread_points.h"

#include <algorithm>
#include <map>
#include <utility>

#include "preprocess/mesh/subdivide/cell_kinds.h"

namespace rhoray::preprocess {

CellPlace SpreadPoints::SpreadPoint::nearest_to(const CellPlace& other) const {
  CellPlace low = corners[0], high = corners[0];
  for (const CellPlace& corner : corners)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], corner[axis]);
      high[axis] = std::max(high[axis], corner[axis]);
    }
  CellPlace nearest;
  if (corners.size() == 2) {
    double along = 0, length2 = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double step = corners[1][axis] - corners[0][axis];
      along += step * (other[axis] - corners[0][axis]);
      length2 += step * step;
    }
    const double t = std::clamp(along / length2, 0.0, 1.0);
    for (std::size_t axis = 0; axis < 3; ++axis) nearest[axis] = (1 - t) * corners[0][axis] + t * corners[1][axis];
  } else {
    for (std::size_t axis = 0; axis < 3; ++axis) nearest[axis] = std::clamp(other[axis], low[axis], high[axis]);
  }
  return nearest;
}

SpreadPoints::SpreadPoints(const CellMesh& mesh, std::span<const CurvedCell> cells) {
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    const CurvedCell& cell = cells[c];
    const std::size_t corner_count = frame_of(description_of(mesh.kinds[cell.cell]).corners).corner_count;
    std::map<std::uint64_t, std::vector<CellPlace>> places;
    for (std::size_t i = 0; i < corner_count; ++i)
      places[mesh.cell_nodes[mesh.cell_offsets[cell.cell] + i]].push_back(cell.shape->node_places()[i]);
    if (places.size() == corner_count) continue;
    for (auto& [point, corners] : places)
      if (corners.size() > 1) of_cells_[c].push_back({static_cast<std::uint32_t>(point), std::move(corners)});
  }
}

void SpreadPoints::settle(std::uint32_t curved_cell, std::uint32_t a, FinePlace& at_a, std::uint32_t b,
                          FinePlace& at_b) const {
  if (of_cells_.empty()) return;
  move(curved_cell, a, at_a, at_b);
  move(curved_cell, b, at_b, at_a);
  move(curved_cell, a, at_a, at_b);
}

void SpreadPoints::add_middle(std::uint32_t curved_cell, std::uint32_t a, std::uint32_t b, std::uint32_t point) {
  const SpreadPoint *at_a = find(curved_cell, a), *at_b = find(curved_cell, b);
  if (at_a == nullptr || at_b == nullptr || find(curved_cell, point) != nullptr) return;
  SpreadPoint between{point, {}};
  for (const CellPlace& corner : at_a->corners) {
    const CellPlace other = at_b->nearest_to(corner);
    between.corners.push_back({(corner[0] + other[0]) / 2, (corner[1] + other[1]) / 2, (corner[2] + other[2]) / 2});
  }
  of_cells_[curved_cell].push_back(std::move(between));
}

void SpreadPoints::move(std::uint32_t curved_cell, std::uint32_t point, FinePlace& place,
                        const FinePlace& other) const {
  if (const SpreadPoint* spread = find(curved_cell, point)) place = fine(spread->nearest_to(coarse(other)));
}

const SpreadPoints::SpreadPoint* SpreadPoints::find(std::uint32_t curved_cell, std::uint32_t point) const {
  const auto of_cell = of_cells_.find(curved_cell);
  if (of_cell == of_cells_.end()) return nullptr;
  for (const SpreadPoint& spread : of_cell->second)
    if (spread.point == point) return &spread;
  return nullptr;
}

}  // namespace rhoray::preprocess

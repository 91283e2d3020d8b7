#include "preprocess/unpack_mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/stopping.h"

namespace rhoray::preprocess {
namespace {

using formats::TetMesh;

/// Returns the indices of points in the packed mesh, in the source's order.
Array<std::uint32_t> points_in_source_order(const TetMesh& packed, const std::stop_token& stop) {
  const std::size_t count = packed.points().size();
  Array<std::uint32_t> order(count);
  for_each_until_stopped(0, count, light_piece, stop,
                         [&](std::uint64_t p) { order[packed.point_rank(p)] = static_cast<std::uint32_t>(p); });
  for_each_until_stopped(0, count, light_piece, stop, [&](std::uint64_t p) {
    if (order[packed.point_rank(p)] != p)
      throw Error(ErrorCode::invalid, concat(packed.file().name(), ", array 'point_ranks', element ", p, ": found ",
                                             packed.point_rank(p), " twice; expected it once"));
  });
  return order;
}

Array<std::uint32_t> cells_in_source_order(const TetMesh& packed, const std::stop_token& stop) {
  Array<std::uint32_t> order(packed.description().cell_count);
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    end_if_stopped(stop);
    return packed.cell_id(a) < packed.cell_id(b);
  });
  return order;
}

template <class T>
Array<double> taken_from(std::span<const T> values, const Array<std::uint32_t>& order, const Watch& watch) {
  ProgressMeter meter(watch.progress, "copying a field (values)", order.size());
  Array<double> taken(order.size());
  for_each_until_stopped(
      0, order.size(), light_piece, watch.stop,
      [&](std::uint64_t i) { taken[i] = static_cast<double>(values[order[i]]); }, &meter);
  return taken;
}

/// @param take  the values, of the type of its argument
template <class Take>
NeutralField unpacked(const formats::FieldSummary& summary, const Take& take) {
  const bool is_single = summary.type == formats::ElementType::F32;
  return {.name = summary.name,
          .unit = summary.unit,
          .component_count = 1,
          .was_single_precision = is_single,
          .values = is_single ? take(float()) : take(double()),
          .label_names = summary.label_names};
}

}  // namespace

NeutralMesh unpack_mesh(const TetMesh& packed, const Watch& watch) {
  const formats::TetMeshDescription& description = packed.description();
  NeutralMesh mesh;
  mesh.length_unit = description.length_unit;
  const Array<std::uint32_t> points = points_in_source_order(packed, watch.stop);
  mesh.points.reserve(points.size());
  const auto copy_point = [&](std::uint64_t i) {
    const auto& p = packed.points()[points[i]];
    mesh.points.push_back({description.origin.x + p[0], description.origin.y + p[1], description.origin.z + p[2]});
  };
  ProgressMeter copying_points(watch.progress, "copying (points)", points.size());
  for_each_until_stopped(0, points.size(), light_piece, watch.stop, copy_point, &copying_points);
  const Array<std::uint32_t> cells = cells_in_source_order(packed, watch.stop);
  mesh.cells.reserve(cells.size());
  mesh.cell_ids.reserve(cells.size());
  const auto copy_cell = [&](std::uint64_t i) {
    const auto cell = packed.cell(cells[i]);
    mesh.cell_ids.push_back(packed.cell_id(cells[i]));
    mesh.cells.push_back({packed.point_rank(cell[0]), packed.point_rank(cell[1]), packed.point_rank(cell[2]),
                          packed.point_rank(cell[3])});
  };
  ProgressMeter copying_cells(watch.progress, "copying (cells)", cells.size());
  for_each_until_stopped(0, cells.size(), light_piece, watch.stop, copy_cell, &copying_cells);
  for (std::size_t f = 0; f < description.fields.size(); ++f)
    mesh.point_fields.push_back(
        unpacked(description.fields[f], [&]<class T>(T) { return taken_from(packed.values<T>(f), points, watch); }));
  for (std::size_t f = 0; f < description.cell_fields.size(); ++f)
    mesh.cell_fields.push_back(unpacked(
        description.cell_fields[f], [&]<class T>(T) { return taken_from(packed.cell_values<T>(f), cells, watch); }));
  return mesh;
}

}  // namespace rhoray::preprocess

#include "render/point_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include "formats/base/checks.h"
#include "formats/base/floating_point.h"
#include "formats/base/stopping.h"
#include "formats/intact.h"
#include "render/dataset/loaded_dataset.h"
#include "render/shade/place_lookup.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = PlacesInPlane::size;

/// Spreads the lowest 21 bits of a number: three zeros between neighbours make room for two others.
std::uint64_t spread_bits(std::uint64_t bits) {
  bits &= 0x1fffff;
  for (const auto& [shift, mask] : {std::pair<int, std::uint64_t>{32, 0x1f00000000ffff},
                                    {16, 0x1f0000ff0000ff},
                                    {8, 0x100f00f00f00f00f},
                                    {4, 0x10c30c30c30c30c3},
                                    {2, 0x1249249249249249}})
    bits = (bits | bits << shift) & mask;
  return bits;
}

/// An order in which neighbours are close to each other (a Morton curve): cells are looked up for
/// 64 points at a time.
std::vector<std::size_t> order_of(std::span<const Vec3> points, const Box3& box) {
  std::vector<std::uint64_t> codes(points.size());
  const Vec3 size = box.size();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double share = size[axis] > 0 ? (points[i][axis] - box.min[axis]) / size[axis] : 0;
      const auto step = static_cast<std::uint64_t>(std::clamp(share, 0.0, 1.0) * 0x1fffff);
      codes[i] |= spread_bits(step) << axis;
    }
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return codes[a] < codes[b]; });
  return order;
}

/// Bound on the error of a component of data_from_world.point(p) for a point of a box.
double rounding_in(const Box3& box_world, const Affine& data_from_world, int axis) {
  double sum = std::abs(data_from_world.origin[axis]);
  const Vec3* const axes[] = {&data_from_world.x_axis, &data_from_world.y_axis, &data_from_world.z_axis};
  for (int a = 0; a < 3; ++a)
    sum += std::abs((*axes[a])[axis]) * std::max(std::abs(box_world.min[a]), std::abs(box_world.max[a]));
  return 0x1p-49 * sum;  // 16 half units in the last place: the inverse map itself is rounded, too
}

}  // namespace

void point_values(const Dataset& dataset, std::span<const Vec3> points, std::span<PointValue> values,
                  const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  RHORAY_CHECK(points.size() == values.size());
  const LoadedDataset& loaded = dataset.implementation();
  const PlaceLookup look_up(loaded);
  const Affine data_from_world = loaded.world_from_data.inverse();
  std::vector<Vec3> in_data(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) in_data[i] = data_from_world.point(points[i]);
  const std::vector<std::size_t> order = order_of(in_data, loaded.bounds_data);
  const auto places = std::make_unique<PlacesInPlane>();
  const auto answers = std::make_unique<PlaceAnswers>();
  // A normal of length 0: no point is outside the plane.
  places->normal = Vec3(0, 0, 0), places->offset = 0;
  const Box3 bounds = dataset.bounds();
  for (int axis = 0; axis < 3; ++axis)
    places->slack[static_cast<std::size_t>(axis)] = rounding_in(bounds, data_from_world, axis);
  ProgressMeter meter(watch.progress, "evaluating (points)", order.size());
  for (std::size_t first = 0; first < order.size(); first += group_size) {
    end_if_stopped(watch.stop);
    const std::size_t count = std::min(group_size, order.size() - first);
    for (std::size_t i = 0; i < group_size; ++i) {
      places->is_asked[i] = i < count;
      const std::size_t point = order[first + std::min(i, count - 1)];
      for (int axis = 0; axis < 3; ++axis) places->at[axis][i] = in_data[point][axis];
    }
    look_up(*places, *answers);
    for (std::size_t i = 0; i < count; ++i)
      values[order[first + i]] = {answers->value[i],
                                  std::isnan(answers->value[i]) ? PointValue::no_cell : answers->cell[i]};
    meter.add(count);
  }
  formats::require_intact(dataset.file());
}

}  // namespace rhoray::render

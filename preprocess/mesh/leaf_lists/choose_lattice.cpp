#include "preprocess/mesh/leaf_lists/choose_lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "formats/base/error.h"
#include "preprocess/values/choose_shape.h"

namespace rhoray::preprocess {
namespace {

constexpr double largest_leaf_count = 0x1p31;
// rounding then stays far below the margin of the overlap test
constexpr double largest_axis_count = 0x1p20;

/// Returns the edge of a cube such that `wanted` cubes fill the box, where an axis shorter than the
/// edge still takes one cube.
double cube_edge(const Vec3& extent, double wanted) {
  Vec3 sorted = extent;
  if (sorted.x > sorted.y) std::swap(sorted.x, sorted.y);
  if (sorted.y > sorted.z) std::swap(sorted.y, sorted.z);
  if (sorted.x > sorted.y) std::swap(sorted.x, sorted.y);
  const double in_space = std::cbrt(sorted.x / wanted) * std::cbrt(sorted.y) * std::cbrt(sorted.z);
  if (in_space <= sorted.x) return in_space;
  const double in_plane = std::sqrt(sorted.y / wanted) * std::sqrt(sorted.z);
  if (in_plane <= sorted.y) return in_plane;
  return sorted.z / wanted;
}

}  // namespace

formats::LeafLattice choose_lattice(const Box3& box, const LeafLatticeRequest& request) {
  // NaN is refused too
  if (!(request.leaf_cell_count >= 1 && request.leaf_cell_count <= largest_leaf_count))
    throw Error(ErrorCode::usage, concat("leaf cells: found ", request.leaf_cell_count, "; expected 1 to ",
                                         static_cast<std::uint64_t>(largest_leaf_count)));
  const Vec3 extent = box.max - box.min;
  const double edge = cube_edge(extent, request.leaf_cell_count);

  formats::LeafLattice lattice;
  Index3 count;
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double margin = 0x1p-10;
    const double leaves = std::clamp(std::round(extent[axis] / edge), 1.0, largest_axis_count);
    count[axis] = static_cast<std::int64_t>(leaves);
    lattice.leaf_size[axis] = extent[axis] / (leaves - 2 * margin);
    lattice.low[axis] = box.min[axis] - margin * lattice.leaf_size[axis];
  }
  lattice.macro = choose_macro_shape(count, request.macro_factor, request.macro_level_count);
  return lattice;
}

}  // namespace rhoray::preprocess

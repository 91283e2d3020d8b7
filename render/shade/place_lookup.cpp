#include "render/shade/place_lookup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/query/compiled_for.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = PlacesInPlane::size;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

// Grids.

/// The cells of an axis that contain a position: one, or two if it lies in the plane between them,
/// up to slack.
struct CellsOfAxis {
  std::int64_t cell[2];
  int count = 0;
};

template <class Grid>
CellsOfAxis cells_of_axis(const Grid& grid, int axis, double position, double slack) {
  const auto planes = grid.geometry().planes();
  const std::int64_t cell_count = grid.lattice().leaf_count[axis];
  CellsOfAxis cells;
  if (!(position >= planes.position(axis, 0) - slack && position <= planes.position(axis, cell_count) + slack))
    return cells;
  const double in_planes = std::floor(planes.in_planes(axis, position, 0, cell_count));
  const auto cell = static_cast<std::int64_t>(std::clamp(in_planes, 0.0, static_cast<double>(cell_count - 1)));
  cells.cell[cells.count++] = cell;
  if (cell > 0 && position <= planes.position(axis, cell) + slack)
    cells.cell[cells.count++] = cell - 1;
  else if (cell + 1 < cell_count && position >= planes.position(axis, cell + 1) - slack)
    cells.cell[cells.count++] = cell + 1;
  return cells;
}

template <class Grid>
void look_up_one(const Grid& grid, const PlacesInPlane& places, std::size_t i, PlaceAnswers& answers) {
  CellsOfAxis cells[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    cells[a] = cells_of_axis(grid, axis, places.at[a][i], places.slack[a]);
    if (cells[a].count == 0) return;
  }
  for (int k = 0; k < cells[2].count; ++k)
    for (int j = 0; j < cells[1].count; ++j)
      for (int h = 0; h < cells[0].count; ++h) {
        const Index3 cell(cells[0].cell[h], cells[1].cell[j], cells[2].cell[k]);
        const TrilinearCell corners = grid.cell(cell);
        ++answers.cost[i];
        if (!grid.has_data(corners)) continue;
        Vec3 inside;
        for (int axis = 0; axis < 3; ++axis)
          inside[axis] = std::clamp(grid.geometry().in_cell(axis, places.at[axis][i], cell[axis]), 0.0, 1.0);
        answers.value[i] = corners.at(inside);
        answers.cell[i] = grid.cell_id(cell);
        return;
      }
}

template <class Grid>
void look_up_in_grid(const Grid& grid, const PlacesInPlane& places, PlaceAnswers& answers) {
  for (std::size_t i = 0; i < group_size; ++i)
    if (places.is_asked[i]) look_up_one(grid, places, i, answers);
}

// Meshes.

/// Bounding box of a group's positions that are looked up, and their distance from the plane.
struct Around {
  double low[3], high[3];
  double from_plane;  ///< bound on the error of normal . position
  double slack;       ///< the largest of the axes' slacks
};

Around around(const PlacesInPlane& places) {
  Around box{.low = {infinity, infinity, infinity},
             .high = {-infinity, -infinity, -infinity},
             .from_plane = 0,
             .slack = std::max({places.slack[0], places.slack[1], places.slack[2]})};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < group_size; ++i) {
      if (!places.is_asked[i]) continue;
      box.low[axis] = std::min(box.low[axis], places.at[axis][i]);
      box.high[axis] = std::max(box.high[axis], places.at[axis][i]);
    }
    box.low[axis] -= places.slack[axis], box.high[axis] += places.slack[axis];
    box.from_plane += 2 * std::abs(places.normal[static_cast<int>(axis)]) * box.slack;
  }
  return box;
}

/// False if a box certainly contains none of the positions.
bool may_hold(const PlacesInPlane& places, const Around& box, const double (&low)[3], const double (&high)[3]) {
  double least = -places.offset - box.from_plane, most = -places.offset + box.from_plane;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(low[axis] <= box.high[axis] && high[axis] >= box.low[axis])) return false;
    const double normal = places.normal[static_cast<int>(axis)];
    const double at_low = normal * low[axis], at_high = normal * high[axis];
    least += std::min(at_low, at_high), most += std::max(at_low, at_high);
  }
  return least <= 0 && most >= 0;
}

/// Distance from a face's plane, positive on the side of its cell. It is computed from the face's
/// points in ascending order, so that both cells of the face compute the same number up to sign.
struct FaceDistance {
  double anchor[3], normal[3];
};

/// The faces of a tetrahedron.
struct TetPlanes {
  FaceDistance face[4];  ///< opposite to each point
  double height[4];      ///< of each point above its face
};

/// @return  false for a cell without volume
RHORAY_INLINE bool find_planes(const std::array<std::array<double, 3>, 4>& points, TetPlanes& planes) {
  for (std::size_t k = 0; k < 4; ++k) {
    const std::array<double, 3>&a = points[k == 0 ? 1 : 0], &b = points[k <= 1 ? 2 : 1], &c = points[k <= 2 ? 3 : 2];
    const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (double& component : n) component /= length;
    const double height = n[0] * (points[k][0] - a[0]) + n[1] * (points[k][1] - a[1]) + n[2] * (points[k][2] - a[2]);
    const double side = height < 0 ? -1 : 1;
    planes.height[k] = side * height;
    if (!(planes.height[k] > 0 && planes.height[k] < infinity)) return false;
    planes.face[k] = {{a[0], a[1], a[2]}, {side * n[0], side * n[1], side * n[2]}};
  }
  return true;
}

/// The cell found so far for each position.
struct Holders {
  alignas(64) double outside[group_size];  ///< distance outside that cell; 0: inside
  std::uint64_t id[group_size];
  std::uint32_t tet[group_size];
};

/// Updates the positions that a cell contains better than all cells before it.
RHORAY_INLINE void hold_against(const TetData& view, const PlacesInPlane& places, const Around& box, std::uint32_t tet,
                                Holders& holders, PlaceAnswers& answers) {
  const auto vertices = view.sorted_vertices(tet);
  const auto points = view.points_at(vertices);
  double low[3], high[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::minmax({points[0][axis], points[1][axis], points[2][axis], points[3][axis]});
    low[axis] = least, high[axis] = most;
  }
  TetPlanes planes{};
  if (!may_hold(places, box, low, high) || !has_data(view.values_at(vertices)) || !find_planes(points, planes)) return;
  alignas(64) double outside[group_size];
  for (std::size_t i = 0; i < group_size; ++i) {
    const double x = places.at[0][i], y = places.at[1][i], z = places.at[2][i];
    double most = 0;
    for (const FaceDistance& face : planes.face) {
      const double away = -(face.normal[0] * (x - face.anchor[0]) + face.normal[1] * (y - face.anchor[1]) +
                            face.normal[2] * (z - face.anchor[2]));
      most = away > most ? away : most;
    }
    outside[i] = most;
  }
  const std::uint64_t id = view.cell_id(tet);
  for (std::size_t i = 0; i < group_size; ++i) {
    if (!(outside[i] <= holders.outside[i]) || !places.is_asked[i]) continue;
    ++answers.cost[i];
    const bool is_tie = outside[i] == holders.outside[i];
    if (is_tie && (id > holders.id[i] || (id == holders.id[i] && tet >= holders.tet[i]))) continue;
    holders.outside[i] = outside[i], holders.id[i] = id, holders.tet[i] = tet;
  }
}

/// Calls visit(cell) for the cells of clusters that may contain positions of the group.
template <class Visit>
RHORAY_INLINE void for_each_in_clusters(const TetData& view, const PlacesInPlane& places, const Around& box,
                                        const Visit& visit) {
  constexpr std::size_t width = formats::ClusterShape::width, most_levels = 11;
  struct Entry {
    std::uint64_t block;
    int level;
  };
  const formats::CellClustersView& clusters = view.clusters();
  std::array<Entry, most_levels * width> stack;
  std::size_t top = 0;
  stack[top++] = {0, clusters.shape.top_level()};
  while (top != 0) {
    const Entry entry = stack[--top];
    const formats::BoxBlock& block = clusters.boxes[static_cast<std::size_t>(entry.level)][entry.block];
    for (std::size_t e = 0; e < width; ++e) {
      double low[3], high[3];
      for (std::size_t axis = 0; axis < 3; ++axis)
        low[axis] = static_cast<double>(block.lo[axis][e]) * clusters.box_unit,
        high[axis] = static_cast<double>(block.hi[axis][e]) * clusters.box_unit;
      if (!may_hold(places, box, low, high)) continue;
      const std::uint64_t below = entry.block * width + e;
      if (entry.level > 0)
        stack[top++] = {below, entry.level - 1};
      else
        for (std::uint64_t tet = clusters.first_cell(below); tet < clusters.end_cell(below); ++tet)
          visit(static_cast<std::uint32_t>(tet));
    }
  }
}

/// The same for the cells that leaves list. A cell comes up once for every leaf that lists it.
template <class Visit>
RHORAY_INLINE void for_each_in_leaves(const TetData& view, const PlacesInPlane& places, const Around& box,
                                      const Visit& visit) {
  const formats::LeafLattice& lattice = view.description().lattice;
  const Index3 count = view.lattice().leaf_count;
  Index3 first, last;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    constexpr double rounding = 1e-9;  // in leaves
    const auto leaf_at = [&](double position, double more) {
      const double leaf = std::floor((position - lattice.low[axis]) / lattice.leaf_size[axis] + more);
      return static_cast<std::int64_t>(std::clamp(leaf, 0.0, static_cast<double>(count[axis] - 1)));
    };
    first[axis] = leaf_at(box.low[a], -rounding), last[axis] = leaf_at(box.high[a], rounding);
  }
  for (std::int64_t z = first.z; z <= last.z; ++z)
    for (std::int64_t y = first.y; y <= last.y; ++y)
      for (std::int64_t x = first.x; x <= last.x; ++x) {
        const Index3 leaf(x, y, z);
        double low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          const double size = lattice.leaf_size[axis];
          low[a] = lattice.low[axis] + static_cast<double>(leaf[axis]) * size - 1e-9 * size;
          high[a] = low[a] + (1 + 2e-9) * size;
        }
        if (!may_hold(places, box, low, high)) continue;
        for (const std::uint32_t tet : view.tetrahedra_at(leaf)) visit(tet);
      }
}

/// The linear field at a position of a cell, moved into the cell where rounding has put it outside.
RHORAY_INLINE double value_in(const TetData& view, std::uint32_t tet, const Vec3& place) {
  const auto vertices = view.sorted_vertices(tet);
  TetPlanes planes{};
  find_planes(view.points_at(vertices), planes);
  const std::array<double, 4> values = view.values_at(vertices);
  double sum = 0, weights = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const FaceDistance& face = planes.face[k];
    const double above = face.normal[0] * (place.x - face.anchor[0]) + face.normal[1] * (place.y - face.anchor[1]) +
                         face.normal[2] * (place.z - face.anchor[2]);
    const double weight = above > 0 ? above / planes.height[k] : 0;
    sum += weight * (values[k] - values[0]);
    weights += weight;
  }
  return values[0] + sum / weights;
}

RHORAY_INLINE void look_up_in_mesh(const TetData& view, const PlacesInPlane& places, PlaceAnswers& answers) {
  const Around box = around(places);
  Holders holders;
  std::fill_n(holders.outside, group_size, 2 * box.slack);
  std::fill_n(holders.id, group_size, std::numeric_limits<std::uint64_t>::max());
  std::fill_n(holders.tet, group_size, 0U);
  const auto visit = [&](std::uint32_t tet) __attribute__((always_inline)) {
    hold_against(view, places, box, tet, holders, answers);
  };
  if (view.has_clusters())
    for_each_in_clusters(view, places, box, visit);
  else
    for_each_in_leaves(view, places, box, visit);
  for (std::size_t i = 0; i < group_size; ++i) {
    if (holders.id[i] == std::numeric_limits<std::uint64_t>::max()) continue;
    answers.value[i] = value_in(view, holders.tet[i], {places.at[0][i], places.at[1][i], places.at[2][i]});
    answers.cell[i] = holders.id[i];
    answers.tet[i] = holders.tet[i];
  }
}

// Choice of the lookup.

using LookUp = std::function<void(const PlacesInPlane& places, PlaceAnswers& answers)>;

/// @param function  (view, places, answers)
template <class View, class Function>
LookUp answered_by(const View& view, Function function) {
  return [&view, function](const PlacesInPlane& places, PlaceAnswers& answers) {
    std::fill_n(answers.value, group_size, no_value);
    std::fill_n(answers.cost, group_size, 0U);
    function(view, places, answers);
  };
}

/// Positions are looked up one by one, because no machine makes it faster.
template <class Grid>
LookUp look_up_for(const Grid& grid, const LoadedDataset&, Machine) {
  return answered_by(grid, look_up_in_grid<Grid>);
}
LookUp look_up_for(const TetData& mesh, const LoadedDataset&, Machine machine) {
  return answered_by(mesh, compiled_for<look_up_in_mesh>(machine));
}
LookUp look_up_for(const TriangleData&, const LoadedDataset& dataset, Machine) {
  throw Error(ErrorCode::usage, concat(dataset.file.name(), ": a surface has no field to be sliced"));
}

}  // namespace

PlaceLookup::PlaceLookup(const LoadedDataset& dataset, Machine machine)
    : look_up_(std::visit([&](const auto& view) { return look_up_for(view, dataset, machine); }, dataset.view)) {}

}  // namespace rhoray::render

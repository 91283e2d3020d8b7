#include "render/shade/hit_lookup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/cell/triangle_crossing.h"
#include "render/dataset/load_view.h"
#include "render/grid/smooth_gradient.h"
#include "render/query/compiled_for.h"
#include "render/triangles/corner_normals.h"
#include "render/triangles/point_gradients.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// One number for each hit of a group.
struct alignas(64) Numbers {
  double of[group_size];

  RHORAY_INLINE double& operator[](std::size_t i) { return of[i]; }
  RHORAY_INLINE double operator[](std::size_t i) const { return of[i]; }
};

/// Positions of a group's hits in the data's frame.
RHORAY_INLINE void find_places(const RayBatch& rays, const HitBatch& hits, std::size_t first, Numbers* place) {
  const double* t = hits.t.data() + first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double *origin = rays.origin[axis].data() + first, *direction = rays.direction[axis].data() + first;
    for (std::size_t i = 0; i < group_size; ++i) place[axis][i] = origin[i] + t[i] * direction[i];
  }
}

// Meshes.

/// One value in each cell of a mesh.
struct CellValues {
  std::span<const float> floats{};  ///< one of these two is empty
  std::span<const double> doubles{};

  RHORAY_INLINE double operator[](std::uint32_t cell) const {
    return doubles.empty() ? static_cast<double>(floats[cell]) : doubles[cell];
  }
};

/// Data looked up in a mesh besides its own field.
struct MeshLookup {
  const TetData* view;
  std::shared_ptr<const PointGradients> gradients{};  ///< null: not needed
  std::optional<TetData> field{};                     ///< at most one of these two
  std::optional<CellValues> cell_field{};
  std::span<const std::uint32_t> cells{};  ///< of the boundary's triangles; empty: hits name cells
};

/// The cells of a group's hits: their points and weights.
struct HitCells {
  std::uint32_t cell[group_size];
  std::uint32_t point[4][group_size];
  Numbers weight[4];
};

/// Six times the volume of the tetrahedron between three points and the origin.
RHORAY_INLINE double six_volumes(const double* a, const double* b, const double* c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// Computes weights from the volumes between a position and the faces of its cell. No weight is
/// negative. A tiny amount is added to all, so that a cell without volume gives all its points the
/// same weight.
/// @param away  [point][axis][hit]: from the position to the cell's points
RHORAY_INLINE void weigh_by_volumes(const Numbers (*away)[3], Numbers* weight) {
  constexpr double least = 0x1p-60;
  for (std::size_t i = 0; i < group_size; ++i) {
    double p[4][3], share[4];
    for (int k = 0; k < 4; ++k)
      for (int axis = 0; axis < 3; ++axis) p[k][axis] = away[k][axis][i];
    share[0] = six_volumes(p[1], p[2], p[3]), share[1] = -six_volumes(p[0], p[2], p[3]);
    share[2] = six_volumes(p[0], p[1], p[3]), share[3] = -six_volumes(p[0], p[1], p[2]);
    const double all = (share[0] + share[1]) + (share[2] + share[3]);
    double sum = 0;
    for (double& s : share) {
      s = s / all;
      s = s > 0 && s < 2 ? s : 0;  // written so that a NaN becomes 0
      s += least;
      sum += s;
    }
    for (int k = 0; k < 4; ++k) weight[k][i] = share[k] / sum;
  }
}

/// Shifts weight between the points inside and outside so that the field has the hit's value.
/// @param field  [point][hit]
RHORAY_INLINE void move_to_value(const double* value, const Numbers* field, Numbers* weight) {
  for (std::size_t i = 0; i < group_size; ++i) {
    double weight_in = 0, weight_out = 0, sum_in = 0, sum_out = 0;
    for (int k = 0; k < 4; ++k) {
      const bool inside = field[k][i] >= value[i];
      const double w = weight[k][i], difference = field[k][i] - value[i];
      weight_in += inside ? w : 0, weight_out += inside ? 0 : w;
      sum_in += inside ? w * difference : 0, sum_out += inside ? 0 : w * difference;
    }
    // Mean differences on both sides; 0 / 0 where all points are on one side.
    const double above = sum_in / weight_in, below = -sum_out / weight_out;
    const double share_in = below / (above + below), share_out = above / (above + below);
    const bool is_between = share_in >= 0 && share_out >= 0;
    const double scale_in = is_between ? share_in / weight_in : 1, scale_out = is_between ? share_out / weight_out : 1;
    for (int k = 0; k < 4; ++k) weight[k][i] *= field[k][i] >= value[i] ? scale_in : scale_out;
  }
}

/// Misses get an arbitrary cell, and so do hits that are not shown and are left from other data.
RHORAY_INLINE void find_cells(const MeshLookup& lookup, const RayBatch& rays, const HitBatch& hits, std::size_t first,
                              HitCells& cells) {
  Numbers place[3], away[4][3], field[4];
  find_places(rays, hits, first, place);
  const TetData& view = *lookup.view;
  const bool is_boundary = !lookup.cells.empty();
  const std::uint64_t count = is_boundary ? lookup.cells.size() : view.description().cell_count;
  for (std::size_t i = 0; i < group_size; ++i) {
    const std::uint32_t own = hits.tet[first + i];
    const std::uint32_t tet = hits.t[first + i] < infinity && own < count ? own : 0;
    cells.cell[i] = is_boundary ? lookup.cells[tet] : tet;
    const auto vertices = view.vertices(cells.cell[i]);
    const auto points = view.points_at(vertices);
    for (std::size_t k = 0; k < 4; ++k) {
      cells.point[k][i] = vertices[k];
      field[k][i] = view.value_at(vertices[k]);
      for (std::size_t axis = 0; axis < 3; ++axis) away[k][axis][i] = points[k][axis] - place[axis][i];
    }
  }
  weigh_by_volumes(away, cells.weight);
  if (!is_boundary) move_to_value(hits.value.data() + first, field, cells.weight);
}

/// Weighted means of at(point) over the points of cells.
template <class At>
RHORAY_INLINE void interpolate(const HitCells& cells, const At& at, double* out) {
  Numbers number[4];
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < group_size; ++i) number[k][i] = at(cells.point[k][i]);
  for (std::size_t i = 0; i < group_size; ++i)
    out[i] = (cells.weight[0][i] * number[0][i] + cells.weight[1][i] * number[1][i]) +
             (cells.weight[2][i] * number[2][i] + cells.weight[3][i] * number[3][i]);
}

RHORAY_INLINE void replace_gradients(const HitCells& cells, std::span<const std::array<double, 3>> gradients,
                                     HitBatch& hits, std::size_t first) {
  Numbers smooth[3];
  for (std::size_t axis = 0; axis < 3; ++axis)
    interpolate(
        cells, [&](std::uint32_t point) { return gradients[point][axis]; }, smooth[axis].of);
  for (std::size_t i = 0; i < group_size; ++i) {
    const double size = std::abs(smooth[0][i]) + std::abs(smooth[1][i]) + std::abs(smooth[2][i]);
    const bool is_usable = size > 0 && size < infinity;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double& gradient = hits.gradient[axis].data()[first + i];
      gradient = is_usable ? smooth[axis][i] : gradient;
    }
  }
}

RHORAY_INLINE void look_up_in_mesh(const MeshLookup& lookup, const RayBatch& rays, HitBatch& hits, std::size_t first,
                                   double* values) {
  HitCells cells;
  find_cells(lookup, rays, hits, first, cells);
  if (lookup.gradients) replace_gradients(cells, lookup.gradients->of_points(), hits, first);
  if (lookup.field)
    interpolate(
        cells, [&](std::uint32_t point) { return lookup.field->value_at(point); }, values);
  if (lookup.cell_field)
    for (std::size_t i = 0; i < group_size; ++i) values[i] = (*lookup.cell_field)[cells.cell[i]];
}

// Surfaces.

/// Computes a position's weights in a triangle from the areas opposite its corners; none is
/// negative. For a triangle without area, some are not finite.
std::array<double, 3> weights_at(const TrianglePoints& points, const Vec3& place) {
  const auto from_place = [&](std::size_t c) { return Vec3(points[c][0], points[c][1], points[c][2]) - place; };
  const Vec3 normal = triangle_normal(points), away[3] = {from_place(0), from_place(1), from_place(2)};
  std::array<double, 3> weight;
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    weight[c] = std::max(0.0, normal.dot(away[(c + 1) % 3].cross(away[(c + 2) % 3])));
    sum += weight[c];
  }
  for (double& w : weight) w /= sum;
  return weight;
}

/// Replaces a gradient, unless the smooth one is zero or not finite.
void replace_gradient(const Vec3& smooth, HitBatch& hits, std::size_t r) {
  const double size = std::abs(smooth.x) + std::abs(smooth.y) + std::abs(smooth.z);
  if (!(size > 0 && size < infinity)) return;
  for (int axis = 0; axis < 3; ++axis) hits.gradient[axis][r] = smooth[axis];
}

void replace_by_smooth(const TriangleData& view, const CornerNormals& normals, const Ray& ray, std::size_t r,
                       HitBatch& hits) {
  const std::uint32_t triangle = hits.tet[r];
  if (triangle >= view.triangle_count()) return;  // not shown, left from other data
  const std::array<double, 3> weight = weights_at(view.points_at(view.vertices(triangle)), ray.at(hits.t[r]));
  Vec3 smooth(0, 0, 0);
  for (std::size_t c = 0; c < 3; ++c) smooth += weight[c] * normals.of(triangle, c);
  replace_gradient(smooth, hits, r);
}

// Grids.

template <class Grid>
RHORAY_INLINE void look_up_in_grid(const Grid& grid, const RayBatch& rays, const HitBatch& hits, std::size_t first,
                                   double* values) {
  Numbers place[3], corner[8];
  find_places(rays, hits, first, place);
  const Index3 count = grid.lattice().leaf_count;
  const auto cell_count = static_cast<std::uint64_t>(volume(count));
  for (std::size_t i = 0; i < group_size; ++i) {
    const std::uint64_t own = hits.cell[first + i];
    const std::uint64_t id = hits.t[first + i] < infinity && own < cell_count ? own : 0;
    const auto of_row = static_cast<std::int64_t>(id) / count.x;
    const Index3 cell(static_cast<std::int64_t>(id) % count.x, of_row % count.y, of_row / count.y);
    const TrilinearCell corners = grid.cell(cell);
    for (std::size_t c = 0; c < 8; ++c) corner[c][i] = corners.corner[c];
    for (int axis = 0; axis < 3; ++axis) {
      double& at = place[axis][i];
      at = grid.geometry().in_cell(axis, at, cell[axis]);
      at = at > 0 ? at : 0;
      at = at < 1 ? at : 1;
    }
  }
  for (std::size_t i = 0; i < group_size; ++i) {
    TrilinearCell cell;
    for (std::size_t c = 0; c < 8; ++c) cell.corner[c] = corner[c][i];
    values[i] = cell.at({place[0][i], place[1][i], place[2][i]});
  }
}

template <class Grid>
void replace_by_smooth(const Grid& grid, ReadSurroundings read, const Ray& ray, std::size_t r, HitBatch& hits) {
  const Index3 count = grid.lattice().leaf_count;
  if (hits.cell[r] >= static_cast<std::uint64_t>(volume(count))) return;  // not shown, left from other data
  const auto id = static_cast<std::int64_t>(hits.cell[r]);
  const Index3 cell(id % count.x, id / count.x % count.y, id / count.x / count.y);
  Vec3 place = ray.at(hits.t[r]);
  for (int axis = 0; axis < 3; ++axis)
    place[axis] = std::clamp(grid.geometry().in_cell(axis, place[axis], cell[axis]), 0.0, 1.0);
  CellSurroundings around;
  read(grid, cell, around);
  replace_gradient(smooth_gradient(grid.geometry(), cell, place, around), hits, r);
}

// Choice of the lookup.

using LookUp = std::function<void(const RayBatch& rays, HitBatch& hits, std::size_t first, double* values)>;

template <class Grid>
LookUp in_grid(Grid grid, Machine machine) {
  return [grid = std::move(grid), look_up = compiled_for<look_up_in_grid<Grid>>(machine)](
             const RayBatch& rays, HitBatch& hits, std::size_t first, double* values) {
    look_up(grid, rays, hits, first, values);
  };
}

/// Adds a field to what is looked up. One of cells has priority over one of points of the same name
/// (Dataset::field).
void add_field(const std::string& name, MeshLookup& lookup) {
  const formats::TetMesh& mesh = lookup.view->mesh();
  const std::optional<std::size_t> of_cells = mesh.find_cell_field(name);
  if (!of_cells)
    lookup.field.emplace(mesh, *mesh.find_field(name));
  else if (mesh.description().cell_fields[*of_cells].type == formats::ElementType::F32)
    lookup.cell_field = CellValues{.floats = mesh.cell_values<float>(*of_cells)};
  else
    lookup.cell_field = CellValues{.doubles = mesh.cell_values<double>(*of_cells)};
}

LookUp look_up_for(const TetData& view, const LoadedDataset& dataset, const HitAttributes& attributes, unsigned threads,
                   Machine machine, const std::stop_token& stop) {
  MeshLookup lookup{.view = &view};
  if (attributes.smooth_gradients) lookup.gradients = dataset.point_gradients->of(view, threads, stop);
  if (attributes.field) add_field(*attributes.field, lookup);
  return [lookup = std::move(lookup), look_up = compiled_for<look_up_in_mesh>(machine)](
             const RayBatch& rays, HitBatch& hits, std::size_t first, double* values) {
    look_up(lookup, rays, hits, first, values);
  };
}

template <class Geometry>
LookUp field_lookup(const PlacedGrid<Geometry>& view, const LoadedDataset& dataset, const std::string& field,
                    Machine machine) {
  if (view.packed()) return in_grid(PlacedGrid<Geometry>(*view.packed(), *view.packed()->find_field(field)), machine);
  if (field != dataset.field.name)
    throw Error(ErrorCode::unsupported,
                concat(dataset.file.name(), ": field '", field,
                       "' is another grid, with other voxels; a surface can be coloured only by its own field, '",
                       dataset.field.name, "'"));
  return in_grid(view, machine);
}

template <class Geometry>
LookUp look_up_for(const PlacedGrid<Geometry>& view, const LoadedDataset& dataset, const HitAttributes& attributes,
                   unsigned, Machine machine, const std::stop_token&) {
  LookUp of_field;
  if (attributes.field) of_field = field_lookup(view, dataset, *attributes.field, machine);
  if (!attributes.smooth_gradients) return of_field;
  return [&view, read = surroundings_reader(view), of_field = std::move(of_field)](const RayBatch& rays, HitBatch& hits,
                                                                                   std::size_t first, double* values) {
    for (std::size_t r = first; r < first + group_size && r < rays.count; ++r)
      if (hits.t[r] < infinity) replace_by_smooth(view, read, rays[r], r, hits);
    if (of_field) of_field(rays, hits, first, values);
  };
}

/// Looks up a field of the cells whose faces are the triangles. It is the hit's value, too: a
/// triangle has no other.
LookUp field_on_boundary(const MeshBoundary& boundary, const std::string& field, Machine machine) {
  MeshLookup lookup{.view = &boundary.mesh, .cells = boundary.cells};
  add_field(field, lookup);
  return [lookup = std::move(lookup), look_up = compiled_for<look_up_in_mesh>(machine)](
             const RayBatch& rays, HitBatch& hits, std::size_t first, double* values) {
    look_up(lookup, rays, hits, first, values);
    for (std::size_t i = 0; i < group_size; ++i)
      if (hits.t[first + i] < infinity) hits.value[first + i] = values[i];
  };
}

LookUp look_up_for(const TriangleData& view, const LoadedDataset& dataset, const HitAttributes& attributes,
                   unsigned threads, Machine machine, const std::stop_token& stop) {
  LookUp of_field;
  if (attributes.field) {
    if (view.boundary() == nullptr)
      throw Error(ErrorCode::usage, concat(dataset.file.name(), ": a surface has no fields"));
    of_field = field_on_boundary(*view.boundary(), *attributes.field, machine);
  }
  if (!attributes.smooth_gradients) return of_field;
  return [&view, normals = dataset.corner_normals->of(view, threads, stop), of_field = std::move(of_field)](
             const RayBatch& rays, HitBatch& hits, std::size_t first, double* values) {
    for (std::size_t r = first; r < first + group_size && r < rays.count; ++r)
      if (hits.t[r] < infinity) replace_by_smooth(view, *normals, rays[r], r, hits);
    if (of_field) of_field(rays, hits, first, values);
  };
}

}  // namespace

HitLookup::HitLookup(const LoadedDataset& dataset, const HitAttributes& attributes, unsigned threads, Machine machine,
                     const std::stop_token& stop) {
  RHORAY_CHECK(!attributes.none());
  if (attributes.field) check_field_name(dataset.file, *attributes.field, color_names(dataset));
  look_up_ = std::visit(
      [&](const auto& view) { return look_up_for(view, dataset, attributes, threads, machine, stop); }, dataset.view);
}

}  // namespace rhoray::render

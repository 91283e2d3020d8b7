#include "preprocess/mesh/inspect/clean_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "preprocess/mesh/inspect/orientation.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t grain = 4096;
// between them orientations are exact
constexpr double largest_coordinate = 1e100, smallest_extent = 1e-100;
constexpr std::uint64_t largest_count = std::numeric_limits<std::uint32_t>::max();

/// The count of one kind of problem, and its first positions.
class NotedProblem {
 public:
  void add(std::uint64_t id) {
    if (++count_ <= 3) places_ += concat(count_ > 1 ? ", " : "", id);
  }
  std::uint64_t count() const { return count_; }

  /// Adds the note `3 cells <what> (4, 8, 15)`, or nothing when the count is 0.
  void note(std::vector<std::string>& notes, std::string_view thing, std::string_view what) const {
    if (count_ == 0) return;
    notes.push_back(concat(count_, " ", thing, count_ == 1 ? " " : "s ", what, count_ > 3 ? " (first " : " (", thing,
                           count_ == 1 ? " " : "s ", places_, ")"));
  }

 private:
  std::uint64_t count_ = 0;
  std::string places_;
};

std::uint64_t id_of_cell(const NeutralMesh& mesh, std::size_t cell) {
  return mesh.cell_ids.empty() ? cell : mesh.cell_ids[cell];
}

void check_counts(const NeutralMesh& mesh, const std::string& source_name) {
  if (mesh.cells.empty())
    throw Error(ErrorCode::invalid, concat(source_name, ": found no tetrahedra; expected at least one"));
  if (mesh.cells.size() > largest_count)
    throw Error(ErrorCode::unsupported,
                concat(source_name, ": found ", mesh.cells.size(), " cells; expected at most ", largest_count));
  if (!mesh.cell_ids.empty() && mesh.cell_ids.size() != mesh.cells.size())
    throw Error(ErrorCode::invalid, concat(source_name, ": found ", mesh.cell_ids.size(), " cell ids; expected ",
                                           mesh.cells.size(), ", one for each cell"));
}

void check_indices(const NeutralMesh& mesh, const std::string& source_name) {
  const std::size_t none = mesh.cells.size();
  const std::size_t first_wrong = parallel_reduce(
      mesh.cells.size(), grain, none,
      [&](const IndexRange& part) {
        for (std::size_t c = part.begin(); c < part.end(); ++c)
          for (const std::uint64_t vertex : mesh.cells[c])
            if (vertex >= mesh.points.size()) return c;
        return none;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (first_wrong == none) return;
  for (const std::uint64_t vertex : mesh.cells[first_wrong])
    if (vertex >= mesh.points.size())
      throw Error(ErrorCode::invalid,
                  concat(source_name, ", cell ", id_of_cell(mesh, first_wrong), ": found vertex ", vertex,
                         "; expected a number below the count of points, ", mesh.points.size()));
}

bool names_a_vertex_twice(const std::array<std::uint64_t, 4>& cell) {
  return cell[0] == cell[1] || cell[0] == cell[2] || cell[0] == cell[3] || cell[1] == cell[2] || cell[1] == cell[3] ||
         cell[2] == cell[3];
}

bool is_finite(const std::array<double, 3>& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

void choose_cells(const NeutralMesh& mesh, CleanMesh& clean) {
  NotedProblem repeating, not_finite;
  clean.source_cells.reserve(mesh.cells.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto& cell = mesh.cells[c];
    if (names_a_vertex_twice(cell))
      repeating.add(id_of_cell(mesh, c));
    else if (!std::all_of(cell.begin(), cell.end(), [&](std::uint64_t v) { return is_finite(mesh.points[v]); }))
      not_finite.add(id_of_cell(mesh, c));
    else
      clean.source_cells.push_back(c);
  }
  clean.dropped_cell_count = repeating.count() + not_finite.count();
  repeating.note(clean.notes, "cell", "with a repeated vertex: dropped");
  not_finite.note(clean.notes, "cell", "with a coordinate that is not finite: dropped");
}

/// Numbers the points of the chosen cells in the source's order.
void choose_points(const NeutralMesh& mesh, const std::string& source_name, CleanMesh& clean) {
  constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
  Array<std::uint32_t> number(mesh.points.size(), unused);
  for (const std::uint64_t c : clean.source_cells)
    for (const std::uint64_t vertex : mesh.cells[c]) number[vertex] = 0;

  NotedProblem without_cell;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (number[p] == unused) {
      without_cell.add(p);
      continue;
    }
    if (clean.source_points.size() == largest_count)
      throw Error(ErrorCode::unsupported, concat(source_name, ": found more than ", largest_count,
                                                 " points in cells; expected at most that many"));
    number[p] = static_cast<std::uint32_t>(clean.source_points.size());
    clean.source_points.push_back(p);
  }
  clean.unused_point_count = without_cell.count();
  without_cell.note(clean.notes, "point", "without a cell: dropped");

  clean.cells.resize(clean.source_cells.size());
  for (std::size_t c = 0; c < clean.cells.size(); ++c)
    for (std::size_t v = 0; v < 4; ++v) clean.cells[c][v] = number[mesh.cells[clean.source_cells[c]][v]];
}

/// Returns the origin of the mesh's coordinates on one axis. It is zero where the coordinates lie
/// around zero. Where they lie far away, all are within a factor of two of the middle, and a
/// difference of two such doubles is exact.
double origin_on_axis(double low, double high) {
  const double middle = low / 2 + high / 2, extent = high - low;
  if (std::abs(middle) <= 2 * extent) return 0;
  const double step = std::exp2(std::floor(std::log2(extent)) - 2);  // few digits, easy to read
  return std::round(middle / step) * step;
}

void place_points(const NeutralMesh& mesh, const std::string& source_name, CleanMesh& clean) {
  std::array<double, 3> low, high, origin;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const std::uint64_t p : clean.source_points)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = mesh.points[p][axis];
      if (std::abs(x) > largest_coordinate)
        throw Error(ErrorCode::invalid, concat(source_name, ", point ", p, ": found coordinate ", x,
                                               "; expected at most ", largest_coordinate));
      low[axis] = std::min(low[axis], x);
      high[axis] = std::max(high[axis], x);
    }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(high[axis] - low[axis] >= smallest_extent))
      throw Error(ErrorCode::invalid,
                  concat(source_name, ": found ", std::string_view("xyz").substr(axis, 1), " from ", low[axis], " to ",
                         high[axis], "; expected a box with volume"),
                  "a planar mesh has no volume to trace rays through");
    origin[axis] = origin_on_axis(low[axis], high[axis]);
  }
  clean.origin = {origin[0], origin[1], origin[2]};
  clean.box = Box3(Vec3(low[0], low[1], low[2]) - clean.origin, Vec3(high[0], high[1], high[2]) - clean.origin);
  clean.points.resize(clean.source_points.size());
  for (std::size_t p = 0; p < clean.points.size(); ++p)
    for (std::size_t axis = 0; axis < 3; ++axis)
      clean.points[p][axis] = mesh.points[clean.source_points[p]][axis] - origin[axis];
}

void orient_cells(const NeutralMesh& mesh, CleanMesh& clean) {
  Array<std::int8_t> signs(clean.cells.size());
  parallel_for(clean.cells.size(), grain, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      auto& cell = clean.cells[c];
      const int sign =
          orientation(clean.points[cell[0]], clean.points[cell[1]], clean.points[cell[2]], clean.points[cell[3]]);
      if (sign < 0) std::swap(cell[2], cell[3]);
      signs[c] = static_cast<std::int8_t>(sign);
    }
  });
  NotedProblem flipped, flat;
  for (std::size_t c = 0; c < signs.size(); ++c) {
    if (signs[c] < 0) flipped.add(id_of_cell(mesh, clean.source_cells[c]));
    if (signs[c] == 0) flat.add(id_of_cell(mesh, clean.source_cells[c]));
  }
  clean.flipped_cell_count = flipped.count();
  clean.flat_cell_count = flat.count();
  flipped.note(clean.notes, "cell", "of negative orientation: two vertices exchanged");
  flat.note(clean.notes, "cell", "of zero volume: kept");
}

}  // namespace

CleanMesh clean_mesh(const NeutralMesh& mesh, const std::string& source_name) {
  check_counts(mesh, source_name);
  check_indices(mesh, source_name);
  CleanMesh clean;
  choose_cells(mesh, clean);
  if (clean.source_cells.empty())
    throw Error(ErrorCode::invalid, concat(source_name, ": found ", mesh.cells.size(),
                                           " cells, all with a repeated vertex or a coordinate that is not finite; "
                                           "expected at least one tetrahedron"));
  choose_points(mesh, source_name, clean);
  place_points(mesh, source_name, clean);
  orient_cells(mesh, clean);
  return clean;
}

}  // namespace rhoray::preprocess

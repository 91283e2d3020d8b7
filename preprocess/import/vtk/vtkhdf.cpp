// VTKHDF: image data and unstructured grids, of one time step, in HDF5 files (.vtkhdf, .hdf). The
// netCDF library reads HDF5. Source: VTK's documentation, "VTKHDF File Format".

#include <algorithm>
#include <array>
#include <string>

#include "preprocess/import/mesh/mesh_pieces.h"
#include "preprocess/import/mesh/netcdf_file.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using Variable = NetcdfFile::Variable;

const std::string root = "VTKHDF";

/// Opens a file and refuses what is not read of the format.
/// @param type  of the data set
void check_vtkhdf(const NetcdfFile& file, std::string_view type) {
  if (!file.has_group(root)) refuse_input(file.path(), "groups", "no group VTKHDF", "one of this name");
  const std::vector<double> version = file.number_attribute(root, "Version");
  if (version.size() != 2) refuse_input(file.path(), "attribute Version", "none of two numbers", "such as 1, 0");
  if (!(version[0] >= 1 && version[0] <= 2))
    refuse_input(file.path(), "attribute Version", concat(version[0], ".", version[1]), "1.0 to 2.x",
                 ErrorCode::unsupported);
  const std::string found = file.text_attribute(root, "Type");
  if (found != type) refuse_input(file.path(), "attribute Type", concat("'", found, "'"), type, ErrorCode::unsupported);
  if (file.has_group(root + "/Steps"))
    refuse_input(file.path(), "group Steps", "several time steps", "data of one time, without this group",
                 ErrorCode::unsupported);
}

/// Names of the arrays of numbers in a group; a note tells of others.
std::vector<Variable> arrays_in(const NetcdfFile& file, const std::string& group, std::vector<std::string>& notes) {
  std::vector<Variable> arrays;
  for (const std::string& name : file.names_in(group)) {
    Variable array = file.need_variable(concat(group, "/", name));
    if (NetcdfFile::element_type(array))
      arrays.push_back(std::move(array));
    else
      notes.push_back(concat("array '", name, "' was left out, because it holds no numbers"));
  }
  return arrays;
}

/// The name of an array without its group.
std::string short_name(const Variable& array) {
  return array.name.substr(array.name.rfind('/') + 1);
}

/// Numbers for each of the owners that the first axes of an array count.
int component_count(const NetcdfFile& file, const Variable& array, std::size_t owner_axes) {
  constexpr std::uint64_t most = 1024;
  if (array.shape.size() == owner_axes) return 1;
  if (array.shape.size() != owner_axes + 1 || array.shape.back() < 1 || array.shape.back() > most)
    refuse_input(file.path(), concat("array '", short_name(array), "'"), concat(array.shape.size(), " axes"),
                 concat(owner_axes, ", or one more of 1 to ", most, " components"), ErrorCode::unsupported);
  return static_cast<int>(array.shape.back());
}

template <std::size_t N>
std::array<double, N> numbers_of(const NetcdfFile& file, const char* attribute,
                                 const std::array<double, N>& otherwise) {
  const std::vector<double> found = file.number_attribute(root, attribute);
  if (found.empty()) return otherwise;
  if (found.size() != N)
    refuse_input(file.path(), concat("attribute ", attribute), concat(found.size(), " numbers"), concat(N));
  std::array<double, N> numbers;
  std::copy(found.begin(), found.end(), numbers.begin());
  return numbers;
}

PointGrid image_grid(const NetcdfFile& file) {
  const auto extent = numbers_of<6>(file, "WholeExtent", {0, -1, 0, -1, 0, -1});
  const auto origin = numbers_of<3>(file, "Origin", {0, 0, 0});
  const auto spacing = numbers_of<3>(file, "Spacing", {1, 1, 1});
  const auto direction = numbers_of<9>(file, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1});
  PointGrid grid;
  Vec3 first;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = extent[2 * static_cast<std::size_t>(axis)],
                 high = extent[2 * static_cast<std::size_t>(axis) + 1];
    constexpr double farthest = 1 << 30;
    if (!(low >= -farthest && high <= farthest && low <= high))  // written so that NaN is refused
      refuse_input(file.path(), "attribute WholeExtent", concat(low, " to ", high), "an ascending range on each axis");
    grid.point_count[axis] = static_cast<std::int64_t>(high - low) + 1;
    first[axis] = low;
  }
  const auto column = [&](std::size_t axis) {
    return spacing[axis] * Vec3(direction[axis], direction[3 + axis], direction[6 + axis]);
  };
  grid.world_from_grid = {column(0), column(1), column(2), Vec3(origin[0], origin[1], origin[2])};
  grid.world_from_grid.origin = grid.world_from_grid.point(first);
  return grid;
}

/// The shape of an array of the grid: z, y, x, and perhaps components.
std::vector<std::uint64_t> shape_in(const PointGrid& grid, const Variable& array, bool in_cells) {
  std::vector<std::uint64_t> shape;
  for (int axis = 2; axis >= 0; --axis) {
    const std::int64_t points = grid.point_count[axis];
    shape.push_back(static_cast<std::uint64_t>(in_cells ? std::max<std::int64_t>(1, points - 1) : points));
  }
  if (array.shape.size() == 4) shape.push_back(array.shape.back());
  return shape;
}

/// The numbers of partitions, as NumberOfPoints has them.
std::vector<std::uint64_t> counts(const NetcdfFile& file, const char* name) {
  const Variable variable = file.need_variable(concat(root, "/", name));
  constexpr std::size_t most_partitions = 1'000'000;
  if (variable.shape.size() != 1 || variable.shape[0] > most_partitions)
    refuse_input(file.path(), concat("array '", name, "'"), concat(variable.shape.size(), " axes"),
                 "one, a number for each partition");
  std::vector<std::uint64_t> result;
  constexpr std::int64_t largest = std::int64_t{1} << 48;  // of all together: no sum overflows
  std::int64_t left = largest;
  for (const std::int64_t count : file.integers(variable, variable.shape)) {
    if (count < 0 || count > left)
      refuse_input(file.path(), concat("array '", name, "'"), concat(count), concat("0 to ", largest, " in all"));
    left -= count;
    result.push_back(static_cast<std::uint64_t>(count));
  }
  return result;
}

std::uint64_t sum_of(const std::vector<std::uint64_t>& numbers) {
  std::uint64_t sum = 0;
  for (const std::uint64_t number : numbers) sum += number;
  return sum;
}

/// A field of all partitions.
struct WholeField {
  NeutralField field;
  bool in_cells = false;
};

/// The arrays of all partitions.
struct WholeGrid {
  std::vector<std::uint64_t> points, cells, nodes;  ///< counts, one for each partition
  Array<double> places;
  Array<std::int64_t> offsets, connectivity, kinds;
  std::vector<WholeField> fields;
  Array<std::int64_t> ghosts, point_ghosts;  ///< vtkGhostType; empty: none
  std::vector<std::string> notes;
};

Array<std::int64_t> integers_of(const NetcdfFile& file, const char* name, std::uint64_t count) {
  return file.integers(file.need_variable(concat(root, "/", name)), std::array{count});
}

void read_fields(const NetcdfFile& file, WholeGrid& grid, bool in_cells) {
  const std::uint64_t owners = sum_of(in_cells ? grid.cells : grid.points);
  for (const Variable& array : arrays_in(file, root + (in_cells ? "/CellData" : "/PointData"), grid.notes)) {
    if (short_name(array) == "vtkGhostType") {
      (in_cells ? grid.ghosts : grid.point_ghosts) = file.integers(array, std::array{owners});
      continue;
    }
    const int components = component_count(file, array, 1);
    std::vector<std::uint64_t> shape{owners};
    if (array.shape.size() == 2) shape.push_back(static_cast<std::uint64_t>(components));
    WholeField& whole = grid.fields.emplace_back();
    whole.in_cells = in_cells;
    whole.field.name = short_name(array);
    whole.field.component_count = components;
    whole.field.values = file.numbers(array, shape);
    note_precision(whole.field, *NetcdfFile::element_type(array), grid.notes);
  }
}

WholeGrid read_whole(const NetcdfFile& file) {
  WholeGrid grid{.points = counts(file, "NumberOfPoints"),
                 .cells = counts(file, "NumberOfCells"),
                 .nodes = counts(file, "NumberOfConnectivityIds"),
                 .places = {},
                 .offsets = {},
                 .connectivity = {},
                 .kinds = {},
                 .fields = {},
                 .ghosts = {},
                 .point_ghosts = {},
                 .notes = {}};
  const std::size_t partitions = grid.points.size();
  if (grid.cells.size() != partitions || grid.nodes.size() != partitions)
    refuse_input(file.path(), "array 'NumberOfCells'", concat(grid.cells.size(), " partitions"), concat(partitions));
  grid.places = file.numbers(file.need_variable(root + "/Points"), std::array{sum_of(grid.points), std::uint64_t{3}});
  grid.offsets = integers_of(file, "Offsets", sum_of(grid.cells) + partitions);
  grid.connectivity = integers_of(file, "Connectivity", sum_of(grid.nodes));
  grid.kinds = integers_of(file, "Types", sum_of(grid.cells));
  for (const std::int64_t kind : grid.kinds)
    if (kind < 0 || kind > 255) refuse_input(file.path(), "array 'Types'", concat("kind ", kind), "0 to 255");
  for (const bool in_cells : {false, true}) read_fields(file, grid, in_cells);
  return grid;
}

template <class To>
Array<To> part_of(const Array<std::int64_t>& numbers, std::uint64_t first, std::uint64_t count) {
  Array<To> part;
  part.reserve(count);
  for (std::uint64_t i = first; i < first + count; ++i) part.push_back(static_cast<To>(numbers[i]));
  return part;
}

/// Where a partition begins in the arrays.
struct Begin {
  std::uint64_t point = 0, cell = 0, node = 0;
};

void add_partition(MeshPieces& pieces, const WholeGrid& grid, std::size_t p, const Begin& begin,
                   const std::filesystem::path& path) {
  const std::uint64_t points = grid.points[p], cells = grid.cells[p];
  ForeignCells foreign{.kinds = part_of<std::uint8_t>(grid.kinds, begin.cell, cells),
                       .offsets = part_of<std::uint64_t>(grid.offsets, begin.cell + p, cells + 1),
                       .nodes = part_of<std::uint64_t>(grid.connectivity, begin.node, grid.nodes[p])};
  if (!grid.ghosts.empty()) foreign.ghosts = part_of<std::uint8_t>(grid.ghosts, begin.cell, cells);
  if (!grid.point_ghosts.empty()) foreign.point_ghosts = part_of<std::uint8_t>(grid.point_ghosts, begin.point, points);
  check_offsets(foreign, path);
  if (std::find(foreign.kinds.begin(), foreign.kinds.end(), static_cast<std::uint8_t>(CellKind::polyhedron)) !=
      foreign.kinds.end())
    refuse_input(path, "array 'Types'", "polyhedra", "cells of other kinds", ErrorCode::unsupported);
  CellMesh mesh;
  mesh.points.resize(points);
  for (std::uint64_t i = 0; i < points; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) mesh.points[i][axis] = grid.places[3 * (begin.point + i) + axis];
  for (const auto& [whole, in_cells] : grid.fields) {
    const auto width = static_cast<std::uint64_t>(whole.component_count);
    const auto first =
        whole.values.begin() + static_cast<std::ptrdiff_t>((in_cells ? begin.cell : begin.point) * width);
    NeutralField& field = (in_cells ? mesh.cell_fields : mesh.point_fields).emplace_back();
    field.name = whole.name;
    field.component_count = whole.component_count;
    field.was_single_precision = whole.was_single_precision;
    field.values.assign(first, first + static_cast<std::ptrdiff_t>((in_cells ? cells : points) * width));
  }
  if (p == 0) mesh.notes = grid.notes;
  pieces.add(std::move(mesh), std::move(foreign), path);
}

}  // namespace

NeutralVolume read_vtkhdf_volume(const std::filesystem::path& path, const std::string& field) {
  const NetcdfFile file(path);
  check_vtkhdf(file, "ImageData");
  const PointGrid grid = image_grid(file);
  std::vector<GridArray> arrays;
  std::vector<std::string> notes;
  for (const bool in_cells : {false, true})
    for (const Variable& array : arrays_in(file, root + (in_cells ? "/CellData" : "/PointData"), notes))
      arrays.push_back(
          {.name = short_name(array),
           .type = *NetcdfFile::element_type(array),
           .component_count = component_count(file, array, 3),
           .in_cells = in_cells,
           .load = [&file, &grid, array, in_cells] { return file.bytes(array, shape_in(grid, array, in_cells)); }});
  NeutralVolume volume = volume_of_field(path, grid, std::move(arrays), field);
  volume.notes.insert(volume.notes.end(), notes.begin(), notes.end());
  return volume;
}

CellMesh read_vtkhdf_mesh(const std::filesystem::path& path) {
  const NetcdfFile file(path);
  check_vtkhdf(file, "UnstructuredGrid");
  const WholeGrid grid = read_whole(file);
  MeshPieces pieces;
  Begin begin;
  for (std::size_t p = 0; p < grid.points.size(); ++p) {
    add_partition(pieces, grid, p, begin, path);
    begin = {begin.point + grid.points[p], begin.cell + grid.cells[p], begin.node + grid.nodes[p]};
  }
  return pieces.finish(path);
}

}  // namespace rhoray::preprocess

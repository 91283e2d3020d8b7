#include "preprocess/import/mesh_cells.h"

#include <algorithm>
#include <map>

#include "preprocess/import/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// What stands for a cell kind in a file: VTK's number (vtkCellType.h), and how many nodes a cell of it has.
struct ForeignKindOfCell {
  std::uint8_t number;
  std::string_view plural;
  bool fills_space;
  int node_count = 0;  ///< 0: as many as the cell says, checked where it is taken apart
};

constexpr ForeignKindOfCell kinds_of_cells[] = {
    {0, "empty cells", false},
    {1, "vertices", false},
    {2, "vertices", false},
    {3, "lines", false},
    {4, "polylines", false},
    {5, "triangles", false},
    {6, "triangle strips", false},
    {7, "polygons", false},
    {8, "pixels", false},
    {9, "quadrilaterals", false},
    {10, "tetrahedra", true, 4},
    {11, "voxels", true, 8},
    {12, "hexahedra", true, 8},
    {13, "wedges", true, 6},
    {14, "pyramids", true, 5},
    {15, "pentagonal prisms", true, 10},
    {16, "hexagonal prisms", true, 12},
    {21, "quadratic lines", false},
    {22, "quadratic triangles", false},
    {23, "quadratic quadrilaterals", false},
    {24, "quadratic tetrahedra", true, 10},
    {25, "quadratic hexahedra", true, 20},
    {26, "quadratic wedges", true, 15},
    {27, "quadratic pyramids", true, 13},
    {28, "biquadratic quadrilaterals", false},
    {29, "triquadratic hexahedra", true, 27},
    {30, "quadratic-linear quadrilaterals", false},
    {31, "quadratic-linear wedges", true, 12},
    {32, "biquadratic-quadratic wedges", true, 18},
    {33, "biquadratic-quadratic hexahedra", true, 24},
    {34, "biquadratic triangles", false},
    {35, "cubic lines", false},
    {36, "quadratic polygons", false},
    {37, "triquadratic pyramids", true, 19},
    {42, "polyhedra", true},
    {68, "Lagrange curves", false},
    {69, "Lagrange triangles", false},
    {70, "Lagrange quadrilaterals", false},
    {71, "Lagrange tetrahedra", true},
    {72, "Lagrange hexahedra", true},
    {73, "Lagrange wedges", true},
    {74, "Lagrange pyramids", true},
    {200, "quadratic pyramids of 14 nodes", true, 14},
    {201, "quadratic tetrahedra of 14 nodes", true, 14},
};

const ForeignKindOfCell* kind_numbered(std::uint8_t number) {
  const auto found = std::find_if(std::begin(kinds_of_cells), std::end(kinds_of_cells),
                                  [&](const ForeignKindOfCell& kind) { return kind.number == number; });
  return found == std::end(kinds_of_cells) ? nullptr : found;
}

std::string census_of_left_out(const ForeignCells& cells) {
  std::map<std::string_view, std::uint64_t> counts;
  for (const std::uint8_t number : cells.kinds)
    if (const ForeignKindOfCell* kind = kind_numbered(number); !kind->fills_space) ++counts[kind->plural];
  std::string text;
  for (const auto& [name, count] : counts) text += concat(text.empty() ? "" : ", ", count, " ", name);
  return text;
}

void check_offsets(const ForeignCells& cells, const std::filesystem::path& path) {
  if (cells.offsets.size() != cells.kinds.size() + 1)
    refuse_input(path, "cells", concat(cells.kinds.size(), " kinds for ", cells.offsets.size() - 1, " cells"),
                 "one kind for each cell");
  if (cells.offsets.front() != 0 || cells.offsets.back() != cells.nodes.size() ||
      !std::is_sorted(cells.offsets.begin(), cells.offsets.end()))
    refuse_input(path, "cells", "offsets that do not fit the corners",
                 "offsets rising from 0 to the number of corners");
}

/// Refuses unknown kinds, counts them, and says how many cells fill space.
std::uint64_t count_of_filling(const ForeignCells& cells, const std::filesystem::path& path) {
  std::map<std::uint8_t, std::uint64_t> unknown;
  std::uint64_t filling = 0;
  for (const std::uint8_t number : cells.kinds) {
    const ForeignKindOfCell* kind = kind_numbered(number);
    if (kind == nullptr)
      ++unknown[number];
    else if (kind->fills_space)
      ++filling;
  }
  if (!unknown.empty())
    refuse_input(path, "cells",
                 concat(unknown.begin()->second, " cells of VTK's kind ", static_cast<int>(unknown.begin()->first)),
                 "kinds 0 to 16, 21 to 37, 42 or 68 to 74", Trouble::unsupported);
  return filling;
}

void check_nodes(const ForeignCells& cells, std::uint64_t cell, std::uint64_t point_count,
                 const std::filesystem::path& path) {
  const ForeignKindOfCell& kind = *kind_numbered(cells.kinds[cell]);
  const std::uint64_t begin = cells.offsets[cell], end = cells.offsets[cell + 1];
  if (kind.node_count != 0 && end - begin != static_cast<std::uint64_t>(kind.node_count))
    refuse_input(path, concat("cell ", cell), concat(end - begin, " corners"),
                 concat(kind.node_count, ", as ", kind.plural, " have"));
  if (kind.number == static_cast<std::uint8_t>(CellKind::polyhedron)) return;  // a stream with counts between the nodes
  for (std::uint64_t i = begin; i < end; ++i)
    if (cells.nodes[i] >= point_count)
      refuse_input(path, concat("cell ", cell), concat("point ", static_cast<std::int64_t>(cells.nodes[i])),
                   concat("0 to ", point_count - 1));
}

void keep_values(NeutralField& field, const Array<std::uint64_t>& kept) {
  const auto components = static_cast<std::size_t>(field.component_count);
  for (std::size_t to = 0; to < kept.size(); ++to)
    for (std::size_t c = 0; c < components; ++c)
      field.values[to * components + c] = field.values[kept[to] * components + c];
  field.values.resize(kept.size() * components);
}

}  // namespace

bool fits_single_precision(const Array<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) {
    return value != value || static_cast<double>(static_cast<float>(value)) == value;
  });
}

void check_field(const NeutralField& field, std::uint64_t owners, const std::filesystem::path& path) {
  const std::uint64_t expected = owners * static_cast<std::uint64_t>(field.component_count);
  if (field.values.size() != expected)
    refuse_input(path, concat("array '", field.name, "'"), concat(field.values.size(), " numbers"),
                 concat(expected, ", ", field.component_count, " for each of ", owners));
}

void take_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path) {
  check_offsets(cells, path);
  for (const NeutralField& field : mesh.point_fields) check_field(field, mesh.points.size(), path);
  for (const NeutralField& field : mesh.cell_fields) check_field(field, cells.kinds.size(), path);
  const std::uint64_t filling = count_of_filling(cells, path);
  if (filling == 0)
    throw Error(
        Trouble::invalid,
        concat(path.string(), ", cells: found ", cells.kinds.empty() ? "none" : census_of_left_out(cells),
               "; expected at least one that fills space"),
        cells.kinds.empty() ? "" : "a closed surface in .ply, .stl, .obj or .off: rhoray tetrahedralize fills it");

  Array<std::uint64_t> kept;
  if (filling != cells.kinds.size()) {
    kept.reserve(filling);
    mesh.notes.push_back(census_of_left_out(cells) + " left out: only cells that fill space are kept");
  }
  mesh.kinds.reserve(filling);
  mesh.cell_offsets.assign(1, 0);
  mesh.cell_offsets.reserve(filling + 1);
  std::uint64_t node_count = 0;  // kept nodes move down in place
  for (std::uint64_t cell = 0; cell < cells.kinds.size(); ++cell) {
    if (!kind_numbered(cells.kinds[cell])->fills_space) continue;
    check_nodes(cells, cell, mesh.points.size(), path);
    for (std::uint64_t i = cells.offsets[cell]; i < cells.offsets[cell + 1]; ++i)
      cells.nodes[node_count++] = cells.nodes[i];
    mesh.kinds.push_back(static_cast<CellKind>(cells.kinds[cell]));
    mesh.cell_offsets.push_back(node_count);
    if (filling != cells.kinds.size()) kept.push_back(cell);
  }
  cells.nodes.resize(node_count);
  mesh.cell_nodes = std::move(cells.nodes);
  if (filling == cells.kinds.size()) return;
  for (NeutralField& field : mesh.cell_fields) keep_values(field, kept);
  mesh.cell_ids = std::move(kept);
}

}  // namespace rhoray::preprocess

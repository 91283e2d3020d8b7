#include "preprocess/import/mesh_cells.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "preprocess/import/foreign_file.h"

namespace rhoray::preprocess {
namespace {

constexpr std::uint8_t tetrahedron = 10;

struct CellKind {
  std::uint8_t number;
  std::string_view plural;
  bool fills_space;
};

/// VTK's cell kinds (vtkCellType.h); others are reported by their number and refused.
constexpr CellKind cell_kinds[] = {
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
    {10, "tetrahedra", true},
    {11, "voxels", true},
    {12, "hexahedra", true},
    {13, "wedges", true},
    {14, "pyramids", true},
    {15, "pentagonal prisms", true},
    {16, "hexagonal prisms", true},
    {21, "quadratic lines", false},
    {22, "quadratic triangles", false},
    {23, "quadratic quadrilaterals", false},
    {24, "quadratic tetrahedra", true},
    {25, "quadratic hexahedra", true},
    {26, "quadratic wedges", true},
    {27, "quadratic pyramids", true},
    {28, "biquadratic quadrilaterals", false},
    {29, "triquadratic hexahedra", true},
    {30, "quadratic-linear quadrilaterals", false},
    {31, "quadratic-linear wedges", true},
    {32, "biquadratic-quadratic wedges", true},
    {33, "biquadratic-quadratic hexahedra", true},
    {34, "biquadratic triangles", false},
    {35, "cubic lines", false},
    {36, "quadratic polygons", false},
    {42, "polyhedra", true},
    {68, "Lagrange curves", false},
    {69, "Lagrange triangles", false},
    {70, "Lagrange quadrilaterals", false},
    {71, "Lagrange tetrahedra", true},
    {72, "Lagrange hexahedra", true},
    {73, "Lagrange wedges", true},
    {74, "Lagrange pyramids", true},
};

const CellKind* kind_numbered(std::uint8_t number) {
  const auto found = std::find_if(std::begin(cell_kinds), std::end(cell_kinds),
                                  [&](const CellKind& kind) { return kind.number == number; });
  return found == std::end(cell_kinds) ? nullptr : found;
}

/// "12 hexahedra, 3 pyramids" of the cells that fill space, or of those that do not, tetrahedra aside.
std::string census(const ForeignCells& cells, bool of_filling) {
  std::map<std::string, std::uint64_t> counts;
  for (const std::uint8_t number : cells.kinds) {
    const CellKind* kind = kind_numbered(number);
    if (number == tetrahedron || (kind == nullptr || kind->fills_space) != of_filling) continue;
    ++counts[kind == nullptr ? concat("cells of VTK's kind ", static_cast<int>(number)) : std::string(kind->plural)];
  }
  std::string text;
  for (const auto& [name, count] : counts) text += concat(text.empty() ? "" : ", ", count, " ", name);
  return text;
}

void check_offsets(const ForeignCells& cells, const std::filesystem::path& path) {
  if (cells.offsets.size() != cells.kinds.size() + 1)
    refuse_input(path, "cells", concat(cells.kinds.size(), " kinds for ", cells.offsets.size() - 1, " cells"),
                 "one kind for each cell");
  if (cells.offsets.front() != 0 || cells.offsets.back() != cells.corners.size() ||
      !std::is_sorted(cells.offsets.begin(), cells.offsets.end()))
    refuse_input(path, "cells", "offsets that do not fit the corners",
                 "offsets rising from 0 to the number of corners");
}

std::array<std::uint64_t, 4> corners_of(const ForeignCells& cells, std::uint64_t cell, std::uint64_t point_count,
                                        const std::filesystem::path& path) {
  const std::uint64_t begin = cells.offsets[cell], count = cells.offsets[cell + 1] - begin;
  const std::string place = concat("cell ", cell);
  if (count != 4) refuse_input(path, place, concat(count, " corners"), "4 corners of a tetrahedron");
  std::array<std::uint64_t, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    corners[k] = cells.corners[begin + k];
    if (corners[k] >= point_count)
      refuse_input(path, place, concat("point ", static_cast<std::int64_t>(corners[k])),
                   concat("0 to ", point_count - 1));
  }
  return corners;
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

void keep_tetrahedra(NeutralMesh& mesh, const ForeignCells& cells, const std::filesystem::path& path) {
  check_offsets(cells, path);
  for (const NeutralField& field : mesh.point_fields) check_field(field, mesh.points.size(), path);
  for (const NeutralField& field : mesh.cell_fields) check_field(field, cells.kinds.size(), path);
  if (const std::string others = census(cells, true); !others.empty())
    refuse_input(path, "cells", others, "linear tetrahedra only", Trouble::unsupported);

  Array<std::uint64_t> kept;
  for (std::uint64_t cell = 0; cell < cells.kinds.size(); ++cell) {
    if (cells.kinds[cell] != tetrahedron) continue;
    mesh.cells.push_back(corners_of(cells, cell, mesh.points.size(), path));
    kept.push_back(cell);
  }
  if (mesh.cells.empty())
    refuse_input(path, "cells", cells.kinds.empty() ? "none" : census(cells, false), "at least one tetrahedron");
  if (kept.size() == cells.kinds.size()) return;
  for (NeutralField& field : mesh.cell_fields) keep_values(field, kept);
  mesh.cell_ids = std::move(kept);
  mesh.notes.push_back(census(cells, false) + " left out: only tetrahedra are kept");
}

}  // namespace rhoray::preprocess

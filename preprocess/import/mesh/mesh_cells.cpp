#include "preprocess/import/mesh/mesh_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// A cell kind as stored in a file: VTK's number (vtkCellType.h), and the number of nodes per cell.
struct ForeignKindOfCell {
  std::uint8_t number;
  std::string_view plural;
  bool fills_space;
  int node_count = 0;  ///< 0: variable, checked where the cell is split
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

/// Index of the row above for each number; -1: unknown.
constexpr std::array<std::int8_t, 256> rows_by_number = [] {
  std::array<std::int8_t, 256> rows{};
  rows.fill(-1);
  for (std::size_t row = 0; row < std::size(kinds_of_cells); ++row)
    rows[kinds_of_cells[row].number] = static_cast<std::int8_t>(row);
  return rows;
}();

const ForeignKindOfCell* kind_numbered(std::uint8_t number) {
  const std::int8_t row = rows_by_number[number];
  return row < 0 ? nullptr : &kinds_of_cells[row];
}

/// "triangle" for "triangles", "quadratic pyramid of 14 nodes" for "quadratic pyramids of 14
/// nodes".
std::string singular_of(std::string_view plural) {
  const std::size_t end = std::min(plural.find(" of "), plural.size());
  std::string name(plural.substr(0, end));
  if (name.ends_with("vertices"))
    name.replace(name.size() - 4, 4, "ex");
  else if (name.ends_with("hedra"))
    name.replace(name.size() - 1, 1, "on");
  else if (name.ends_with('s'))
    name.pop_back();
  return name + std::string(plural.substr(end));
}

std::string in_words(const std::map<std::string_view, std::uint64_t>& counts) {
  std::string text;
  for (const auto& [name, count] : counts)
    text += concat(text.empty() ? "" : ", ", count_text(count, singular_of(name), name));
  return text;
}

void check_kinds(const ForeignCells& cells, const std::filesystem::path& path) {
  std::map<std::uint8_t, std::uint64_t> unknown;
  for (const std::uint8_t number : cells.kinds)
    if (kind_numbered(number) == nullptr) ++unknown[number];
  if (!unknown.empty())
    refuse_input(path, "cells",
                 concat(count_text(unknown.begin()->second, "cell", "cells"), " of VTK's kind ",
                        static_cast<int>(unknown.begin()->first)),
                 "kinds 0 to 16, 21 to 37, 42 or 68 to 74", ErrorCode::unsupported);
}

void check_ghosts(const Array<std::uint8_t>& ghosts, std::uint64_t owners, const std::filesystem::path& path) {
  if (!ghosts.empty() && ghosts.size() != owners)
    refuse_input(path, "array 'vtkGhostType'", concat(ghosts.size(), " numbers"), concat(owners));
}

using Nodes = std::span<const std::uint64_t>;

/// Calls act(node) for each node of a cell of any kind. Refuses a polyhedron's stream that does not
/// hold faces.
template <class Act>
void for_each_node(const ForeignKindOfCell& kind, Nodes nodes, std::uint64_t cell, const std::filesystem::path& path,
                   Act&& act) {
  if (kind.number != static_cast<std::uint8_t>(CellKind::polyhedron)) {
    for (const std::uint64_t node : nodes) act(node);
    return;
  }
  const auto refuse = [&](const auto& found, std::string_view expected) {
    refuse_input(path, concat("polyhedron ", cell), found, expected);
  };
  if (nodes.empty()) refuse("no faces", "the stream of its faces");
  if (nodes[0] < 4) refuse(concat(nodes[0], " faces"), "at least 4");
  std::size_t at = 1;
  for (std::uint64_t face = 0; face < nodes[0]; ++face) {
    if (at == nodes.size()) refuse(concat("the end of its stream at face ", face), concat(nodes[0], " faces"));
    const std::uint64_t corners = nodes[at++];
    if (corners < 3 || corners > nodes.size() - at)
      refuse(concat(static_cast<std::int64_t>(corners), " corners of face ", face),
             concat("3 to ", nodes.size() - at, ", as many numbers as its stream still has"));
    for (const std::uint64_t node : nodes.subspan(at, corners)) act(node);
    at += corners;
  }
  if (at != nodes.size()) refuse(concat(nodes.size() - at, " numbers behind its last face"), "none");
}

/// True when one of the nodes is hidden. Refuses nodes that do not fit the kind.
bool has_hidden_point(const ForeignCells& cells, std::uint64_t cell, std::uint64_t point_count,
                      const std::filesystem::path& path) {
  const ForeignKindOfCell& kind = *kind_numbered(cells.kinds[cell]);
  const Nodes nodes = Nodes(cells.nodes).subspan(cells.offsets[cell], cells.offsets[cell + 1] - cells.offsets[cell]);
  if (kind.node_count != 0 && nodes.size() != static_cast<std::size_t>(kind.node_count))
    refuse_input(path, concat("cell ", cell), concat(nodes.size(), " corners"),
                 concat(kind.node_count, ", as ", kind.plural, " have"));
  bool is_hidden = false;
  for_each_node(kind, nodes, cell, path, [&](std::uint64_t node) {
    if (node >= point_count)
      refuse_input(path, concat("cell ", cell), concat("point ", static_cast<std::int64_t>(node)),
                   concat("0 to ", point_count - 1));
    if (!cells.point_ghosts.empty()) is_hidden |= (cells.point_ghosts[node] & ghost_hidden_point) != 0;
  });
  return is_hidden;
}

/// True when a cell is left out; counts the reason.
bool is_left_out(const ForeignCells& cells, std::uint64_t cell, std::uint64_t point_count, LeftOut& left_out,
                 const std::filesystem::path& path) {
  const ForeignKindOfCell& kind = *kind_numbered(cells.kinds[cell]);
  const std::uint8_t ghost = cells.ghosts.empty() ? std::uint8_t{0} : cells.ghosts[cell];
  const auto leave_out = [](std::uint64_t& counter) {
    ++counter;
    return true;
  };
  if (!kind.fills_space) return leave_out(left_out.not_filling[kind.plural]);
  const bool has_hidden = has_hidden_point(cells, cell, point_count, path);
  if ((ghost & ghost_duplicate) != 0) return leave_out(left_out.duplicates);
  if ((ghost & ghost_refined) != 0) return leave_out(left_out.refined);
  if ((ghost & ghost_hidden_cell) != 0) return leave_out(left_out.hidden);
  return has_hidden && leave_out(left_out.blanked);
}

void keep_values(NeutralField& field, const Array<std::uint64_t>& kept) {
  const auto components = static_cast<std::size_t>(field.component_count);
  for (std::size_t to = 0; to < kept.size(); ++to)
    for (std::size_t c = 0; c < components; ++c)
      field.values[to * components + c] = field.values[kept[to] * components + c];
  field.values.resize(kept.size() * components);
}

}  // namespace

void check_offsets(const ForeignCells& cells, const std::filesystem::path& path) {
  if (cells.offsets.size() != cells.kinds.size() + 1)
    refuse_input(
        path, "cells",
        concat(cells.kinds.size(), " kinds for ", static_cast<std::int64_t>(cells.offsets.size()) - 1, " cells"),
        "one kind for each cell");
  if (cells.offsets.front() != 0 || cells.offsets.back() != cells.nodes.size() ||
      !std::is_sorted(cells.offsets.begin(), cells.offsets.end()))
    refuse_input(path, "cells", "offsets that do not fit the corners",
                 "offsets rising from 0 to the number of corners");
}

bool fits_single_precision(const Array<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) {
    return value != value || static_cast<double>(static_cast<float>(value)) == value;
  });
}

NeutralField field_of(std::string name, Array<double> values, int component_count) {
  const bool is_single = fits_single_precision(values);
  return {.name = std::move(name),
          .unit = {},
          .component_count = component_count,
          .was_single_precision = is_single,
          .values = std::move(values)};
}

void note_precision(NeutralField& field, formats::ElementType type, std::vector<std::string>& notes) {
  using formats::ElementType;
  field.was_single_precision = type != ElementType::F64 && fits_single_precision(field.values);
  const bool is_wide = type == ElementType::I64 || type == ElementType::U64;
  constexpr double largest_exact = 9007199254740992.0;  // 2^53
  if (is_wide && std::any_of(field.values.begin(), field.values.end(),
                             [](double value) { return std::abs(value) > largest_exact; }))
    notes.push_back(concat("field '", field.name, "' holds integers beyond 2^53, which were rounded"));
}

void check_field(const NeutralField& field, std::uint64_t owners, const std::filesystem::path& path) {
  const std::uint64_t expected = owners * static_cast<std::uint64_t>(field.component_count);
  if (field.values.size() != expected)
    refuse_input(path, concat("array '", field.name, "'"), concat(field.values.size(), " numbers"),
                 concat(expected, ", ", field.component_count, " for each of ", owners));
}

void LeftOut::include(const LeftOut& other) {
  for (const auto& [name, count] : other.not_filling) not_filling[name] += count;
  duplicates += other.duplicates;
  refined += other.refined;
  hidden += other.hidden;
  blanked += other.blanked;
}

void renew_lagrange_hexahedra(ForeignCells& cells, const std::filesystem::path& path) {
  for (std::size_t cell = 0; cell < cells.kinds.size() && cell + 1 < cells.offsets.size(); ++cell) {
    if (cells.kinds[cell] != static_cast<std::uint8_t>(CellKind::lagrange_hexahedron)) continue;
    const std::uint64_t begin = cells.offsets[cell], count = cells.offsets[cell + 1] - begin;
    const auto degree = static_cast<std::uint64_t>(std::llround(std::cbrt(static_cast<double>(count)))) - 1;
    if (begin > cells.nodes.size() || count > cells.nodes.size() - begin || count < 8 ||
        (degree + 1) * (degree + 1) * (degree + 1) != count)
      refuse_input(path, concat("cell ", cell), concat(static_cast<std::int64_t>(count), " corners"),
                   "those of a Lagrange hexahedron with the same degree along each axis", ErrorCode::unsupported);
    const auto third = cells.nodes.begin() + static_cast<std::ptrdiff_t>(begin + 8 + 10 * (degree - 1));
    std::swap_ranges(third, third + static_cast<std::ptrdiff_t>(degree - 1),
                     third + static_cast<std::ptrdiff_t>(degree - 1));
  }
}

LeftOut sift_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path) {
  check_offsets(cells, path);
  check_kinds(cells, path);
  check_ghosts(cells.ghosts, cells.kinds.size(), path);
  check_ghosts(cells.point_ghosts, mesh.points.size(), path);
  for (const NeutralField& field : mesh.point_fields) check_field(field, mesh.points.size(), path);
  for (const NeutralField& field : mesh.cell_fields) check_field(field, cells.kinds.size(), path);

  LeftOut left_out;
  Array<std::uint64_t>& ids = mesh.cell_ids;
  mesh.kinds.reserve(cells.kinds.size());
  mesh.cell_offsets.assign(1, 0);
  mesh.cell_offsets.reserve(cells.offsets.size());
  std::uint64_t node_count = 0;  // kept nodes move down in place
  for (std::uint64_t cell = 0; cell < cells.kinds.size(); ++cell) {
    if (is_left_out(cells, cell, mesh.points.size(), left_out, path)) {
      if (ids.empty() && cell == mesh.kinds.size()) {  // first cell left out
        ids.resize(cell);
        std::iota(ids.begin(), ids.end(), std::uint64_t{0});
      }
      continue;
    }
    for (std::uint64_t i = cells.offsets[cell]; i < cells.offsets[cell + 1]; ++i)
      cells.nodes[node_count++] = cells.nodes[i];
    if (cell != mesh.kinds.size()) ids.push_back(cell);
    mesh.kinds.push_back(static_cast<CellKind>(cells.kinds[cell]));
    mesh.cell_offsets.push_back(node_count);
  }
  cells.nodes.resize(node_count);
  mesh.cell_nodes = std::move(cells.nodes);
  if (mesh.kinds.size() != cells.kinds.size())
    for (NeutralField& field : mesh.cell_fields) keep_values(field, ids);
  return left_out;
}

void finish_cells(CellMesh& mesh, const LeftOut& left_out, const std::filesystem::path& path) {
  std::vector<std::string> notes;
  const auto note = [&](std::uint64_t count, const char* singular, const char* plural, const char* text) {
    if (count > 0) notes.push_back(concat(count_text(count, singular, plural), text));
  };
  if (!left_out.not_filling.empty())
    notes.push_back(in_words(left_out.not_filling) + " left out: only cells that fill space are kept");
  note(left_out.duplicates, "ghost cell", "ghost cells", " left out; another piece has the same");
  note(left_out.refined, "refined cell", "refined cells", " left out; finer cells are used instead");
  note(left_out.hidden, "hidden cell", "hidden cells", " left out");
  note(left_out.blanked, "cell", "cells", " with a hidden point left out");
  if (mesh.kinds.empty()) {
    std::string found = in_words(left_out.not_filling);
    const bool is_surface = !found.empty();
    if (found.empty()) found = notes.empty() ? "none" : notes.front();
    throw Error(ErrorCode::invalid,
                concat(path.string(), ", cells: found ", found, "; expected at least one that fills space"),
                is_surface ? "a closed surface in .ply, .stl, .obj or .off: rhoray tetrahedralize fills it" : "");
  }
  mesh.notes.insert(mesh.notes.end(), notes.begin(), notes.end());
}

void take_cells(CellMesh& mesh, ForeignCells cells, const std::filesystem::path& path) {
  finish_cells(mesh, sift_cells(mesh, std::move(cells), path), path);
}

}  // namespace rhoray::preprocess

// Meshes of CARP: points in .pts, and beside them cells in .elem or tetrahedra in .tet. Each file
// begins with its count; points count from 0.
// Source: openCARP's user manual.

#include <algorithm>
#include <array>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

/// A word of .elem files: nodes of such a cell, and VTK's kind.
struct CellWord {
  std::string_view word;
  std::size_t node_count;
  std::uint8_t kind;
};
constexpr CellWord cell_words[] = {{"Ln", 2, 3},  {"Tr", 3, 5},  {"Qd", 4, 9}, {"Tt", 4, 10},
                                   {"Py", 5, 14}, {"Pr", 6, 13}, {"Hx", 8, 12}};

/// Programs order the upper nodes of these cells in two ways: as VTK, or the other way round from
/// the second node on.
struct UpperNodes {
  CellKind kind;
  std::size_t first, count;  ///< the upper nodes; as many lower ones stand below
};
constexpr UpperNodes upper_nodes[] = {{CellKind::wedge, 3, 3}, {CellKind::hexahedron, 4, 4}};

/// The file of points, and that of cells.
struct Pair {
  fs::path points, cells;
};

Pair pair_of(const fs::path& path) {
  const auto partner = [&](const char* extension) { return fs::path(path).replace_extension(extension); };
  if (extension_of(path) != ".pts") return {partner(".pts"), path};
  for (const char* extension : {".elem", ".tet"})
    if (is_there(partner(extension))) return {path, partner(extension)};
  throw Error(ErrorCode::unreadable, concat(path.string(), ": holds points alone; expected their cells in ",
                                            partner(".elem").filename().string(), " or .tet"));
}

std::uint64_t count_in(LineReader& lines, std::string_view what) {
  lines.need(what);
  if (lines.words().size() != 1) lines.refuse(concat(lines.words().size(), " words"), what);
  return lines.number<std::uint64_t>(0, what);
}

Array<std::array<double, 3>> read_points(const fs::path& path, std::vector<std::string>& notes) {
  const ForeignFile file(path);
  LineReader lines(file, WordEnds::at_spaces);
  const std::uint64_t count = count_in(lines, "a number of points");
  Array<std::array<double, 3>> points;
  for (std::uint64_t i = 0; i < count; ++i) {
    lines.need(concat(count, " points"));
    points.push_back(lines.point(0));
  }
  lines.note_rest("points", notes);
  return points;
}

const CellWord& word_of(const LineReader& lines) {
  const auto* found = std::find_if(std::begin(cell_words), std::end(cell_words),
                                   [&](const CellWord& row) { return row.word == lines.words().front(); });
  if (found == std::end(cell_words))
    lines.refuse(lines.words().front(), "Ln, Tr, Qd, Tt, Py, Pr or Hx", ErrorCode::unsupported);
  return *found;
}

/// @param regions  receives each cell's region; 0 where the file gives none
ForeignCells read_cells(const fs::path& path, Array<double>& regions, std::vector<std::string>& notes) {
  const ForeignFile file(path);
  LineReader lines(file, WordEnds::at_spaces);
  const bool has_words = extension_of(path) == ".elem";
  const std::uint64_t count = count_in(lines, "a number of cells");
  ForeignCells cells{.kinds = {}, .offsets = {0}, .nodes = {}};
  for (std::uint64_t i = 0; i < count; ++i) {
    lines.need(concat(count, " cells"));
    const CellWord& cell = has_words ? word_of(lines) : cell_words[3];
    const std::size_t first = has_words ? 1 : 0, end = first + cell.node_count;
    for (std::size_t k = first; k < end; ++k) cells.nodes.push_back(lines.number<std::uint64_t>(k, "a point"));
    regions.push_back(lines.words().size() > end ? lines.number<double>(end, "a region") : 0);
    cells.offsets.push_back(cells.nodes.size());
    cells.kinds.push_back(cell.kind);
  }
  lines.note_rest("cells", notes);
  return cells;
}

/// The sum of the squared distances from each upper node to the lower node below it, as VTK orders
/// them or the other way round. Nodes that do not exist are refused later.
double height(const CellMesh& mesh, std::span<const std::uint64_t> nodes, const UpperNodes& upper, bool turned) {
  double sum = 0;
  for (std::size_t k = 0; k < upper.count; ++k) {
    const std::uint64_t a = nodes[k], b = nodes[upper.first + (turned ? (upper.count - k) % upper.count : k)];
    if (a >= mesh.points.size() || b >= mesh.points.size()) return 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double along = mesh.points[a][axis] - mesh.points[b][axis];
      sum += along * along;
    }
  }
  return sum;
}

/// Puts the upper nodes of wedges and hexahedra into VTK's order. The positions tell how the file
/// orders them: upright edges are shorter than diagonals.
void order_upper_nodes(CellMesh& mesh, ForeignCells& cells) {
  for (const UpperNodes& upper : upper_nodes) {
    const auto for_each = [&](const auto& act) {
      for (std::size_t c = 0; c < cells.kinds.size(); ++c)
        if (cells.kinds[c] == static_cast<std::uint8_t>(upper.kind))
          act(std::span(cells.nodes).subspan(cells.offsets[c], 2 * upper.count));
    };
    double as_vtk = 0, turned = 0;
    for_each([&](std::span<const std::uint64_t> nodes) {
      as_vtk += height(mesh, nodes, upper, false);
      turned += height(mesh, nodes, upper, true);
    });
    if (!(turned < as_vtk)) continue;
    for_each([&](std::span<std::uint64_t> nodes) {
      std::reverse(nodes.begin() + static_cast<std::ptrdiff_t>(upper.first) + 1, nodes.end());
    });
    mesh.notes.push_back(concat(upper.kind == CellKind::wedge ? "wedges" : "hexahedra",
                                ": the upper nodes run the other way round than the lower ones, judged by their "
                                "positions"));
  }
}

}  // namespace

CellMesh read_carp(const fs::path& path) {
  const Pair pair = pair_of(path);
  CellMesh mesh;
  mesh.points = read_points(pair.points, mesh.notes);
  Array<double> regions;
  ForeignCells cells = read_cells(pair.cells, regions, mesh.notes);
  order_upper_nodes(mesh, cells);
  mesh.cell_fields.push_back(field_of("region", std::move(regions)));
  take_cells(mesh, std::move(cells), pair.cells);
  return mesh;
}

}  // namespace rhoray::preprocess

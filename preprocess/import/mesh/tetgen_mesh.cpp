#include <algorithm>
#include <cmath>
#include <utility>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/mesh/tetgen_text.h"
#include "preprocess/import/reading/families.h"

namespace rhoray::preprocess {
namespace {

/// Makes fields of the attributes.
void take_attributes(std::vector<NeutralField>& fields, std::vector<Array<double>>& attributes) {
  for (std::size_t a = 0; a < attributes.size(); ++a)
    fields.push_back(field_of(concat("attribute_", a + 1), std::move(attributes[a])));
}

/// Index of VTK's node i of a 10-node tetrahedron in a record.
using NodeOrder = std::array<std::size_t, 10>;

/// The orders of Chaste and of TetGen 1.5's -o2: midpoints of 2-3, 0-3, 0-1, 1-2, 1-3, 0-2. Files
/// do not say which they use.
constexpr NodeOrder node_orders[] = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, {0, 1, 2, 3, 6, 7, 9, 5, 8, 4}};
// edges of VTK's nodes 4 to 9
constexpr std::size_t edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// Distance of the mid-edge nodes from the midpoints of the edges that an order assigns to them:
/// the mean of squared distance over squared edge length. Edges of zero length are skipped.
double distance_from_middles(const CellMesh& mesh, std::span<const std::uint64_t> nodes, const NodeOrder& order) {
  double sum = 0, count = 0;
  for (std::size_t first = 0; first < nodes.size(); first += order.size())
    for (std::size_t e = 0; e < 6; ++e) {
      const auto &a = mesh.points[nodes[first + edges[e][0]]], &b = mesh.points[nodes[first + edges[e][1]]],
                 &middle = mesh.points[nodes[first + order[4 + e]]];
      double apart = 0, length = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double off = middle[axis] - (a[axis] + b[axis]) / 2, along = b[axis] - a[axis];
        apart += off * off;
        length += along * along;
      }
      if (!(length > 0) || !std::isfinite(apart / length)) continue;
      sum += apart / length;
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

/// If mid-edge nodes are farther than this from their midpoints, in edge lengths (root mean
/// square), the order is unknown.
constexpr double farthest = 0.25;

/// Puts the nodes of 10-node tetrahedra into VTK's order; infers the file's order from the
/// geometry.
void order_nodes(CellMesh& mesh, Array<std::uint64_t>& nodes, const std::filesystem::path& path) {
  const double distances[] = {distance_from_middles(mesh, nodes, node_orders[0]),
                              distance_from_middles(mesh, nodes, node_orders[1])};
  const std::size_t best = distances[1] < distances[0] ? 1 : 0;
  if (distances[best] > farthest * farthest)
    refuse_input(path, "tetrahedra",
                 concat("middle nodes that lie ", std::sqrt(distances[best]), " edge lengths from the middles"),
                 concat("at most ", farthest, ", in one of the two orders that are known"));
  mesh.notes.push_back(concat("edge nodes of tetrahedra are in the order of ", best == 1 ? "TetGen 1.5" : "Chaste",
                              ", judged by their positions"));
  for (std::size_t first = 0; first < nodes.size(); first += 10) {
    std::array<std::uint64_t, 10> given;
    std::copy_n(nodes.begin() + static_cast<std::ptrdiff_t>(first), 10, given.begin());
    for (std::size_t i = 0; i < 10; ++i) nodes[first + i] = given[node_orders[best][i]];
  }
}

/// The records of an .ele file, whose first line is the current line.
struct Tetrahedra {
  std::uint64_t count = 0, node_count = 4, attribute_count = 0;
  Array<std::uint64_t> nodes;
  std::vector<Array<double>> attributes;
};

void read_binary_records(Tetrahedra& result, const LineReader& lines, const TetgenPoints& points) {
  TetgenBinary records(lines, result.count,
                       result.node_count * sizeof(std::uint32_t) + result.attribute_count * sizeof(double));
  for (std::uint64_t i = 0; i < result.count; ++i) {
    for (std::uint64_t k = 0; k < result.node_count; ++k)
      result.nodes.push_back(tetgen_corner(lines, records.next<std::uint32_t>(), points));
    for (Array<double>& values : result.attributes) values.push_back(records.next<double>());
  }
}

void read_text_records(Tetrahedra& result, LineReader& lines, const TetgenPoints& points) {
  for (std::uint64_t i = 0; i < result.count; ++i) {
    lines.need(concat(result.count, " tetrahedra"));
    const std::int64_t expected = points.first_number + static_cast<std::int64_t>(i);
    if (lines.number<std::int64_t>(0, "a tetrahedron's number") != expected)
      lines.refuse(lines.words()[0], concat(expected));
    for (std::uint64_t k = 0; k < result.node_count; ++k)
      result.nodes.push_back(tetgen_corner(lines, std::size_t{1 + k}, points));
    for (std::uint64_t a = 0; a < result.attribute_count; ++a)
      result.attributes[a].push_back(
          lines.number<double>(1 + result.node_count + a, concat(result.attribute_count, " attributes")));
  }
}

Tetrahedra read_records(const std::filesystem::path& path, const TetgenPoints& points,
                        std::vector<std::string>& notes) {
  const ForeignFile file(path);
  LineReader lines(file);
  lines.need("a number of tetrahedra");
  const bool is_binary = is_tetgen_binary(lines);
  const std::size_t word_count = lines.words().size() - (is_binary ? 1 : 0);
  Tetrahedra result;
  result.count = tetgen_count(lines, "a number of tetrahedra");
  if (result.count == 0) lines.refuse("0 tetrahedra", "at least 1");
  if (word_count > 1) result.node_count = lines.number<std::uint64_t>(1, "a number of corners");
  if (result.node_count != 4 && result.node_count != 10)
    lines.refuse(concat(result.count, " elements with ", result.node_count, " points"),
                 "tetrahedra with 4 points or 10", ErrorCode::unsupported);
  if (word_count > 2) result.attribute_count = lines.number<std::uint64_t>(2, "a number of attributes");
  if (result.attribute_count > 1024) lines.refuse(lines.words()[2], "at most 1024 attributes");
  result.attributes.resize(result.attribute_count);
  if (is_binary)
    read_binary_records(result, lines, points);
  else
    read_text_records(result, lines, points);
  if (!is_binary) lines.note_rest("tetrahedra", notes);
  return result;
}

void read_tetrahedra(CellMesh& mesh, const TetgenPoints& points, const std::filesystem::path& path) {
  Tetrahedra tetrahedra = read_records(path, points, mesh.notes);
  const bool is_quadratic = tetrahedra.node_count == 10;
  if (is_quadratic) order_nodes(mesh, tetrahedra.nodes, path);
  ForeignCells cells;
  cells.kinds.assign(tetrahedra.count,
                     static_cast<std::uint8_t>(is_quadratic ? CellKind::quadratic_tetrahedron : CellKind::tetrahedron));
  for (std::uint64_t i = 0; i <= tetrahedra.count; ++i) cells.offsets.push_back(i * tetrahedra.node_count);
  cells.nodes = std::move(tetrahedra.nodes);
  take_attributes(mesh.cell_fields, tetrahedra.attributes);
  take_cells(mesh, std::move(cells), path);
}

/// Refuses a .node file without the matching .ele file: it holds points only, the .ele file its
/// tetrahedra.
void require_tetrahedra(const std::filesystem::path& node, const std::filesystem::path& ele) {
  std::error_code ignored;
  if (std::filesystem::exists(ele, ignored)) return;
  const std::filesystem::path face = std::filesystem::path(node).replace_extension(".face");
  throw Error(ErrorCode::unreadable,
              concat(node.string(), ": holds points alone; expected their tetrahedra in ", ele.filename().string()),
              std::filesystem::exists(face, ignored) ? concat("the surface beside it can be filled: ", face.string())
                                                     : std::string());
}

}  // namespace

CellMesh read_tetgen_mesh(const std::filesystem::path& path) {
  const auto partner = [&](const char* extension) { return std::filesystem::path(path).replace_extension(extension); };
  const bool is_node = extension_of(path) == ".node";
  if (is_node) require_tetrahedra(path, partner(".ele"));
  TetgenPoints points = read_tetgen_node_file(is_node ? path : partner(".node"));
  CellMesh mesh;
  mesh.points = points.points;
  mesh.notes = points.notes;
  take_attributes(mesh.point_fields, points.attributes);
  read_tetrahedra(mesh, points, is_node ? partner(".ele") : path);
  return mesh;
}

}  // namespace rhoray::preprocess

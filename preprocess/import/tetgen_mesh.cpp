#include <utility>

#include "preprocess/import/families.h"
#include "preprocess/import/mesh_cells.h"
#include "preprocess/import/tetgen_text.h"

namespace rhoray::preprocess {
namespace {

NeutralField attribute_field(std::size_t index, Array<double> values) {
  NeutralField field;
  field.name = concat("attribute_", index + 1);
  field.values = std::move(values);
  field.was_single_precision = fits_single_precision(field.values);
  return field;
}

void read_tetrahedra(CellMesh& mesh, const TetgenPoints& points, const std::filesystem::path& path) {
  const ForeignFile file(path);
  LineReader lines(file);
  lines.need("a number of tetrahedra");
  if (lines.words().back() == "BIN") lines.refuse("BIN: numbers in binary", "a text file", Trouble::unsupported);
  const std::uint64_t count = tetgen_count(lines, "a number of tetrahedra");
  if (count == 0) lines.refuse("0 tetrahedra", "at least 1");
  const auto corner_count = lines.words().size() > 1 ? lines.number<int>(1, "a number of corners") : 4;
  if (corner_count != 4)
    lines.refuse(concat(count, " tetrahedra with ", corner_count, " points"), "linear tetrahedra, with 4",
                 Trouble::unsupported);
  const auto attribute_count = lines.words().size() > 2 ? lines.number<std::uint64_t>(2, "a number of attributes") : 0;
  if (attribute_count > 1024) lines.refuse(lines.words()[2], "at most 1024 attributes");

  ForeignCells cells{.kinds = Array<std::uint8_t>(count, static_cast<std::uint8_t>(CellKind::tetrahedron)),
                     .offsets = {0},
                     .nodes = {}};
  std::vector<Array<double>> attributes(attribute_count);
  for (std::uint64_t i = 0; i < count; ++i) {
    lines.need(concat(count, " tetrahedra"));
    const std::int64_t expected = points.first_number + static_cast<std::int64_t>(i);
    if (lines.number<std::int64_t>(0, "a tetrahedron's number") != expected)
      lines.refuse(lines.words()[0], concat(expected));
    for (std::size_t k = 0; k < 4; ++k) cells.nodes.push_back(tetgen_corner(lines, 1 + k, points));
    cells.offsets.push_back(cells.nodes.size());
    for (std::size_t a = 0; a < attribute_count; ++a)
      attributes[a].push_back(lines.number<double>(5 + a, concat(attribute_count, " attributes")));
  }
  for (std::size_t a = 0; a < attribute_count; ++a)
    mesh.cell_fields.push_back(attribute_field(a, std::move(attributes[a])));
  take_cells(mesh, std::move(cells), path);
}

}  // namespace

CellMesh read_tetgen_mesh(const std::filesystem::path& path) {
  const auto partner = [&](const char* extension) { return std::filesystem::path(path).replace_extension(extension); };
  const bool is_node = extension_of(path) == ".node";
  TetgenPoints points = read_tetgen_node_file(is_node ? path : partner(".node"));
  CellMesh mesh;
  mesh.points = points.points;
  for (std::size_t a = 0; a < points.attributes.size(); ++a)
    mesh.point_fields.push_back(attribute_field(a, std::move(points.attributes[a])));
  read_tetrahedra(mesh, points, is_node ? partner(".ele") : path);
  return mesh;
}

}  // namespace rhoray::preprocess

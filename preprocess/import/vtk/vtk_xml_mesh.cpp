// Meshes in VTK XML files: unstructured grids (.vtu), their pieces in several files (.pvtu), and
// structured grids (.vts, .pvts).

#include <algorithm>
#include <functional>

#include "preprocess/import/mesh/mesh_pieces.h"
#include "preprocess/import/mesh/structured_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/vtk/piece_files.h"
#include "preprocess/import/vtk/structured_pieces.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
using Numbers = Array<std::uint64_t>;

/// Adds a field, or takes it as ghosts, in their form since VTK 7 or before.
void add_array(CellMesh& mesh, ForeignCells& cells, bool in_cells, const VtkXmlStream& file, const VtkXmlArray& array,
               Array<double> values) {
  const bool is_byte = array.type == ElementType::U8 && array.component_count == 1;
  const bool has_levels = is_byte && array.name == "vtkGhostLevels" && file.is_before_version(2, 0);
  if (has_levels || array.name == "vtkGhostType") {
    for (const double value : values)
      if (is_byte)
        (in_cells ? cells.ghosts : cells.point_ghosts)
            .push_back(static_cast<std::uint8_t>(has_levels ? value > 0 : value));
    return;
  }
  constexpr int most_components = 1024;
  if (array.component_count > most_components)
    file.refuse(concat("array '", array.name, "'"), concat(array.component_count, " components"),
                concat("1 to ", most_components), ErrorCode::unsupported);
  NeutralField& field = (in_cells ? mesh.cell_fields : mesh.point_fields).emplace_back();
  field.name = array.name;
  field.unit = array.unit;
  field.component_count = array.component_count;
  field.values = std::move(values);
  note_precision(field, array.type, mesh.notes);
}

/// Refuses an element Points without exactly one array, of three coordinates.
void check_points(const VtkXmlStream& file, std::size_t arrays, int components) {
  if (arrays != 1) file.refuse("element Points", concat(arrays, " arrays"), "1");
  if (components != 3) file.refuse("element Points", concat(components, " numbers for each point"), "3");
}

/// The arrays of a piece's element Cells.
class CellArrays {
 public:
  CellArrays(const VtkXmlStream& file, const XmlElement& piece)
      : file_(file), arrays_(file.arrays_in(piece.child("Cells"))) {}

  bool has(std::string_view name) const { return find(name) != arrays_.end(); }

  /// Refuses a missing array, one of several components, and one with fewer numbers.
  template <class Number = std::uint64_t>
  Array<Number> numbers(std::string_view name, std::uint64_t count) const {
    const auto found = find(name);
    if (found == arrays_.end()) file_.refuse("element Cells", concat("no array '", name, "'"), "one of this name");
    if (found->component_count != 1)
      file_.refuse(concat("array '", name, "'"), concat(found->component_count, " components"), "1");
    return file_.numbers<Number>(*found, count);
  }

 private:
  std::vector<VtkXmlArray>::const_iterator find(std::string_view name) const {
    return std::find_if(arrays_.begin(), arrays_.end(), [&](const VtkXmlArray& array) { return array.name == name; });
  }

  const VtkXmlStream& file_;
  std::vector<VtkXmlArray> arrays_;
};

/// Lists that are stored one after the other, each with its end.
struct Lists {
  Numbers ends, numbers;

  std::span<const std::uint64_t> list(std::uint64_t i, std::size_t cell, const VtkXmlStream& file) const {
    const std::uint64_t begin = i == 0 || i > ends.size() ? 0 : ends[i - 1], end = i < ends.size() ? ends[i] : 0;
    if (i >= ends.size() || begin > end || end > numbers.size())
      file.refuse(concat("polyhedron ", cell), "a place or counts of faces that are not there",
                  "those that its arrays of faces hold");
    return std::span(numbers).subspan(begin, end - begin);
  }
};

std::uint64_t last_of(const Numbers& ends) {
  return ends.empty() ? 0 : ends.back();
}

/// Appends the face stream of a polyhedron.
using AppendStream = std::function<void(std::size_t cell, Numbers& to)>;

/// Faces as VTK up to 9.3 stores them: streams one after the other, and the end of each; -1 for
/// cells of other kinds.
AppendStream face_streams(const VtkXmlStream& file, const CellArrays& arrays, std::size_t cell_count) {
  if (!arrays.has("faces") || !arrays.has("faceoffsets"))
    file.refuse("element Cells", "polyhedra without faces",
                "the arrays 'faces' and 'faceoffsets', or 'polyhedron_offsets' and those that go with it");
  Lists streams{arrays.numbers("faceoffsets", cell_count), {}};
  std::uint64_t last = 0;
  constexpr auto none = ~std::uint64_t{0};
  for (std::uint64_t& end : streams.ends) last = end = end == none ? last : end;
  streams.numbers = arrays.numbers("faces", last);
  return [&file, streams = std::move(streams)](std::size_t cell, Numbers& to) {
    const auto stream = streams.list(cell, cell, file);
    to.insert(to.end(), stream.begin(), stream.end());
  };
}

/// Faces as VTK 9.4 and later store them: each cell has a list of faces, each face a list of
/// corners.
AppendStream shared_faces(const VtkXmlStream& file, const CellArrays& arrays, std::size_t cell_count) {
  Lists cells{arrays.numbers("polyhedron_offsets", cell_count), {}};
  cells.numbers = arrays.numbers("polyhedron_to_faces", last_of(cells.ends));
  const auto last_face = std::max_element(cells.numbers.begin(), cells.numbers.end());
  Lists faces{arrays.numbers("face_offsets", last_face == cells.numbers.end() ? 0 : *last_face + 1), {}};
  faces.numbers = arrays.numbers("face_connectivity", last_of(faces.ends));
  return [&file, cells = std::move(cells), faces = std::move(faces)](std::size_t cell, Numbers& to) {
    const auto of_cell = cells.list(cell, cell, file);
    to.push_back(of_cell.size());
    for (const std::uint64_t face : of_cell) {
      const auto corners = faces.list(face, cell, file);
      to.push_back(corners.size());
      to.insert(to.end(), corners.begin(), corners.end());
    }
  };
}

/// Replaces the nodes of each polyhedron by the stream of its faces.
void put_face_streams(ForeignCells& cells, const AppendStream& append) {
  Numbers nodes;
  nodes.reserve(2 * cells.nodes.size());
  std::uint64_t begin = 0;
  for (std::size_t cell = 0; cell < cells.kinds.size(); ++cell) {
    const std::uint64_t end = cells.offsets[cell + 1];
    if (cells.kinds[cell] == static_cast<std::uint8_t>(CellKind::polyhedron))
      append(cell, nodes);
    else
      nodes.insert(nodes.end(), cells.nodes.begin() + static_cast<std::ptrdiff_t>(begin),
                   cells.nodes.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
    cells.offsets[cell + 1] = nodes.size();
  }
  cells.nodes = std::move(nodes);
}

ForeignCells cells_of_piece(const VtkXmlStream& file, const XmlElement& piece, std::uint64_t count,
                            const std::filesystem::path& path) {
  ForeignCells cells{.kinds = {}, .offsets = {0}, .nodes = {}};
  if (count == 0) return cells;
  const CellArrays arrays(file, piece);
  cells.kinds = arrays.numbers<std::uint8_t>("types", count);
  const Numbers ends = arrays.numbers("offsets", count);
  cells.offsets.insert(cells.offsets.end(), ends.begin(), ends.end());
  cells.nodes = arrays.numbers("connectivity", cells.offsets.back());
  check_offsets(cells, path);
  const auto polyhedron = static_cast<std::uint8_t>(CellKind::polyhedron);
  if (std::find(cells.kinds.begin(), cells.kinds.end(), polyhedron) != cells.kinds.end())
    put_face_streams(cells, arrays.has("polyhedron_offsets") ? shared_faces(file, arrays, count)
                                                             : face_streams(file, arrays, count));
  if (file.is_before_version(2, 1)) renew_lagrange_hexahedra(cells, path);
  return cells;
}

void add_piece(MeshPieces& pieces, const VtkXmlStream& file, const XmlElement& piece,
               const std::filesystem::path& path) {
  const std::uint64_t point_count = file.count_in(piece, "NumberOfPoints");
  const std::uint64_t cell_count = file.count_in(piece, "NumberOfCells");
  if (point_count == 0 && cell_count == 0) return;  // VTK writes such pieces
  ForeignCells cells = cells_of_piece(file, piece, cell_count, path);
  CellMesh mesh;
  const auto places = file.arrays_in(piece.child("Points"));
  check_points(file, places.size(), places.empty() ? 0 : places.front().component_count);
  const std::uint64_t number_count = file.checked_count(places.front(), point_count);
  mesh.points.resize(point_count);
  if (point_count > 0) file.read(places.front(), std::span(mesh.points.front().data(), number_count));
  for (const bool in_cells : {false, true})
    for (const VtkXmlArray& array : file.arrays_in(piece.child(in_cells ? "CellData" : "PointData"), &mesh.notes))
      add_array(mesh, cells, in_cells, file, array, file.numbers<double>(array, in_cells ? cell_count : point_count));
  mesh.notes.insert(mesh.notes.end(), file.notes().begin(), file.notes().end());
  pieces.add(std::move(mesh), std::move(cells), path);
}

void add_vtu(MeshPieces& pieces, const std::filesystem::path& path) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "UnstructuredGrid");
  for (const XmlElement& piece : file.data_set().children)
    if (piece.name == "Piece") add_piece(pieces, file, piece, path);
}

CellMesh read_structured(const VtkXmlStream& file, const StructuredPieces& pieces, const std::filesystem::path& path) {
  const auto places = pieces.arrays("Points");
  check_points(file, places.size(), places.empty() ? 0 : places.front().front().component_count);
  CellMesh mesh;
  const std::uint64_t number_count = pieces.checked_count(places.front(), false);
  mesh.points.resize(number_count / 3);
  pieces.read(places.front(), false, std::span(mesh.points.front().data(), number_count));
  ForeignCells cells = hexahedra_of_grid(pieces.point_count(), mesh.points.size(), path);
  for (const bool in_cells : {false, true})
    for (const StructuredPieces::Parts& parts : pieces.arrays(in_cells ? "CellData" : "PointData", &mesh.notes)) {
      Array<double> values(pieces.checked_count(parts, in_cells));
      pieces.read(parts, in_cells, std::span<double>(values));
      add_array(mesh, cells, in_cells, file, parts.front(), std::move(values));
    }
  pieces.add_notes(mesh.notes);
  take_cells(mesh, std::move(cells), path);
  return mesh;
}

}  // namespace

CellMesh read_vtu(const std::filesystem::path& path) {
  MeshPieces pieces;
  add_vtu(pieces, path);
  return pieces.finish(path);
}

CellMesh read_pvtu(const std::filesystem::path& path) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "PUnstructuredGrid");
  MeshPieces pieces;
  for (const std::filesystem::path& piece : piece_paths(file, path)) add_vtu(pieces, piece);
  return pieces.finish(path);
}

CellMesh read_vts(const std::filesystem::path& path) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "StructuredGrid");
  return read_structured(file, StructuredPieces(file), path);
}

CellMesh read_pvts(const std::filesystem::path& path) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "PStructuredGrid");
  const PieceFiles parts(file, path, "StructuredGrid");
  return read_structured(file, StructuredPieces(file, parts.streams()), path);
}

}  // namespace rhoray::preprocess

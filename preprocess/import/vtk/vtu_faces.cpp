#include "preprocess/import/vtk/vtu_faces.h"

#include <vtkIdTypeArray.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>

#include <algorithm>
#include <functional>
#include <span>

#include "preprocess/import/vtk/vtk_arrays.h"
#include "preprocess/import/vtk/vtk_numbers.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using FaceStream = Array<std::uint64_t>;

/// Appends the face stream of one cell; refuses a damaged one.
using AppendStream = std::function<void(std::size_t cell, FaceStream& to)>;

[[noreturn]] void refuse_faces(std::size_t cell, const std::filesystem::path& path) {
  refuse_input(path, concat("polyhedron ", cell), "a place or counts of faces that are not there",
               "those that its arrays of faces hold");
}

void replace_polyhedra(ForeignCells& cells, const AppendStream& append) {
  FaceStream nodes;
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

/// The streams that VTK up to 9.3 stores one after the other, and the start of each.
void append_old(std::size_t cell, std::span<const vtkIdType> faces, std::span<const vtkIdType> locations,
                FaceStream& to, const std::filesystem::path& path) {
  // Reads a count. An impossible one is refused, so that sums of counts stay small.
  const auto number_at = [&](std::size_t at) {
    if (at >= faces.size() || static_cast<std::uint64_t>(faces[at]) > faces.size()) refuse_faces(cell, path);
    return static_cast<std::uint64_t>(faces[at]);
  };
  if (cell >= locations.size()) refuse_faces(cell, path);
  // a negative number is too large as well
  const auto begin = static_cast<std::uint64_t>(locations[cell]);
  std::size_t at = begin;
  const std::uint64_t face_count = number_at(at++);
  for (std::uint64_t face = 0; face < face_count; ++face) at += number_at(at) + 1;
  if (at > faces.size()) refuse_faces(cell, path);
  const std::span<const vtkIdType> stream = faces.subspan(begin, at - begin);
  to.insert(to.end(), stream.begin(), stream.end());
}

/// Range i of those whose ends are listed in `ends`.
std::span<const std::uint64_t> range(const FaceStream& ends, std::uint64_t i, const FaceStream& numbers,
                                     std::size_t cell, const std::filesystem::path& path) {
  if (i >= ends.size()) refuse_faces(cell, path);
  const std::uint64_t begin = i == 0 ? 0 : ends[i - 1], end = ends[i];
  if (begin > end || end > numbers.size()) refuse_faces(cell, path);
  return std::span(numbers).subspan(begin, end - begin);
}

void append_new(std::size_t cell, const VtuReader::Faces& faces, FaceStream& to, const std::filesystem::path& path) {
  const auto of_cell = range(faces.cell_offsets, cell, faces.cell_faces, cell, path);
  to.push_back(of_cell.size());
  for (const std::uint64_t face : of_cell) {
    const auto corners = range(faces.face_offsets, face, faces.corners, cell, path);
    to.push_back(corners.size());
    to.insert(to.end(), corners.begin(), corners.end());
  }
}

}  // namespace

vtkStandardNewMacro(VtuReader);

int VtuReader::ReadPieceData() {
  faces_ = {};
  return vtkXMLUnstructuredGridReader::ReadPieceData() != 0 && read_faces() ? 1 : 0;
}

bool VtuReader::read_faces() {
  vtkXMLDataElement* cells = CellElements[Piece];
  if (cells == nullptr || FindDataArrayWithName(cells, "polyhedron_offsets") == nullptr) return true;
  const auto last_of = [](const FaceStream& ends) { return ends.empty() ? 0 : ends.back(); };
  const auto cell_count = static_cast<std::uint64_t>(NumberOfCells[Piece]);
  if (!read("polyhedron_offsets", cell_count, faces_.cell_offsets) ||
      !read("polyhedron_to_faces", last_of(faces_.cell_offsets), faces_.cell_faces))
    return false;
  const auto last_face = std::max_element(faces_.cell_faces.begin(), faces_.cell_faces.end());
  const std::uint64_t face_count = last_face == faces_.cell_faces.end() ? 0 : *last_face + 1;
  return read("face_offsets", face_count, faces_.face_offsets) &&
         read("face_connectivity", last_of(faces_.face_offsets), faces_.corners);
}

/// Reads an array of integers; a negative one becomes too large and is refused later.
bool VtuReader::read(const char* name, std::uint64_t count, FaceStream& numbers) {
  // No compressor of VTK stores a number in less than 1/4096 byte. So nothing is allocated for
  // absurd counts.
  constexpr std::uint64_t most_per_byte = 40960;
  const auto refuse = [&](const char* reason) {
    vtkErrorMacro("Cannot read the faces of polyhedra: array '" << name << "' " << reason);
    return false;
  };
  vtkXMLDataElement* element = FindDataArrayWithName(CellElements[Piece], name);
  if (element == nullptr) return refuse("is missing");
  if (count / most_per_byte > std::filesystem::file_size(GetFileName()))
    return refuse("would have to be longer than the file");
  const auto array = vtkSmartPointer<vtkAbstractArray>::Take(CreateArray(element));
  vtkDataArray* data = vtkDataArray::SafeDownCast(array);
  const auto type = data == nullptr ? std::nullopt : element_type_of_vtk(*data);
  if (!type || data->GetNumberOfComponents() != 1) return refuse("does not hold whole numbers");
  data->SetNumberOfTuples(static_cast<vtkIdType>(count));
  if (count > 0 && ReadArrayValues(element, 0, data, 0, static_cast<vtkIdType>(count)) == 0)
    return refuse("is not long enough");
  numbers = numbers_of<std::uint64_t>(*data, *type);
  return true;
}

void put_face_streams(ForeignCells& cells, VtuReader& reader, const std::filesystem::path& path) {
  const VtuReader::Faces& faces = reader.faces();
  vtkUnstructuredGrid& grid = *reader.GetOutput();
  if (!faces.cell_offsets.empty())
    return replace_polyhedra(cells, [&](std::size_t cell, FaceStream& to) { append_new(cell, faces, to, path); });
  if (grid.GetFaces() == nullptr || grid.GetFaceLocations() == nullptr)
    refuse_input(path, "element Cells", "polyhedra without faces",
                 "the arrays 'faces' and 'faceoffsets', or 'polyhedron_offsets' and those that go with it");
  const auto numbers = [](vtkIdTypeArray& array) {
    return std::span<const vtkIdType>(array.GetPointer(0), static_cast<std::size_t>(array.GetNumberOfValues()));
  };
  const auto streams = numbers(*grid.GetFaces()), locations = numbers(*grid.GetFaceLocations());
  replace_polyhedra(cells, [&](std::size_t cell, FaceStream& to) { append_old(cell, streams, locations, to, path); });
}

}  // namespace rhoray::preprocess

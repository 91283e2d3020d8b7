#include "preprocess/import/vtk_mesh.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "formats/base/checks.h"
#include "preprocess/import/families.h"
#include "preprocess/import/foreign_file.h"
#include "preprocess/import/vtk_arrays.h"
#include "preprocess/import/vtk_errors.h"
#include "preprocess/import/vtk_fields.h"
#include "preprocess/import/vtk_numbers.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// VTK keeps the faces of polyhedra beside the cells; here each stream takes the place of its cell's nodes.
class FaceStreams {
 public:
  FaceStreams(vtkUnstructuredGrid& grid, const std::filesystem::path& path) : path_(path) {
    if (grid.GetFaces() == nullptr || grid.GetFaceLocations() == nullptr)
      refuse_input(path, "element Cells", "polyhedra without arrays 'faces' and 'faceoffsets'",
                   "both, as VTK writes them up to version 9.3", Trouble::unsupported);
    faces_ = {grid.GetFaces()->GetPointer(0), static_cast<std::size_t>(grid.GetFaces()->GetNumberOfValues())};
    locations_ = {grid.GetFaceLocations()->GetPointer(0),
                  static_cast<std::size_t>(grid.GetFaceLocations()->GetNumberOfValues())};
  }

  void put_in_place(ForeignCells& cells) const {
    Array<std::uint64_t> nodes;
    nodes.reserve(cells.nodes.size() + faces_.size());
    std::uint64_t begin = 0;
    for (std::size_t cell = 0; cell < cells.kinds.size(); ++cell) {
      const std::uint64_t end = cells.offsets[cell + 1];
      if (cells.kinds[cell] == static_cast<std::uint8_t>(CellKind::polyhedron)) {
        const std::span<const vtkIdType> stream = stream_of(cell);
        nodes.insert(nodes.end(), stream.begin(), stream.end());
      } else {
        nodes.insert(nodes.end(), cells.nodes.begin() + static_cast<std::ptrdiff_t>(begin),
                     cells.nodes.begin() + static_cast<std::ptrdiff_t>(end));
      }
      begin = end;
      cells.offsets[cell + 1] = nodes.size();
    }
    cells.nodes = std::move(nodes);
  }

 private:
  std::span<const vtkIdType> stream_of(std::size_t cell) const {
    const auto begin = cell < locations_.size() ? static_cast<std::uint64_t>(locations_[cell]) : faces_.size();
    if (begin >= faces_.size()) refuse(cell);  // a negative one is too large as well
    std::size_t at = begin;
    const std::uint64_t face_count = number_at(at++, cell);
    for (std::uint64_t face = 0; face < face_count; ++face) at += number_at(at, cell) + 1;
    if (at > faces_.size()) refuse(cell);
    return faces_.subspan(begin, at - begin);
  }

  /// A count; refuses one that cannot be, so that sums of them stay small.
  std::uint64_t number_at(std::size_t at, std::size_t cell) const {
    if (at >= faces_.size() || static_cast<std::uint64_t>(faces_[at]) > faces_.size()) refuse(cell);
    return static_cast<std::uint64_t>(faces_[at]);
  }

  [[noreturn]] void refuse(std::size_t cell) const {
    refuse_input(path_, concat("polyhedron ", cell), "a place or counts of faces that are not there",
                 "those that its array 'faces' holds");
  }

  const std::filesystem::path& path_;
  std::span<const vtkIdType> faces_, locations_;
};

ForeignCells cells_of(vtkUnstructuredGrid& grid, const std::filesystem::path& path) {
  ForeignCells cells;
  vtkCellArray* array = grid.GetCells();
  vtkUnsignedCharArray* kinds = grid.GetCellTypesArray();
  if (array == nullptr || kinds == nullptr || array->GetNumberOfCells() == 0) {
    cells.offsets = {0};
    return cells;
  }
  const auto whole_numbers = [&](vtkDataArray* numbers) {
    const std::optional<ElementType> type = element_type_of_vtk(*numbers);
    RHORAY_CHECK(type.has_value());
    return numbers_of<std::uint64_t>(*numbers, *type);  // a negative one becomes too large and is refused later
  };
  cells.offsets = whole_numbers(array->GetOffsetsArray());
  cells.nodes = whole_numbers(array->GetConnectivityArray());
  cells.kinds = numbers_of<std::uint8_t>(*kinds, ElementType::U8);
  check_offsets(cells, path);
  const auto polyhedron = static_cast<std::uint8_t>(CellKind::polyhedron);
  if (std::find(cells.kinds.begin(), cells.kinds.end(), polyhedron) != cells.kinds.end())
    FaceStreams(grid, path).put_in_place(cells);
  take_vtk_ghosts(cells, grid);
  return cells;
}

/// VTK reads a truncated file without an error in some places: what its header promised must have arrived.
void check_arrival(vtkXMLUnstructuredGridReader& reader, vtkUnstructuredGrid& grid, const std::filesystem::path& path) {
  const auto compare = [&](const char* what, vtkIdType promised, vtkIdType arrived) {
    if (promised != arrived)
      refuse_input(path, what, concat(arrived, " read"), concat(promised, ", as its header says"));
  };
  compare("points", reader.GetNumberOfPoints(), grid.GetNumberOfPoints());
  compare("cells", reader.GetNumberOfCells(), grid.GetNumberOfCells());
  compare("arrays at points", reader.GetNumberOfPointArrays(), grid.GetPointData()->GetNumberOfArrays());
  compare("arrays in cells", reader.GetNumberOfCellArrays(), grid.GetCellData()->GetNumberOfArrays());
}

}  // namespace

void add_vtu(MeshPieces& pieces, const std::filesystem::path& path) {
  const VtkXmlCounts promised = check_vtk_xml(path, "UnstructuredGrid");
  if (promised.points == 0 && promised.cells == 0) return;  // VTK writes it so, but refuses to read it
  const VtkErrors errors;
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  errors.check(path);
  // Read one by one: all at once VTK 9.1 would turn the nodes of old Lagrange hexahedra again for each piece.
  const int count = static_cast<int>(reader->GetNumberOfPieces());
  for (int piece = 0; piece < count; ++piece) {
    reader->UpdatePiece(piece, count, 0);
    errors.check(path);
    vtkUnstructuredGrid* grid = reader->GetOutput();
    check_arrival(*reader, *grid, path);
    CellMesh mesh;
    take_vtk_points(mesh, grid->GetPoints(), path);
    take_vtk_fields(mesh, *grid);
    pieces.add(std::move(mesh), cells_of(*grid, path), path);
  }
}

CellMesh read_vtu(const std::filesystem::path& path) {
  MeshPieces pieces;
  add_vtu(pieces, path);
  return pieces.finish(path);
}

}  // namespace rhoray::preprocess

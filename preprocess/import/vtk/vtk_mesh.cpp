#include "preprocess/import/vtk/vtk_mesh.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>

#include "formats/base/checks.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/vtk/vtk_arrays.h"
#include "preprocess/import/vtk/vtk_errors.h"
#include "preprocess/import/vtk/vtk_fields.h"
#include "preprocess/import/vtk/vtk_numbers.h"
#include "preprocess/import/vtk/vtu_faces.h"
#include "preprocess/import/vtk/vtu_stream.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

ForeignCells cells_of(VtuReader& reader, const std::filesystem::path& path) {
  vtkUnstructuredGrid& grid = *reader.GetOutput();
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
    // a negative number becomes too large and is refused later
    return numbers_of<std::uint64_t>(*numbers, *type);
  };
  cells.offsets = whole_numbers(array->GetOffsetsArray());
  cells.nodes = whole_numbers(array->GetConnectivityArray());
  cells.kinds = numbers_of<std::uint8_t>(*kinds, ElementType::U8);
  check_offsets(cells, path);
  const auto polyhedron = static_cast<std::uint8_t>(CellKind::polyhedron);
  if (std::find(cells.kinds.begin(), cells.kinds.end(), polyhedron) != cells.kinds.end())
    put_face_streams(cells, reader, path);
  take_vtk_ghosts(cells, grid);
  return cells;
}

/// Checks that everything in the header was read: in some cases VTK reads a truncated file without
/// an error.
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
  // VTK writes such files, but refuses to read them
  if (promised.points == 0 && promised.cells == 0) return;
  const VtkErrors errors;
  vtkNew<VtuReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  errors.check(path);
  // Read pieces one by one: when VTK 9.1 reads all at once, it reorders the nodes of old Lagrange
  // hexahedra again for each piece.
  const int count = static_cast<int>(reader->GetNumberOfPieces());
  for (int piece = 0; piece < count; ++piece) {
    reader->UpdatePiece(piece, count, 0);
    errors.check(path);
    vtkUnstructuredGrid* grid = reader->GetOutput();
    check_arrival(*reader, *grid, path);
    CellMesh mesh;
    take_vtk_points(mesh, grid->GetPoints(), path);
    take_vtk_fields(mesh, *grid);
    pieces.add(std::move(mesh), cells_of(*reader, path), path);
  }
}

CellMesh read_vtu(const std::filesystem::path& path) {
  check_vtk_xml(path, "UnstructuredGrid");
  if (std::optional<CellMesh> mesh = stream_vtu(path)) return *std::move(mesh);
  MeshPieces pieces;
  add_vtu(pieces, path);
  return pieces.finish(path);
}

}  // namespace rhoray::preprocess

#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>
#include <vtkXMLStructuredGridReader.h>

#include "preprocess/import/mesh/structured_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/vtk/vtk_errors.h"
#include "preprocess/import/vtk/vtk_fields.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

CellMesh read_vts(const std::filesystem::path& path) {
  check_vtk_xml(path, "StructuredGrid");
  const VtkErrors errors;
  vtkNew<vtkXMLStructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  errors.check(path);
  vtkStructuredGrid* grid = reader->GetOutput();
  CellMesh mesh;
  take_vtk_points(mesh, grid->GetPoints(), path);
  take_vtk_fields(mesh, *grid);
  const int* size = grid->GetDimensions();
  ForeignCells cells = hexahedra_of_grid({size[0], size[1], size[2]}, mesh.points.size(), path);
  take_vtk_ghosts(cells, *grid);
  take_cells(mesh, std::move(cells), path);
  return mesh;
}

}  // namespace rhoray::preprocess

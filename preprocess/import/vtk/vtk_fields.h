#pragma once

#include <filesystem>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/neutral.h"

class vtkDataSet;
class vtkPoints;

namespace rhoray::preprocess {

/// Appends VTK's points; null has none. Refuses other than three numbers for each.
void take_vtk_points(CellMesh& mesh, vtkPoints* points, const std::filesystem::path& path);

/// Takes the arrays of numbers at points and in cells, with their units. Arrays of texts are left
/// out with a note, and so is VTK's own bookkeeping without one.
void take_vtk_fields(CellMesh& mesh, vtkDataSet& data);

/// What the arrays vtkGhostType say of points and cells.
void take_vtk_ghosts(ForeignCells& cells, vtkDataSet& data);

}  // namespace rhoray::preprocess

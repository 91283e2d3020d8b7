#pragma once

#include <filesystem>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/neutral.h"

class vtkDataSet;
class vtkPoints;

namespace rhoray::preprocess {

/// Appends VTK's points; null means none. Refuses points without exactly three numbers each.
void take_vtk_points(CellMesh& mesh, vtkPoints* points, const std::filesystem::path& path);

/// Reads the numeric arrays at points and in cells, with their units. Text arrays are left out with
/// a note, VTK's internal arrays without one.
void take_vtk_fields(CellMesh& mesh, vtkDataSet& data);

/// Reads the vtkGhostType arrays of points and cells.
void take_vtk_ghosts(ForeignCells& cells, vtkDataSet& data);

}  // namespace rhoray::preprocess

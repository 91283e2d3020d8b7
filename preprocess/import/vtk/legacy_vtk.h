#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/grid_arrays.h"

namespace rhoray::preprocess {

/// A parsed legacy VTK file (.vtk, versions 1 to 5.1, text or binary). Every count is checked
/// against the data that follows.
struct LegacyVtk {
  std::string dataset;  ///< the word after DATASET, in upper case
  int version_major = 0, version_minor = 0;
  Index3 dimensions{0, 0, 0};
  Vec3 spacing{1, 1, 1};
  Vec3 origin{0, 0, 0};
  Array<std::array<double, 3>> points;
  std::array<std::vector<double>, 3> coordinates;  ///< of a rectilinear grid
  /// relative, of the least precise of these arrays
  double coordinate_precision = 0x1p-52;
  /// of UNSTRUCTURED_GRID; of STRUCTURED_GRID only the hidden ones
  ForeignCells cells;
  ForeignCells polygons, strips;      ///< of POLYDATA, without kinds
  std::uint64_t thin_cell_count = 0;  ///< of POLYDATA: number of vertices and lines
  /// POINT_DATA and CELL_DATA, in file order
  std::vector<GridArray> arrays;
  std::uint64_t point_data_count = 0, cell_data_count = 0;
};

/// Reads the supported kinds of data set: STRUCTURED_POINTS, RECTILINEAR_GRID, STRUCTURED_GRID,
/// UNSTRUCTURED_GRID and POLYDATA. Refuses other kinds by name.
LegacyVtk read_legacy_vtk(const std::filesystem::path& path);

}  // namespace rhoray::preprocess

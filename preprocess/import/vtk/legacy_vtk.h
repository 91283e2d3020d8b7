#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/samples.h"

namespace rhoray::preprocess {

/// A legacy VTK file (.vtk, versions 1 to 5.1, text or binary) taken apart. Every count is checked
/// against what follows.
struct LegacyVtk {
  std::string dataset;  ///< the word after DATASET, in capitals
  int version_major = 0, version_minor = 0;
  Index3 dimensions{0, 0, 0};
  Vec3 spacing{1, 1, 1};
  Vec3 origin{0, 0, 0};
  Array<std::array<double, 3>> points;
  std::array<std::vector<double>, 3> coordinates;  ///< of a rectilinear grid
  double coordinate_precision = 0x1p-52;           ///< relative, of the least precise of them
  /// of UNSTRUCTURED_GRID; of STRUCTURED_GRID only what is hidden
  ForeignCells cells;
  ForeignCells polygons, strips;      ///< of POLYDATA, without kinds
  std::uint64_t thin_cell_count = 0;  ///< of POLYDATA: vertices and lines
  /// POINT_DATA and CELL_DATA, in the file's order
  std::vector<GridArray> arrays;
  std::map<std::size_t, std::string> units;  ///< of those arrays that have one, by position
  std::uint64_t point_data_count = 0, cell_data_count = 0;
};

/// Reads the kinds of data set that Rhoray takes: STRUCTURED_POINTS, RECTILINEAR_GRID,
/// STRUCTURED_GRID, UNSTRUCTURED_GRID and POLYDATA; others are refused by name.
LegacyVtk read_legacy_vtk(const std::filesystem::path& path);

}  // namespace rhoray::preprocess

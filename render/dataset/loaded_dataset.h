#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "formats/base/affine.h"
#include "formats/space.h"
#include "render/grid/grid_data.h"
#include "render/grid/occupancy.h"
#include "render/tets/tet_data.h"
#include "render/triangles/triangle_data.h"

namespace rhoray::render {

class CornerNormalsCache;
class FacetsCache;
class PointGradientsCache;

/// A dataset as kernels read it.
using DataView = std::variant<UniformGrid, RectilinearGrid, TetData, TriangleData>;

/// One loaded dataset: what every kind has in common, and the view that kernels read.
struct LoadedDataset {
  formats::PackedFile file;
  formats::FieldSummary field;                       ///< for a surface: no field, without a name
  std::vector<formats::FieldSummary> fields{};       ///< all whose summary the file holds
  std::vector<formats::FieldSummary> cell_fields{};  ///< of a mesh or its boundary: one value per cell
  std::vector<std::string> field_names;
  std::string length_unit;
  formats::Space space = formats::Space::unknown;  ///< of world coordinates
  /// The values are distances to a surface, which lies where they are 0.
  bool is_level_set = false;
  bool is_y_up = false;              ///< +y is up, by the convention of the format that the file was packed from
  std::vector<std::string> notes{};  ///< what loading changed, one sentence each
  /// Data frame: grid steps or positions of axis tables; for points, relative to the origin.
  Affine world_from_data;
  Box3 bounds_data;  ///< of all cells, data frame
  DataView view;
  /// Occupied blocks of the isovalues used last. Used by grids only.
  std::unique_ptr<OccupancyCache> occupancies = std::make_unique<OccupancyCache>();
  /// Facets of the isovalues used last, or the triangles of a surface. Null for grids.
  std::shared_ptr<FacetsCache> facets{};
  std::shared_ptr<PointGradientsCache> point_gradients{};  ///< null if not a mesh
  std::shared_ptr<CornerNormalsCache> corner_normals{};    ///< null if not a surface
};

}  // namespace rhoray::render

#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "formats/base/affine.h"
#include "render/grid/grid_volume.h"
#include "render/grid/nanovdb_volume.h"
#include "render/grid/occupancy.h"
#include "render/tets/tet_volume.h"
#include "render/triangles/surface_volume.h"

namespace rhoray::render {

class FacetsCache;
class PointGradientsCache;

/// One loaded dataset: what every kind has in common, and the view that kernels read.
struct VolumeImplementation {
  formats::PackedFile file;
  formats::FieldSummary field;  ///< for a surface: no field, without a name
  std::vector<std::string> field_names;
  std::string length_unit;
  /// The values are distances to a surface, which lies where they are 0.
  bool is_level_set = false;
  std::vector<std::string> notes{};  ///< what loading changed, one sentence each
  /// Volume frame: grid steps or positions of axis tables; for points, relative to the origin.
  Affine world_from_volume;
  Box3 bounds_volume;  ///< of all cells, volume frame
  std::variant<GridVolume<std::uint8_t>, GridVolume<std::int8_t>, GridVolume<std::uint16_t>, GridVolume<std::int16_t>,
               GridVolume<std::uint32_t>, GridVolume<std::int32_t>, GridVolume<float>, GridVolume<double>,
               RectilinearVolume<std::uint8_t>, RectilinearVolume<std::int8_t>, RectilinearVolume<std::uint16_t>,
               RectilinearVolume<std::int16_t>, RectilinearVolume<std::uint32_t>, RectilinearVolume<std::int32_t>,
               RectilinearVolume<float>, RectilinearVolume<double>, SparseVolume<float>, SparseVolume<double>,
               SparseRectilinearVolume<float>, SparseRectilinearVolume<double>, TetVolume<float>, TetVolume<double>,
               NanoVdbVolume, SurfaceVolume>
      view;
  /// Of the field of a grid.
  std::unique_ptr<OccupancyCache> occupancies = std::make_unique<OccupancyCache>();
  /// Of the field of a mesh, or of a surface; null for grids.
  std::shared_ptr<FacetsCache> facets{};
  std::shared_ptr<PointGradientsCache> point_gradients{};  ///< of the field of a mesh
};

}  // namespace rhoray::render

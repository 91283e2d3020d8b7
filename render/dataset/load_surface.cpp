#include "render/triangles/triangle_data.h"

#include <filesystem>

#include "formats/base/error.h"
#include "formats/base/lower_case.h"
#include "formats/base/stopping.h"
#include "formats/base/text.h"
#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"
#include "render/triangles/corner_normals.h"
#include "render/triangles/facets.h"

namespace rhoray::render {

namespace {

/// Formats of computer graphics have +y up; those of engineering (.stl, .vtp, .off) have +z.
bool has_y_up(const std::string& source_name) {
  const std::string extension = lower_case(std::filesystem::path(source_name).extension().string());
  return extension == ".obj" || extension == ".ply";
}

}  // namespace

std::shared_ptr<const LoadedDataset> load_surface(const formats::PackedFile& file, const std::string& field,
                                                  formats::Space, const Watch& watch) {
  const formats::TriangleMesh mesh(file, watch);
  if (!field.empty())
    throw Error(ErrorCode::usage, concat(file.name(), ": no field '", field, "'; a surface has no fields"));
  Box3 bounds;
  for_each_until_stopped(0, mesh.description().point_count, light_piece, watch.stop, [&](std::uint64_t p) {
    const std::array<double, 3> point = mesh.point(p);
    bounds.extendBy(Vec3(point[0], point[1], point[2]));
  });
  const formats::FieldSummary no_field;
  return std::make_shared<LoadedDataset>(
      LoadedDataset{.file = file,
                    .field = no_field,
                    .field_names = {},
                    .length_unit = mesh.description().length_unit,
                    .is_y_up = has_y_up(mesh.description().provenance.source_name),
                    .world_from_data = Affine{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}},
                    .bounds_data = bounds,
                    .view = TriangleData(mesh),
                    .facets = std::make_shared<FacetsCache>(),
                    .corner_normals = std::make_shared<CornerNormalsCache>()});
}

}  // namespace rhoray::render

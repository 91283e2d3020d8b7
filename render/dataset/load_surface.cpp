#include "render/triangles/triangle_data.h"

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"
#include "render/triangles/facets.h"
#include "render/triangles/point_gradients.h"

namespace rhoray::render {

std::shared_ptr<const LoadedDataset> load_surface(const formats::PackedFile& file, const std::string& field,
                                                  formats::Space) {
  const formats::TriangleMesh mesh(file);
  if (!field.empty())
    throw Error(ErrorCode::usage, concat(file.name(), ": no field '", field, "'; a surface has no fields"));
  Box3 bounds;
  for (std::uint64_t p = 0; p < mesh.description().point_count; ++p) {
    const std::array<double, 3> point = mesh.point(p);
    bounds.extendBy(Vec3(point[0], point[1], point[2]));
  }
  const formats::FieldSummary no_field;
  return std::make_shared<LoadedDataset>(
      LoadedDataset{.file = file,
                    .field = no_field,
                    .field_names = {},
                    .length_unit = mesh.description().length_unit,
                    .world_from_data = Affine{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}},
                    .bounds_data = bounds,
                    .view = TriangleData(mesh),
                    .facets = std::make_shared<FacetsCache>(),
                    .point_gradients = std::make_shared<PointGradientsCache>()});
}

}  // namespace rhoray::render

#include <optional>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/stopping.h"
#include "formats/base/text.h"
#include "formats/base/word_list.h"
#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"
#include "render/triangles/corner_normals.h"
#include "render/triangles/facets.h"
#include "render/triangles/point_gradients.h"

namespace rhoray::render {

std::shared_ptr<const LoadedDataset> load_tets(const formats::PackedFile& file, const std::string& field,
                                               formats::Space, const Watch& watch) {
  const formats::TetMesh mesh(file, watch);
  const formats::TetMeshDescription& description = mesh.description();
  std::vector<std::string> names;
  for (const formats::FieldSummary& summary : description.fields) names.push_back(summary.name);
  check_field_name(file, field, names);

  const std::size_t chosen = field.empty() ? 0 : *mesh.find_field(field);
  const formats::FieldSummary& summary = description.fields[chosen];
  Box3 bounds;
  const auto points = mesh.points();
  for_each_until_stopped(0, points.size(), light_piece, watch.stop,
                         [&](std::uint64_t p) { bounds.extendBy(Vec3(points[p][0], points[p][1], points[p][2])); });
  return std::make_shared<LoadedDataset>(
      LoadedDataset{.file = file,
                    .field = summary,
                    .fields = description.fields,
                    .cell_fields = description.cell_fields,
                    .field_names = names,
                    .length_unit = description.length_unit,
                    .world_from_data = Affine{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, description.origin},
                    .bounds_data = bounds,
                    .view = TetData(mesh, chosen),
                    .facets = std::make_shared<FacetsCache>(),
                    .point_gradients = std::make_shared<PointGradientsCache>()});
}

namespace {

const TetData& mesh_of(const LoadedDataset& dataset) {
  const auto* view = std::get_if<TetData>(&dataset.view);
  if (view == nullptr)
    throw Error(ErrorCode::usage, concat(dataset.file.name(), ": is not a mesh and has no boundary"));
  return *view;
}

/// Keeps the bounds of the mesh. Kernels round points in a frame that depends on them, and round a
/// face between two labels alike for both.
std::shared_ptr<const LoadedDataset> with_boundary(const LoadedDataset& mesh,
                                                   std::shared_ptr<const MeshBoundary> boundary) {
  return std::make_shared<LoadedDataset>(LoadedDataset{.file = mesh.file,
                                                       .field = mesh.field,
                                                       .fields = mesh.fields,
                                                       .cell_fields = mesh.cell_fields,
                                                       .field_names = mesh.field_names,
                                                       .length_unit = mesh.length_unit,
                                                       .world_from_data = mesh.world_from_data,
                                                       .bounds_data = mesh.bounds_data,
                                                       .view = TriangleData(std::move(boundary)),
                                                       .facets = std::make_shared<FacetsCache>(),
                                                       .corner_normals = std::make_shared<CornerNormalsCache>()});
}

}  // namespace

std::shared_ptr<const LoadedDataset> load_boundary(const LoadedDataset& mesh, const Watch& watch) {
  return with_boundary(mesh, std::make_shared<const MeshBoundary>(mesh_of(mesh), watch));
}

std::shared_ptr<const LoadedDataset> load_boundary(const LoadedDataset& mesh, const std::string& cell_field, int label,
                                                   std::span<const int> without, const Watch& watch) {
  const TetData& view = mesh_of(mesh);
  const std::optional<std::size_t> field = view.mesh().find_cell_field(cell_field);
  if (!field) {
    const std::vector<std::string> known = names_in(mesh.cell_fields, &formats::FieldSummary::name);
    throw Error(ErrorCode::usage, concat(mesh.file.name(), ": no field '", cell_field, "' of cells; it has ",
                                         known.empty() ? "none" : joined(known, ", ", "'")));
  }
  auto boundary = std::make_shared<const MeshBoundary>(view, *field, label, without, watch);
  if (boundary->cells.empty() && without.empty())
    throw Error(ErrorCode::invalid,
                concat(mesh.file.name(), ": no cell has label ", label, " in field '", cell_field, "'"));
  return with_boundary(mesh, std::move(boundary));
}

}  // namespace rhoray::render

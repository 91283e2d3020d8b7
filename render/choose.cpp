#include <algorithm>
#include <array>
#include <string_view>

#include "formats/triangle_mesh.h"
#include "formats/vdb_grid.h"
#include "render/dataset/load_view.h"
#include "render/grid/intersectors.h"
#include "render/tets/intersectors.h"
#include "render/triangles/intersectors.h"

namespace rhoray::render {

namespace {

/// A kind of data that can be rendered.
struct Kind {
  std::string_view name;  ///< in the packed file
  std::shared_ptr<const LoadedDataset> (*load)(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world);
  Intersectors (*intersectors)(const LoadedDataset& dataset, const RayQuery& query, Machine machine);
};
constexpr std::array kinds{Kind{"grid", load_grid, grid::intersectors}, Kind{"tets", load_tets, tets::intersectors},
                           Kind{formats::VdbGrid::kind, load_vdb, grid::intersectors},
                           Kind{formats::TriangleMesh::kind, load_surface, triangles::intersectors}};

const Kind* kind_of(const formats::PackedFile& file) {
  const auto found =
      std::find_if(kinds.begin(), kinds.end(), [&](const Kind& kind) { return kind.name == file.description().kind; });
  return found == kinds.end() ? nullptr : &*found;
}

}  // namespace

std::shared_ptr<const LoadedDataset> load_view(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world) {
  const Kind* kind = kind_of(file);
  return kind == nullptr ? nullptr : kind->load(file, field, world);
}

Intersectors choose_intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine) {
  return kind_of(dataset.file)->intersectors(dataset, query, machine);
}

bool answers_wide(const LoadedDataset& dataset, const Method& method, Kernel Intersectors::*kernel, Machine machine) {
  const RayQuery query{.method = method};
  return choose_intersectors(dataset, query, machine).*kernel !=
         choose_intersectors(dataset, query, Machine::scalar).*kernel;
}

}  // namespace rhoray::render

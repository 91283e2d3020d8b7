#include <array>
#include <string_view>
#include <utility>
#include <variant>

#include "formats/triangle_mesh.h"
#include "formats/vdb_grid.h"
#include "render/dataset/load_view.h"
#include "render/grid/intersectors.h"
#include "render/tets/intersectors.h"
#include "render/triangles/intersectors.h"

namespace rhoray::render {

namespace {

using Load = std::shared_ptr<const LoadedDataset> (*)(const formats::PackedFile& file, const std::string& field,
                                                      formats::Space world, const Watch& watch);

/// The loaders, by the kinds of packed files.
constexpr std::array<std::pair<std::string_view, Load>, 4> loaders{{{"grid", load_grid},
                                                                    {"tets", load_tets},
                                                                    {formats::VdbGrid::kind, load_vdb},
                                                                    {formats::TriangleMesh::kind, load_surface}}};

using Choose = Intersectors (*)(const LoadedDataset& dataset, const RayQuery& query, Machine machine);

Choose chooser_of(const UniformGrid&) {
  return grid::intersectors;
}
Choose chooser_of(const RectilinearGrid&) {
  return grid::intersectors;
}
Choose chooser_of(const TetData&) {
  return tets::intersectors;
}
Choose chooser_of(const TriangleData&) {
  return triangles::intersectors;
}

}  // namespace

std::shared_ptr<const LoadedDataset> load_view(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const Watch& watch) {
  for (const auto& [kind, load] : loaders)
    if (kind == file.description().kind) return load(file, field, world, watch);
  return nullptr;
}

Intersectors choose_intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine) {
  const Choose choose = std::visit([](const auto& view) { return chooser_of(view); }, dataset.view);
  return choose(dataset, query, machine);
}

bool answers_wide(const LoadedDataset& dataset, const Method& method, Kernel Intersectors::*kernel, Machine machine) {
  const RayQuery query{.method = method};
  return choose_intersectors(dataset, query, machine).*kernel !=
         choose_intersectors(dataset, query, Machine::scalar).*kernel;
}

}  // namespace rhoray::render

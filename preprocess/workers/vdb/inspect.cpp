#include "preprocess/workers/vdb/facts.h"
#include "preprocess/workers/vdb/hand_out.h"

namespace rhoray::preprocess {
namespace {

Index3 index_of(const openvdb::Coord& c) {
  return {c.x(), c.y(), c.z()};
}

void add_scalar(VdbGridFacts& facts, const std::filesystem::path& path) {
  const ScalarGrid scalar = read_scalar_grid(path, facts.name);
  facts.field = summarize(scalar);
  facts.background = std::visit([](const auto& grid) { return static_cast<double>(grid->background()); }, scalar.grid);
}

VdbGridFacts facts_of(VdbFile& file, const VdbFile::Entry& entry, const std::filesystem::path& path) {
  VdbGridFacts facts;
  facts.name = entry.name;
  facts.value_type = value_type_of(entry);
  if (!entry.grid) return facts;
  const openvdb::GridBase::Ptr grid = file.read(entry.name);
  facts.grid_class = openvdb::GridBase::gridClassToString(grid->getGridClass());
  facts.map_type = grid->transform().mapType();
  facts.world_from_index = affine_of(grid->transform());
  facts.active_voxel_count = grid->activeVoxelCount();
  const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
  if (!box.empty()) {
    facts.first_active = index_of(box.min());
    facts.last_active = index_of(box.max());
  }
  for (auto meta = grid->beginMeta(); meta != grid->endMeta(); ++meta)
    facts.metadata.emplace_back(meta->first, meta->second->str());
  const std::vector<std::string> scalars = scalars_of(entry);
  if (scalars.size() == 1 && facts.active_voxel_count != 0 && facts.world_from_index) add_scalar(facts, path);
  return facts;
}

}  // namespace

void hand_over_facts(const std::filesystem::path& path, int descriptor) {
  VdbFile file(path);
  std::vector<VdbGridFacts> grids;
  for (const VdbFile::Entry& entry : file.entries()) grids.push_back(facts_of(file, entry, path));
  send(grids, descriptor);
}

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <vector>

#include "formats/cell_clusters.h"
#include "tools/lab/structures/plain_mesh.h"

namespace rhoray::study {

/// Boxes and ranges over the cells of a mesh in their given order, as a packed file has them for
/// its own order. The scalar traversal of clusters uses them (render/mesh_search.h).
class ClusterTree {
 public:
  ClusterTree(const PlainMesh& mesh, std::uint64_t cluster_size);

  const formats::CellClustersView& clusters() const { return view_; }
  template <class Act>
  auto with_cluster_ranges(int level, std::uint64_t block, Act&& act) const {
    return act(range_views_[static_cast<std::size_t>(level)][block]);
  }

  std::uint64_t bytes() const;

 private:
  std::vector<std::vector<formats::BoxBlock>> boxes_;
  std::vector<std::vector<formats::RangeBlock<float>>> ranges_;
  formats::CellClustersView view_;
  formats::ClusterRangesView<float> range_views_;
};

}  // namespace rhoray::study

#pragma once

#include <nanovdb/NanoVDB.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/macro_levels.h"
#include "formats/vdb_grid.h"
#include "render/cell/trilinear.h"
#include "render/grid/grid_data.h"
#include "render/grid/leaf_bricks.h"
#include "render/traverse/lattice_walk.h"

namespace rhoray::render {

/// A NanoVDB grid as the kernels read it, in its own frame: the first sample of its box lies at
/// position (0, 0, 0). Voxels that are not stored have the value of the tile or the background
/// around them.
class NanoVdbData {
 public:
  using Sample = float;

  /// Builds the macro levels from the leaf nodes; where the grid is sparse this costs little.
  /// Refuses a buffer that is not a float grid, or whose nodes do not lie in it.
  explicit NanoVdbData(const formats::VdbGrid& grid);

  WalkLattice lattice() const { return {levels_->shape.leaf_count, levels_->shape.factor}; }
  int level_count() const { return levels_->shape.level_count; }
  const formats::MacroLevelsView<float>& levels() const { return levels_->view; }

  /// The leaf nodes as bricks. There may be no slots (see LeafBricks); there are none where the
  /// macrocells of the lowest level are larger.
  StoredBricks<float> bricks() const { return bricks_ ? bricks_->view() : StoredBricks<float>{}; }

  /// The range of all cells that have data.
  Interval<double> values() const {
    return {static_cast<double>(levels_->values.lo), static_cast<double>(levels_->values.hi)};
  }
  bool has_gaps() const { return levels_->has_gaps; }  ///< some samples have no data
  RHORAY_INLINE UniformGeometry geometry() const { return {}; }

  /// The t at which a ray passes the planes between cells.
  RHORAY_INLINE PlaneTimes plane_times(const Ray& ray) const { return PlaneTimes(ray); }

  /// The range of values that can occur in a macrocell; level must be at least 1.
  RHORAY_INLINE Interval<double> range(int level, const Index3& cell) const {
    const Interval<float> stored = levels_->view.range(level, cell.x, cell.y, cell.z);
    if (stored.is_empty()) return {};
    return {static_cast<double>(stored.lo), static_cast<double>(stored.hi)};
  }

  RHORAY_INLINE TrilinearCell cell(const Index3& c) const {
    constexpr std::int32_t last = Leaf::DIM - 1;
    const nanovdb::Coord low = voxel(c);
    TrilinearCell out;
    // For seven eighths of the cells on each axis, all corners lie in one leaf node, found once.
    if ((low[0] & last) != last && (low[1] & last) != last && (low[2] & last) != last)
      if (const Leaf* leaf = tree_->root().probeLeaf(low)) {
        const float* values = leaf->data()->mValues + Leaf::CoordToOffset(low);
        for (std::size_t corner = 0; corner < 8; ++corner)
          out.corner[corner] =
              static_cast<double>(values[(corner & 1) * x_stride + (corner >> 1 & 1) * y_stride + (corner >> 2)]);
        return out;
      }
    const nanovdb::DefaultReadAccessor<float> accessor(tree_->root());
    for (std::size_t corner = 0; corner < 8; ++corner)
      out.corner[corner] = static_cast<double>(accessor.getValue(
          low.offsetBy(static_cast<std::int32_t>(corner & 1), static_cast<std::int32_t>(corner >> 1 & 1),
                       static_cast<std::int32_t>(corner >> 2))));
    return out;
  }

  /// False for a cell with a corner that is NaN or infinite.
  RHORAY_INLINE static bool has_data(const TrilinearCell& cell) { return cell.has_data(); }

  RHORAY_INLINE std::uint64_t cell_id(const Index3& c) const {
    const Index3& count = levels_->shape.leaf_count;
    return static_cast<std::uint64_t>((c.z * count.y + c.y) * count.x + c.x);
  }

 private:
  using Leaf = nanovdb::NanoLeaf<float>;
  // z varies fastest in a leaf.
  static constexpr std::size_t x_stride = Leaf::DIM * Leaf::DIM, y_stride = Leaf::DIM;

  struct Levels {
    formats::MacroShape shape;
    std::vector<std::vector<float>> ranges;  ///< [level - 1]: in the layout of MacroLevelsView
    formats::MacroLevelsView<float> view;
    Interval<float> values;
    bool has_gaps = false;
  };

  RHORAY_INLINE nanovdb::Coord voxel(const Index3& sample) const {
    return {static_cast<std::int32_t>(first_sample_.x + sample.x),
            static_cast<std::int32_t>(first_sample_.y + sample.y),
            static_cast<std::int32_t>(first_sample_.z + sample.z)};
  }
  Interval<float> sample_range(const Index3& first, const Index3& last, std::atomic<bool>& has_gaps) const;
  Interval<float> cell_range(const Index3& first, const Index3& last) const;
  void build_lowest_level(Levels& levels) const;

  formats::VdbGrid grid_;  ///< keeps the buffer alive
  const nanovdb::NanoTree<float>* tree_;
  Index3 first_sample_;
  std::shared_ptr<Levels> levels_;
  /// Null where macrocells of the lowest level are larger.
  std::shared_ptr<const LeafBricks> bricks_;
};

}  // namespace rhoray::render

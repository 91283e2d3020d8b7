#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "formats/base/stoppable_mutex.h"
#include "formats/base/vector.h"
#include "render/query/last_isovalues.h"
#include "render/tets/tet_data.h"
#include "render/traverse/surface_boxes.h"
#include "render/triangles/array_pool.h"
#include "render/triangles/facet_block.h"
#include "render/triangles/facet_neighbours.h"
#include "render/triangles/triangle_data.h"

namespace rhoray::render {

/// An isosurface of a mesh, or a surface's triangles, prepared for ray tracing. For an isosurface:
/// the field in a cell is linear, so its surface there is a triangle or a quadrilateral whose
/// corners are on the cell's edges.
///
/// A corner's position is computed from the edge's two points, in increasing order of their
/// indices, and rounded to single precision last. All cells around an edge therefore get the same
/// bits, so facets share corners and edges just as cells share edges and faces. Where a point's
/// value is the isovalue, corners coincide with the point, and facets may shrink to edges or
/// points.
///
/// Corners are in the facets' own frame: (p - anchor) * scale, at most 1 from its middle along each
/// axis. Single precision moves them by at most 2^-25 there.
///
/// The facets are ordered along a Morton curve through their middles. Above them is a tree with 16
/// children per node: child c of node n of a level is node 16 n + c of the level below; level 0 is
/// above the blocks. The last level has one node.
class Facets {
 public:
  /// @param bounds   of all points of the mesh, in its frame
  /// @param threads  0 = all cores; the result is the same for any number
  /// @param stop     ends the preparation (ErrorCode::interrupted)
  /// @param pool     gives the memory, if there is one
  Facets(const TetData& view, const Box3& bounds, double isovalue, unsigned threads, const std::stop_token& stop = {},
         const std::shared_ptr<ArrayPool>& pool = {});

  /// Prepares the triangles of a surface. A point has the same bits in all triangles that share it.
  Facets(const TriangleData& view, const Box3& bounds, unsigned threads, const std::stop_token& stop = {});

  std::uint32_t count() const { return count_; }
  const FacetBlock* blocks() const { return blocks_.data(); }
  const FacetField* fields() const { return fields_.data(); }  ///< one per facet
  int level_count() const { return static_cast<int>(levels_.size()); }
  const FacetNode* level(int l) const { return levels_[static_cast<std::size_t>(l)].data(); }
  const BoxLevels& levels() const { return levels_; }

  const Vec3& anchor() const { return anchor_; }
  double scale() const { return scale_; }                   ///< a power of two
  const std::array<float, 3>& low() const { return low_; }  ///< of all corners
  const std::array<float, 3>& high() const { return high_; }

  /// Computed at the first call. Any thread may call.
  /// @param stop  ends it (ErrorCode::interrupted); then the next call repeats it
  const FacetNeighbours& neighbours(const std::stop_token& stop = {}) const;

  std::size_t size_bytes() const;  ///< with neighbours, if they are computed

 private:
  std::size_t block_count() const { return (std::size_t{count_} + FacetBlock::size - 1) / FacetBlock::size; }
  void set_frame(const Box3& bounds);
  Vec3 in_frame(const std::array<double, 3>& p) const;
  void build_levels();

  std::uint32_t count_ = 0;
  PooledArray<FacetBlock> blocks_;
  PooledArray<FacetField> fields_;
  BoxLevels levels_;
  Vec3 anchor_;
  double scale_ = 1;
  std::array<float, 3> low_{}, high_{};
  mutable StoppableMutex neighbours_mutex_;
  mutable std::unique_ptr<const FacetNeighbours> neighbours_;
};

/// Caches the facets of one mesh for the most recently used isovalues, or those of one surface. Any
/// thread may call.
class FacetsCache {
 public:
  std::shared_ptr<const Facets> of(const TetData& view, const Box3& bounds, double isovalue, unsigned threads,
                                   const std::stop_token& stop = {}) {
    return last_.of(isovalue, stop,
                    [&] { return std::make_shared<const Facets>(view, bounds, isovalue, threads, stop, pool_); });
  }
  /// Ignores the isovalue: a surface has none.
  std::shared_ptr<const Facets> of(const TriangleData& view, const Box3& bounds, double, unsigned threads,
                                   const std::stop_token& stop = {}) {
    return last_.of(0, stop, [&] { return std::make_shared<const Facets>(view, bounds, threads, stop); });
  }

  std::size_t size_bytes() {
    return last_.sum([](const Facets& facets) { return facets.size_bytes(); }, [&] { return pool_->unused_bytes(); });
  }
  /// Arrays that are in use go back to the old pool, which ends with the last of them.
  void clear() {
    last_.clear([&] { pool_ = std::make_shared<ArrayPool>(); });
  }

 private:
  std::shared_ptr<ArrayPool> pool_ = std::make_shared<ArrayPool>();
  LastIsovalues<Facets> last_;
};

}  // namespace rhoray::render

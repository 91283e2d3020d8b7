#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/rising.h"
#include "formats/tet_mesh.h"
#include "tools/lab/structures/plain_mesh.h"

/// Meshes whose points take fewer bytes, in the form that the scalar search expects
/// (render/mesh_search.h). Cells are those of the packed mesh's clusters, four bytes each.
namespace rhoray::study {

/// The common part: cells and values of a packed mesh with clusters.
class ClusteredCells {
 public:
  explicit ClusteredCells(const formats::TetMesh& packed) : packed_(packed), values_(packed.values<float>(0)) {}

  /// Indices in the clusters' tables, ascending; in a table, point indices ascend too.
  struct Vertices {
    std::uint64_t cluster;
    std::array<std::uint64_t, 4> entry;
  };
  RHORAY_INLINE Vertices vertices(std::uint32_t cell) const { return sorted_vertices(cell); }
  RHORAY_INLINE Vertices sorted_vertices(std::uint32_t cell) const {
    const formats::CellClustersView& clusters = packed_.clusters();
    const std::array<std::uint8_t, 4> v = rising(clusters.corners[cell]);
    const std::uint64_t cluster = clusters.cluster_of(cell), start = clusters.table_starts[cluster];
    return {cluster, {start + v[0], start + v[1], start + v[2], start + v[3]}};
  }
  RHORAY_INLINE std::uint32_t point(std::uint64_t entry) const { return packed_.clusters().tables[entry]; }
  RHORAY_INLINE std::array<double, 4> values_at(const Vertices& v) const {
    return {values_[point(v.entry[0])], values_[point(v.entry[1])], values_[point(v.entry[2])],
            values_[point(v.entry[3])]};
  }
  std::uint64_t cell_id(std::uint32_t cell) const { return packed_.cell_id(cell); }
  const formats::TetMesh& packed() const { return packed_; }

 private:
  const formats::TetMesh& packed_;
  std::span<const float> values_;
};

/// Points as packed: 24 bytes each.
class DoublePoints : public ClusteredCells {
 public:
  explicit DoublePoints(const formats::TetMesh& packed) : ClusteredCells(packed), points_(packed.points()) {}

  std::uint64_t bytes() const { return points_.size_bytes(); }
  RHORAY_INLINE std::array<double, 3> place(std::uint64_t, std::uint64_t entry) const { return points_[point(entry)]; }
  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const Vertices& v) const {
    return {points_[point(v.entry[0])], points_[point(v.entry[1])], points_[point(v.entry[2])],
            points_[point(v.entry[3])]};
  }

 private:
  std::span<const std::array<double, 3>> points_;
};

/// Points as floats: 12 bytes each.
class FloatPoints : public ClusteredCells {
 public:
  explicit FloatPoints(const formats::TetMesh& packed);

  std::uint64_t bytes() const { return points_.size() * sizeof points_[0]; }
  RHORAY_INLINE std::array<double, 3> place(std::uint64_t, std::uint64_t entry) const {
    const std::array<float, 3>& p = points_[point(entry)];
    return {p[0], p[1], p[2]};
  }
  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const Vertices& v) const {
    return {place(v.cluster, v.entry[0]), place(v.cluster, v.entry[1]), place(v.cluster, v.entry[2]),
            place(v.cluster, v.entry[3])};
  }

 private:
  std::vector<std::array<float, 3>> points_;
};

/// Points on one lattice with 2^21 steps per axis over the mesh: 8 bytes each.
class LatticePoints : public ClusteredCells {
 public:
  explicit LatticePoints(const formats::TetMesh& packed);

  std::uint64_t bytes() const { return points_.size() * sizeof points_[0]; }
  RHORAY_INLINE std::array<double, 3> place(std::uint64_t, std::uint64_t entry) const {
    const std::uint64_t p = points_[point(entry)];
    constexpr std::uint64_t axis = (1 << 21) - 1;
    return {low_[0] + static_cast<double>(p & axis) * step_[0],
            low_[1] + static_cast<double>(p >> 21 & axis) * step_[1],
            low_[2] + static_cast<double>(p >> 42) * step_[2]};
  }
  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const Vertices& v) const {
    return {place(v.cluster, v.entry[0]), place(v.cluster, v.entry[1]), place(v.cluster, v.entry[2]),
            place(v.cluster, v.entry[3])};
  }

 private:
  std::array<double, 3> low_, step_;
  std::vector<std::uint64_t> points_;
};

/// Formats of a position inside a cluster's box: 16 bits per axis in 6 bytes, or 11, 11 and 10 bits
/// in 4.
struct SixteenBits {
  using Stored = std::array<std::uint16_t, 3>;
  static constexpr std::array<std::uint32_t, 3> largest{65535, 65535, 65535};
  static Stored packed(const std::array<std::uint32_t, 3>& steps) {
    return {static_cast<std::uint16_t>(steps[0]), static_cast<std::uint16_t>(steps[1]),
            static_cast<std::uint16_t>(steps[2])};
  }
  RHORAY_INLINE static std::array<double, 3> unpacked(const Stored& stored) {
    return {static_cast<double>(stored[0]), static_cast<double>(stored[1]), static_cast<double>(stored[2])};
  }
};
struct ElevenBits {
  using Stored = std::uint32_t;
  static constexpr std::array<std::uint32_t, 3> largest{2047, 2047, 1023};
  static Stored packed(const std::array<std::uint32_t, 3>& steps) { return steps[0] | steps[1] << 11 | steps[2] << 22; }
  RHORAY_INLINE static std::array<double, 3> unpacked(Stored stored) {
    return {static_cast<double>(stored & 2047), static_cast<double>(stored >> 11 & 2047),
            static_cast<double>(stored >> 22)};
  }
};

/// Points of each cluster on a lattice over its own box, stored once for each cluster that has
/// them. The positions of one point differ from cluster to cluster.
template <class Bits>
class ClusterPoints : public ClusteredCells {
 public:
  explicit ClusterPoints(const formats::TetMesh& packed) : ClusteredCells(packed) {
    const formats::CellClustersView& clusters = packed.clusters();
    for (std::uint64_t cluster = 0; cluster < clusters.cluster_count(); ++cluster)
      for (const std::uint32_t point : clusters.table(cluster)) {
        const Box box = box_of(cluster);
        std::array<std::uint32_t, 3> steps{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double place = (packed.points()[point][axis] - box.low[axis]) / box.step[axis];
          // A flat cluster has one position.
          const double nearest = box.step[axis] > 0 ? place + 0.5 : 0;
          steps[axis] = std::min(static_cast<std::uint32_t>(nearest), Bits::largest[axis]);
        }
        stored_.push_back(Bits::packed(steps));
      }
  }

  std::uint64_t bytes() const { return stored_.size() * sizeof stored_[0]; }
  RHORAY_INLINE std::array<double, 3> place(std::uint64_t cluster, std::uint64_t entry) const {
    return placed(box_of(cluster), entry);
  }
  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const Vertices& v) const {
    const Box box = box_of(v.cluster);
    return {placed(box, v.entry[0]), placed(box, v.entry[1]), placed(box, v.entry[2]), placed(box, v.entry[3])};
  }

 private:
  struct Box {
    std::array<double, 3> low, step;
  };
  /// Computed from the tree's box, rounded outwards: needs no storage.
  RHORAY_INLINE Box box_of(std::uint64_t cluster) const {
    const formats::CellClustersView& clusters = packed().clusters();
    const formats::BoxBlock& block = clusters.boxes[0][cluster / formats::ClusterShape::width];
    const std::size_t e = cluster % formats::ClusterShape::width;
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double lo = block.lo[axis][e], hi = block.hi[axis][e];
      box.low[axis] = lo * clusters.box_unit;
      box.step[axis] = (hi - lo) * clusters.box_unit / Bits::largest[axis];
    }
    return box;
  }
  RHORAY_INLINE std::array<double, 3> placed(const Box& box, std::uint64_t entry) const {
    const std::array<double, 3> steps = Bits::unpacked(stored_[entry]);
    return {box.low[0] + steps[0] * box.step[0], box.low[1] + steps[1] * box.step[1],
            box.low[2] + steps[2] * box.step[2]};
  }

  std::vector<typename Bits::Stored> stored_;
};

/// The effect of rounding on a mesh.
struct RoundedShape {
  std::uint64_t folded_cells = 0;  ///< cells that changed orientation or became flat
  std::uint64_t split_points = 0;  ///< points with several positions
  /// Largest distance of two positions of one point, over the longest edge of a cell of one of
  /// them.
  double widest_gap_edges = 0;
};
template <class Mesh>
RoundedShape shape_of(const Mesh& rounded);

}  // namespace rhoray::study

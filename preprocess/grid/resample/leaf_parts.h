#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/grid/resample/lattice.h"
#include "preprocess/grid/resample/points.h"
#include "preprocess/mesh/inspect/clean_mesh.h"

namespace rhoray::preprocess {

/// The part of a tetrahedron in a box.
struct ClippedVolume {
  double volume = 0;
  Point center{};  ///< centre of mass; meaningless when the volume is 0
};

/// The volume is accurate to about 1e-14 of the box's volume. Where the tetrahedron is clipped,
/// less than 1e-13 of the box's volume is treated as zero.
/// @param tetrahedron  not of negative orientation
ClippedVolume clip_to_box(const std::array<Point, 4>& tetrahedron, const Point& low, const Point& high);

/// The parts of a brick's tetrahedra in some of its leaf cells.
class LeafParts {
 public:
  /// x fastest
  using Leaves = std::bitset<static_cast<std::size_t>(SampleLattice::brick_samples)>;

  struct Part {
    std::uint32_t cell;  ///< of the mesh
    std::uint32_t leaf;  ///< of the brick, x fastest
    double volume;       ///< above 0, in leaf cells
    Point center;        ///< centre of mass, in steps from the brick's first sample
  };

  /// @param steps  the mesh's points, in steps of the lattice
  LeafParts(const CleanMesh& mesh, const std::vector<Point>& steps) : mesh_(mesh), steps_(steps) {}

  /// Finds the parts with a volume, in the order of `cells`.
  /// @param first   the brick's first sample, in steps of the lattice
  /// @param cells   those of the mesh that touch the brick
  /// @param margin  every leaf cell is shrunk by this many steps on each side
  const std::vector<Part>& find(const Point& first, std::span<const std::uint32_t> cells, const Leaves& leaves,
                                double margin);

 private:
  void add_parts_of(std::uint32_t cell, const std::array<Point, 4>& corners, const Leaves& leaves, double margin);

  const CleanMesh& mesh_;
  const std::vector<Point>& steps_;
  std::vector<Part> parts_;
};

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "formats/base/progress.h"
#include "preprocess/grid/resample/lattice.h"
#include "preprocess/mesh/inspect/choose_fields.h"
#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/mesh/leaf_lists/build_leaf_lists.h"

namespace rhoray::preprocess {

/// Bricks of 8 x 8 x 8 samples that a mesh touches, each with the cells that touch it. Also the
/// bricks above them on any axes, whose first samples are corners of leaf cells that the mesh
/// touches.
struct TouchedBricks {
  static constexpr std::uint32_t none = 0xffffffff;

  Index3 count;                       ///< bricks per axis
  LeafLists lists;                    ///< by brick: cells that touch its 8 x 8 x 8 leaf cells
  std::vector<std::uint32_t> slots;   ///< by brick, or none
  std::vector<std::uint32_t> bricks;  ///< by slot, ascending

  Index3 at(std::size_t slot) const { return at_brick(static_cast<std::int64_t>(bricks[slot])); }
  Index3 at_brick(std::int64_t brick) const {
    return {brick % count.x, brick / count.x % count.y, brick / count.x / count.y};
  }
  std::int64_t number(const Index3& brick) const { return (brick.z * count.y + brick.y) * count.x + brick.x; }

  /// The slot of a brick that may lie beyond the last one on an axis.
  std::uint32_t slot(const Index3& brick) const {
    if (brick.x >= count.x || brick.y >= count.y || brick.z >= count.z) return none;
    return slots[static_cast<std::size_t>(number(brick))];
  }
};

TouchedBricks find_touched_bricks(const CleanMesh& mesh, const SampleLattice& lattice, const Progress& progress);

/// One number for each sample of each touched brick, in the order of slots, x fastest in a brick.
/// NaN where there is no data and beyond the lattice.
using BrickValues = std::variant<Array<float>, Array<double>>;

/// A sample for which a second cell gives another value than the first.
struct Conflict {
  std::uint32_t slot;
  std::uint32_t sample;  ///< in the brick
  double difference;
};

struct BrickSamples {
  std::vector<BrickValues> fields;               ///< one for each of the mesh's, of the same type
  std::vector<std::vector<Conflict>> conflicts;  ///< by field; by slot, ascending
  std::vector<std::uint32_t> inside_counts;      ///< by slot: samples inside the mesh
  std::uint64_t inside_count = 0;
  /// samples inside the mesh in several cells, except at shared faces
  std::uint64_t overlap_count = 0;
  /// by slot: samples that have a value only by extend_samples, for the field with the most of them
  std::vector<std::uint32_t> extended_counts;
  std::uint64_t extended_count = 0;  ///< of all slots
};

/// Samples the fields. A value is linear in the cell that holds the sample (locate.h), computed in
/// double. It never leaves the range of the values at the cell's four vertices except for rounding
/// to the field's own type. It is NaN outside the mesh, and where one of the four vertices has no
/// data in every cell that holds the sample. (extend.h gives values to those that leaf cells need.)
BrickSamples sample_fields(const CleanMesh& mesh, const std::vector<ScalarField>& fields, const SampleLattice& lattice,
                           const TouchedBricks& touched, const Progress& progress);

}  // namespace rhoray::preprocess

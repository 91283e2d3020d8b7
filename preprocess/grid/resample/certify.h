#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/grid/resample/faces.h"
#include "preprocess/grid/resample/field_view.h"
#include "preprocess/grid/resample/sample.h"

namespace rhoray::preprocess {

/// The difference between the trilinear field of the samples and the mesh's piecewise linear field.
///
/// It is taken at all points of the mesh where its field has data, in leaf cells whose eight
/// samples have values. Samples outside the mesh count too (extend.h). The leaf cell (i, j, k)
/// belongs to the brick of its first sample. Where cells of the mesh overlap, the trilinear field
/// is compared with each of them.
struct FieldErrors {
  /// Type of all bounds and means: they are rounded up to its numbers.
  formats::ElementType type = formats::ElementType::F32;
  /// By slot. An upper bound of the difference (not an estimate); 0 in a brick without such leaf
  /// cells. Either it exceeds a difference that is attained in the brick by at most a twentieth, or
  /// it exceeds the grid's largest attained difference by no more than that. Where a brick cannot
  /// hold the largest error, its bound may therefore be several times the attained difference.
  /// Differences below 1e-6 of the field's range are not distinguished.
  std::vector<double> max;
  /// By slot. Root mean square over one point in each leaf cell: an estimate. Only every fourth
  /// leaf cell has a point where there are more than 1024 bricks, every sixteenth where there are
  /// more than 16384 (locate.h: rows_of_probes).
  std::vector<double> rms;

  double max_error = 0;                 ///< of all bricks
  double attained = 0;                  ///< largest difference found at a point
  std::array<double, 3> attained_at{};  ///< that point, in steps of the lattice
  double rms_error = 0;                 ///< over all points
  std::uint64_t point_count = 0;        ///< points of the estimate

  /// Fraction of the mesh's volume where the field has data that lies in leaf cells whose eight
  /// samples have values. Computed from the parts of tetrahedra in the other leaf cells: exact
  /// except for rounding. 1 where the field has no data.
  double coverage = 1;
};

struct Certificates {
  std::vector<FieldErrors> fields;
};

/// Computes the errors of all fields and their bounds.
///
/// In the part of a leaf cell that lies in one tetrahedron, the difference is harmonic, so its
/// extremes lie on the faces of tetrahedra. (On a side of the leaf cell it is bilinear, and zero at
/// a sample in the mesh.) There it is a cubic, bounded by Bernstein coefficients
/// (trilinear_patch.h) and subdivision.
///
/// Most leaf cells are decided without their faces, by the range of the gradients in them
/// (quick_bounds.h). Only those whose bound exceeds the difference attained elsewhere need the
/// faces. On each face, the trilinear function minus its linear part at the cell's centre is at
/// most its value at the worst of the cell's corners. The rest is linear (brick_faces.h). Only
/// faces whose bound still exceeds the attained difference are clipped and subdivided. Leaf cells
/// touched by a face without a neighbour are always examined, except where the face lies in a side
/// of the lattice.
///
/// @param views  one for each field
/// @param steps  the mesh's points, in steps of the lattice
Certificates certify(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                     const FaceNeighbors& neighbors, const SampleLattice& lattice, const TouchedBricks& touched,
                     const BrickSamples& samples, const Progress& progress);

}  // namespace rhoray::preprocess

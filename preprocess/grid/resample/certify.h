#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/grid/resample/faces.h"
#include "preprocess/grid/resample/field_view.h"
#include "preprocess/grid/resample/sample.h"

namespace rhoray::preprocess {

/// How far the trilinear field between the samples lies from the mesh's piecewise linear one.
///
/// Compared are all points of the mesh where its field has data, in leaf cells whose eight samples have values, those
/// outside the mesh too (extend.h); the leaf cell (i, j, k) belongs to the brick of its first sample. Where cells of
/// the mesh overlap, the trilinear field is compared with each of them.
struct FieldErrors {
  /// In which all bounds and means are kept: rounded up to numbers of this type.
  formats::ElementType type = formats::ElementType::F32;
  /// By slot. An upper bound of the difference (not an estimate), 0 in a brick without such leaf cells. Either it
  /// exceeds a difference that is attained in the brick by at most a twentieth, or the grid's largest attained
  /// difference by no more than that: where a brick cannot hold the largest error, its bound may be some times what is
  /// attained in it. Differences below 1e-6 of the field's range are not told apart.
  std::vector<double> max;
  /// By slot. Root mean square over one point in each leaf cell, in every fourth where there are more than 1024 bricks,
  /// in every sixteenth where there are more than 16384 (locate.h: rows_of_probes): an estimate.
  std::vector<double> rms;

  double max_error = 0;                 ///< of all bricks
  double attained = 0;                  ///< the largest difference at a point that was looked at
  std::array<double, 3> attained_at{};  ///< that point, in steps of the lattice
  double rms_error = 0;                 ///< over all points
  std::uint64_t point_count = 0;        ///< points of the estimate

  /// Share of the mesh's volume where the field has data that lies in leaf cells whose eight samples have values. Added
  /// up from the parts of tetrahedra in the other leaf cells: exact but for rounding. 1 where the field has no data.
  double coverage = 1;
};

struct Certificates {
  std::vector<FieldErrors> fields;
};

/// The difference is harmonic in the part of a leaf cell that lies in one tetrahedron, so its extremes lie on the faces
/// of tetrahedra (on a side of the leaf cell it is bilinear, and zero at a sample in the mesh). There it is a cubic,
/// bounded by Bernstein coefficients (trilinear_patch.h) and subdivision. Most leaf
/// cells are decided without, by the range of the gradients in them (quick_bounds.h): only those with a larger bound
/// than what is attained elsewhere need the faces themselves. On each face the trilinear function less its linear part
/// at the cell's middle is at most what it is at the worst of the cell's corners, and the rest is linear
/// (brick_faces.h); only faces on which this leaves more than what is attained are cut and subdivided. Leaf cells
/// touched by a face without a neighbour are always looked at, except where the face lies in a side of the lattice.
///
/// @param views  one for each field; steps: the mesh's points, in steps of the lattice
Certificates certify(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                     const FaceNeighbors& neighbors, const SampleLattice& lattice, const TouchedBricks& touched,
                     const BrickSamples& samples, const Progress& progress);

}  // namespace rhoray::preprocess

#pragma once

#include <bitset>
#include <vector>

#include "preprocess/grid/resample/brick_errors.h"
#include "preprocess/grid/resample/neighborhood.h"
#include "preprocess/grid/resample/quick_bounds.h"
#include "preprocess/grid/resample/trilinear_patch.h"

namespace rhoray::preprocess {

/// Computes the bounds of one brick at a time: quick bounds where they are tight enough, else
/// bounds from faces in leaf cells.
class BrickBounds {
 public:
  /// by which a bound may exceed an attained difference
  static constexpr double relative_gap = 0.05;
  static constexpr double gap_of_range = 1e-6;  ///< or this fraction of the field's range

  BrickBounds(const CleanMesh& mesh, const FaceNeighbors& neighbors, const std::vector<std::uint8_t>& open_faces,
              const std::vector<Point>& steps, const TouchedBricks& touched, const BrickSamples& samples)
      : neighbors_(neighbors),
        touched_(touched),
        samples_(samples),
        faces_(mesh, steps),
        quick_(mesh, steps, neighbors, open_faces) {}

  void enter(std::size_t slot);

  /// Adds the bound, and the differences attained while computing it, to the probes' attained
  /// differences.
  /// @param good_enough  a bound up to this value is accepted unrefined
  void bound(const FieldView& field, std::size_t f, double good_enough, BrickErrors& errors);

 private:
  struct Candidate {
    double bound;
    std::uint32_t block, cell;
  };
  struct Piece {
    double upper;
    std::array<PatchPoint, 3> triangle;
    friend bool operator<(const Piece& a, const Piece& b) { return a.upper < b.upper; }
  };
  /// A leaf cell whose faces are examined.
  struct LeafCell {
    Point low;  ///< its first sample, in steps from the brick's first sample
    std::array<double, 8> corners;
  };

  void take_conflicts(const FieldView& field, BrickErrors& errors);
  void take_conflict(const std::array<std::size_t, 3>& sample, double difference, BrickErrors& errors);
  void refine(const FieldView& field, double good_enough, BrickErrors& errors);
  std::uint64_t blocks_above(double goal, const FieldView& field, BrickErrors& errors) const;
  void find_candidates(std::uint64_t blocks, double goal, const FieldView& field, BrickErrors& errors);
  void refine_cell(const Candidate& candidate, const FieldView& field, double good_enough, BrickErrors& errors);
  void add_face(const BrickFace& face, const LeafCell& leaf, const CellPlane& plane, const FieldView& field,
                double good_enough, BrickErrors& errors);
  void add_piece(const std::array<PatchPoint, 3>& triangle, const LeafCell& leaf, const FieldView& field,
                 double good_enough, BrickErrors& errors);

  const FaceNeighbors& neighbors_;
  const TouchedBricks& touched_;
  const BrickSamples& samples_;

  Index3 brick_;
  Point first_{};  ///< the brick's first sample, in steps of the lattice
  std::span<const std::uint32_t> cells_;
  BrickFaces faces_;
  QuickBounds quick_;
  Neighborhood samples_nearby_;
  /// leaf cells beside samples that several mesh cells claim
  std::bitset<SampleLattice::brick_samples> conflicts_;
  std::vector<Candidate> candidates_;
  std::vector<Piece> pieces_;
};

}  // namespace rhoray::preprocess

#pragma once

#include "preprocess/grid/resample/brick_errors.h"
#include "preprocess/grid/resample/field_view.h"
#include "preprocess/grid/resample/leaf_parts.h"
#include "preprocess/grid/resample/locate.h"
#include "preprocess/grid/resample/neighborhood.h"

namespace rhoray::preprocess {

/// Measures the differences at the probes of one brick at a time, and how much of the mesh is not
/// covered.
class BrickProbes {
 public:
  /// @param steps  the mesh's points, in steps of the lattice
  BrickProbes(const CleanMesh& mesh, const std::vector<Point>& steps, const SampleLattice& lattice,
              const TouchedBricks& touched, const BrickSamples& samples)
      : mesh_(mesh), lattice_(lattice), touched_(touched), samples_(samples), parts_(mesh, steps) {}

  /// Locates the probes of a brick, for all fields.
  void enter(std::size_t slot, std::int64_t row_step);
  BrickErrors measure(const FieldView& field, std::size_t f);

 private:
  double uncovered_volume(const FieldView& field);
  Point first_sample() const;
  double row_place(std::size_t axis, std::size_t i) const;

  const CleanMesh& mesh_;
  const SampleLattice& lattice_;
  const TouchedBricks& touched_;
  const BrickSamples& samples_;

  Index3 brick_;
  PointRows probes_;
  Places places_;
  Neighborhood samples_nearby_;
  LeafParts parts_;
};

}  // namespace rhoray::preprocess

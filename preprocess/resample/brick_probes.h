#pragma once

#include "preprocess/resample/brick_errors.h"
#include "preprocess/resample/field_view.h"
#include "preprocess/resample/locate.h"
#include "preprocess/resample/neighborhood.h"

namespace rhoray::preprocess {

/// The differences at the probes of one brick after another.
class BrickProbes {
 public:
  BrickProbes(const CleanMesh& mesh, const SampleLattice& lattice, const TouchedBricks& touched,
              const BrickSamples& samples)
      : mesh_(mesh), lattice_(lattice), touched_(touched), samples_(samples) {}

  /// Finds where the probes of a brick lie, for all fields.
  void enter(std::size_t slot, std::int64_t row_step);
  BrickErrors measure(const FieldView& field, std::size_t f);

  std::size_t in_mesh() const;
  /// After measure: probes in the mesh, but in leaf cells without a trilinear field.
  std::size_t uncovered() const;

 private:
  double row_place(std::size_t axis, std::size_t i) const;

  const CleanMesh& mesh_;
  const SampleLattice& lattice_;
  const TouchedBricks& touched_;
  const BrickSamples& samples_;

  Index3 brick_;
  PointRows probes_;
  Places places_;
  Neighborhood samples_nearby_;
};

}  // namespace rhoray::preprocess

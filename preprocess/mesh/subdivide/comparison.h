#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/mesh/subdivide/curved_cell.h"
#include "preprocess/mesh/subdivide/shape_functions.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Values compared at one location: the point, then every component of every field.
using Sample = std::vector<double>;

/// Relative distances: geometric, then one for each field.
using Shares = std::vector<double>;

/// Samples curved cells and measures the distance between two samples.
class Comparison {
 public:
  /// The caller owns mesh and cells; points may be added to the mesh.
  /// @param counted  for each point field whether it is compared at all
  Comparison(CellMesh& mesh, std::span<const CurvedCell> cells, const std::vector<bool>& counted);

  std::size_t most_nodes() const { return most_nodes_; }
  std::size_t sample_size() const { return sample_size_; }
  std::size_t share_count() const { return 1 + mesh_.point_fields.size(); }

  /// Samples the curved cell at one location.
  /// @param weights  scratch space for `most_nodes` numbers
  void sample_cell(std::uint32_t curved_cell, const CellPlace& place, std::span<double> weights, Sample& out) const;

  /// Raises `largest` to the relative distances between two samples. A value that is NaN is not
  /// compared.
  void raise(const Sample& a, const Sample& b, double factor, Shares& largest) const;

  /// Stores a sample as a point of the mesh.
  void store(const Sample& sample, std::uint64_t point);

 private:
  void add(std::uint64_t point, double weight, Sample& out) const;
  void measure_box();
  double range_of(const NeutralField& field) const;

  CellMesh& mesh_;
  std::span<const CurvedCell> cells_;
  std::size_t most_nodes_ = 0, sample_size_ = 3;
  double diagonal_ = 0;
  std::vector<double> ranges_;  ///< of each point field; 0 = not compared
};

}  // namespace rhoray::preprocess

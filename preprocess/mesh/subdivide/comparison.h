#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/mesh/subdivide/curved_cell.h"
#include "preprocess/mesh/subdivide/shape_functions.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// What is compared at a place: the point, then every component of every field.
using Sample = std::vector<double>;

/// Distances as shares: geometric, then one for each field.
using Shares = std::vector<double>;

/// Curved cells by their samples, and how far two samples lie apart.
class Comparison {
 public:
  /// Mesh and cells stay with the caller; points may be added to the mesh.
  /// @param counted  for each point field whether it is compared at all
  Comparison(CellMesh& mesh, std::span<const CurvedCell> cells, const std::vector<bool>& counted);

  std::size_t most_nodes() const { return most_nodes_; }
  std::size_t sample_size() const { return sample_size_; }
  std::size_t share_count() const { return 1 + mesh_.point_fields.size(); }

  /// The curved cell at one of its places.
  /// @param weights  room for `most_nodes` numbers
  void sample_cell(std::uint32_t curved_cell, const CellPlace& place, std::span<double> weights, Sample& out) const;

  /// Raises `largest` to the shares between two samples. Where a value is no number, nothing is compared.
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
  std::vector<double> ranges_;  ///< of each point field; 0 = it is not compared
};

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>

#include "preprocess/grid/resample/points.h"

namespace rhoray::preprocess {

/// Errors of one field in one brick's leaf cells.
struct BrickErrors {
  double bound = 0, attained = 0;
  double sum_of_squares = 0;  ///< in FieldView::square_unit, squared
  Point attained_at{};        ///< in steps of the lattice
  std::uint32_t point_count = 0;
  /// of the mesh where the field has data, in leaf cells without a value
  double uncovered_volume = 0;

  void attain(double difference, const Point& at) {
    if (!(difference > attained)) return;
    attained = difference;
    attained_at = at;
  }
};

/// The first sample of leaf cell (i, j, k).
inline Point corner_of(std::size_t i, std::size_t j, std::size_t k) {
  return {static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
}

inline Point plus(const Point& a, const Point& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

}  // namespace rhoray::preprocess

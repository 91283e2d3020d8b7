#pragma once

#include <optional>
#include <span>

#include "formats/base/interval.h"
#include "preprocess/neutral.h"

namespace rhoray::study {

/// A format that stores a field's samples in fewer bits.
struct Storage {
  const char* name;
  int bits;                   ///< of a sample
  formats::ElementType type;  ///< of the packed file: the smallest type that holds them
  /// Whether samples are numbers from 0 to 2^bits - 1, evenly over the field's range; otherwise
  /// floating point.
  bool is_whole;
};
std::span<const Storage> storages();  ///< double, float, half, 16, 12, 10 and 8 bits

/// The samples in such a format, and the conversion of the field's values: own = scale * (value -
/// offset).
struct StoredSamples {
  preprocess::NeutralVolume volume;
  double scale = 1, offset = 0;

  double own(double value) const { return scale * (value - offset); }
};

/// Returns nothing where samples of this type already have as few bits or fewer.
/// @param range  of the field; must not be empty
std::optional<StoredSamples> stored_as(const Storage& storage, const preprocess::NeutralVolume& grid,
                                       const Interval<double>& range);

/// The nearest number of IEEE 754's binary16, ties to even; infinity beyond 65504.
double rounded_to_half(double value);

}  // namespace rhoray::study

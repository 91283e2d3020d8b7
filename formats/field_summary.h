#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/label_names.h"
#include "formats/packed_file.h"

namespace rhoray::formats {

/// Summary of a scalar field, stored in every packed file. Users choose isovalues and windows with
/// it.
struct FieldSummary {
  std::string name;  ///< as in the source; never empty
  std::string unit;  ///< empty: not given by the source
  ElementType type = ElementType::F32;
  Interval<double> range;           ///< of all finite values; empty when there is none
  std::uint64_t no_data_count = 0;  ///< NaN and infinite values; cells that touch one are absent
  /// equal bins over `range`, the last one closed; counts finite values
  std::vector<std::uint64_t> histogram;

  // A grid may hold two lists about its isosurfaces. Their item i describes the isosurface at the
  // middle of bin i of the histogram. Both are estimates from a part of the pairs of neighbouring
  // samples. Both are empty if the file does not hold them.
  std::vector<double> isosurface_area{};  ///< world units squared
  std::vector<double> mean_gradient{};    ///< mean of the magnitude, unit per world unit

  LabelNames label_names{};  ///< empty: not given by the source
};

/// The bin of a finite value of the range: floor((value - lo) / (hi - lo) * bin_count), the last
/// bin closed. 0 when all values are equal.
std::size_t histogram_bin(const Interval<double>& range, std::size_t bin_count, double value);

/// The value below which this share of the values lies, interpolated linearly inside a bin; NaN
/// when no value is finite.
/// @param share in [0, 1]
double percentile(const FieldSummary& field, double share);

/// How far `percentile` may be off: the width of a bin.
double percentile_error(const FieldSummary& field);

/// The threshold that splits the histogram into two classes with the largest between-class variance
/// (Otsu, IEEE Trans. SMC 9, 1979); nothing when all values are equal or none is finite.
std::optional<double> otsu_threshold(const FieldSummary& field);

}  // namespace rhoray::formats

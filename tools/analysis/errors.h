#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "render/ray_caster.h"

namespace rhoray::tools {

struct Quantiles {
  double median = 0, p99 = 0, largest = 0;
};
/// Quantiles of the finite values; nothing if there are none.
std::optional<Quantiles> quantiles_of(std::vector<double> values);

/// A share of the examined pixels, with the 95 % confidence interval of the share of all pixels
/// (Wilson's interval). If all pixels were examined, the three numbers are equal.
struct Share {
  double found = 0, low = 0, high = 0;
};
Share share_of(std::uint64_t count, std::uint64_t looked_at, bool are_all);

// Values of ErrorList::errors for rays without a numeric error.
inline constexpr float nothing_there = std::numeric_limits<float>::quiet_NaN();  ///< true miss
inline constexpr float is_missed = std::numeric_limits<float>::infinity();
inline constexpr float is_false = -std::numeric_limits<float>::infinity();

/// Errors of a variant, ray by ray, or one of the three values above. For an isosurface they are in
/// cells along the ray, for a largest value in the field's unit.
struct ErrorList {
  std::vector<float> errors;
  std::vector<double> value_errors;  ///< in the field's unit, for rays that hit and should
  /// For copies of a mesh as a grid, ray by ray: 1 where the border between the two causes the
  /// error (border.h), not the samples. Empty where there is no such border.
  std::vector<std::uint8_t> is_border{};
};

/// Statistics of these errors.
struct ErrorCounts {
  std::uint64_t rays = 0, true_hits = 0, missed = 0, false_hits = 0;
  std::optional<Quantiles> error{};  ///< for rays that hit and should, except those at a border
  std::optional<Quantiles> value_error{};

  /// Share of the rays that hit or should hit and have at most this error. Missed and false rays
  /// exceed every limit.
  double within(double limit) const;
  std::uint64_t beyond(double limit) const;  ///< number of the other rays
  /// The error that this share of the rays does not exceed; infinity where too many are missed or
  /// false.
  double kept_by(double share) const;
  std::vector<float> sorted{};  ///< errors of rays that hit and should

  /// Errors caused by the border of a resampled mesh: missed and false hits, and rays that hit and
  /// should.
  struct Border {
    std::uint64_t missed = 0, false_hits = 0, off = 0;

    friend bool operator==(const Border&, const Border&) = default;
  };
  std::optional<Border> border{};  ///< only if there is such a border
};
ErrorCounts count_errors(const ErrorList& list);

}  // namespace rhoray::tools

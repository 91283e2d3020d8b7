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
/// Of the values that are finite; nothing when there is none.
std::optional<Quantiles> quantiles_of(std::vector<double> values);

/// A share of some pixels, and between which shares that of all pixels lies with a probability of 95 % (Wilson's
/// interval). Where all pixels were looked at all three are the same.
struct Share {
  double found = 0, low = 0, high = 0;
};
Share share_of(std::uint64_t count, std::uint64_t looked_at, bool are_all);

// What a ray's answer is instead of a number: of ErrorList::errors.
inline constexpr float nothing_there = std::numeric_limits<float>::quiet_NaN();  ///< rightly nothing
inline constexpr float is_missed = std::numeric_limits<float>::infinity();
inline constexpr float is_false = -std::numeric_limits<float>::infinity();

/// Errors of a variant, ray by ray: of an isosurface in cells along the ray, of a largest value in the field's unit;
/// or one of the three above.
struct ErrorList {
  std::vector<float> errors;
  std::vector<double> value_errors;  ///< in the field's unit, of rays that hit and should
  /// Of copies of a mesh as a grid, ray by ray: 1 where the border between the two is to blame (border.h), so that the
  /// samples are not. Empty where there is no such border.
  std::vector<std::uint8_t> is_border{};
};

/// These errors as numbers.
struct ErrorCounts {
  std::uint64_t rays = 0, true_hits = 0, missed = 0, false_hits = 0;
  std::optional<Quantiles> error{};  ///< of rays that hit and should, those at a border left out
  std::optional<Quantiles> value_error{};

  /// The share of rays that hit or should and whose error is at most so much; missed and false ones are beyond all.
  double within(double limit) const;
  std::uint64_t beyond(double limit) const;  ///< the number of the others
  /// The error that this share of them keeps; infinity where too many are missed or false.
  double kept_by(double share) const;
  std::vector<float> sorted{};  ///< errors of rays that hit and should

  /// Where the border of a resampled mesh is to blame: of missed and false_hits, and of the rays that hit and should.
  struct Border {
    std::uint64_t missed = 0, false_hits = 0, off = 0;

    friend bool operator==(const Border&, const Border&) = default;
  };
  std::optional<Border> border{};  ///< only where there is such a border
};
ErrorCounts count_errors(const ErrorList& list);

}  // namespace rhoray::tools

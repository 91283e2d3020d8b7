#include "formats/field_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rhoray::formats {

std::size_t histogram_bin(const Interval<double>& range, std::size_t bin_count, double value) {
  // Halved first, so that the width of a range does not overflow.
  const double width = range.hi / 2 - range.lo / 2;
  if (!(width > 0)) return 0;
  const double position = (value / 2 - range.lo / 2) / width * static_cast<double>(bin_count);
  return static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(bin_count - 1)));
}

double percentile(const FieldSummary& field, double share) {
  if (field.range.is_empty()) return std::numeric_limits<double>::quiet_NaN();
  double total = 0;
  for (const std::uint64_t count : field.histogram) total += static_cast<double>(count);
  const double wanted = std::clamp(share, 0.0, 1.0) * total;

  double below = 0;
  for (std::size_t bin = 0; bin < field.histogram.size(); ++bin) {
    const auto inside = static_cast<double>(field.histogram[bin]);
    if (inside > 0 && below + inside >= wanted) {
      const double bins = (wanted - below) / inside + static_cast<double>(bin);
      return std::lerp(field.range.lo, field.range.hi, bins / static_cast<double>(field.histogram.size()));
    }
    below += inside;
  }
  return field.range.hi;
}

double percentile_error(const FieldSummary& field) {
  const auto bin_count = static_cast<double>(std::max<std::size_t>(field.histogram.size(), 1));
  return field.range.hi / bin_count - field.range.lo / bin_count;
}

std::optional<double> otsu_threshold(const FieldSummary& field) {
  if (field.range.is_empty()) return std::nullopt;
  double total = 0, moment = 0;
  for (std::size_t bin = 0; bin < field.histogram.size(); ++bin) {
    const auto count = static_cast<double>(field.histogram[bin]);
    total += count;
    moment += count * static_cast<double>(bin);
  }

  // Every edge between two bins splits the values. Across a gap of empty bins all edges are equally
  // good, so the threshold is the middle of the best ones.
  double best = 0, low_count = 0, low_moment = 0;
  std::size_t first_edge = 0, last_edge = 0;
  for (std::size_t edge = 1; edge < field.histogram.size(); ++edge) {
    const auto count = static_cast<double>(field.histogram[edge - 1]);
    low_count += count;
    low_moment += count * static_cast<double>(edge - 1);
    const double high_count = total - low_count;
    if (low_count == 0 || high_count == 0) continue;
    const double distance = low_moment / low_count - (moment - low_moment) / high_count;
    const double variance = low_count * high_count * distance * distance;
    if (variance > best) {
      best = variance;
      first_edge = edge;
    }
    if (variance == best) last_edge = edge;
  }
  if (first_edge == 0) return std::nullopt;
  const double middle = static_cast<double>(first_edge + last_edge) / 2;
  return std::lerp(field.range.lo, field.range.hi, middle / static_cast<double>(field.histogram.size()));
}

}  // namespace rhoray::formats

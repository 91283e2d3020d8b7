#include "render/truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rhoray::render {

namespace {

template <class T>
double quantile(const std::vector<T>& sorted, double share) {
  return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
}

template <class T>
std::optional<Quantiles> of_sorted(const std::vector<T>& sorted) {
  if (sorted.empty()) return std::nullopt;
  return Quantiles{quantile(sorted, 0.5), quantile(sorted, 0.99), quantile(sorted, 1)};
}

}  // namespace

std::optional<Quantiles> quantiles_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  std::sort(values.begin(), values.end());
  return of_sorted(values);
}

Share share_of(std::uint64_t count, std::uint64_t looked_at, bool are_all) {
  if (looked_at == 0) return {0, 0, 1};
  const double n = static_cast<double>(looked_at), p = static_cast<double>(count) / n;
  if (are_all) return {p, p, p};
  constexpr double z = 1.959963984540054;  // 97.5 % quantile of the normal distribution
  const double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {p, count == 0 ? 0 : std::max(0.0, middle - half), count == looked_at ? 1 : std::min(1.0, middle + half)};
}

ErrorCounts count_errors(const ErrorList& list) {
  ErrorCounts counts{.rays = list.errors.size()};
  ErrorCounts::Border border;
  std::vector<float> of_samples;
  for (std::size_t ray = 0; ray < list.errors.size(); ++ray) {
    const float error = list.errors[ray];
    if (std::isnan(error)) continue;
    const bool is_border = !list.is_border.empty() && list.is_border[ray] != 0;
    if (is_border) {
      border.missed += error == is_missed;
      border.false_hits += error == is_false;
      border.off += std::isfinite(error);
    } else if (std::isfinite(error)) {
      of_samples.push_back(error);
    }
    counts.missed += error == is_missed;
    counts.false_hits += error == is_false;
    counts.true_hits += error != is_false;
    if (std::isfinite(error)) counts.sorted.push_back(error);
  }
  std::sort(counts.sorted.begin(), counts.sorted.end());
  std::sort(of_samples.begin(), of_samples.end());
  counts.error = of_sorted(of_samples);
  if (!list.is_border.empty()) counts.border = border;
  counts.value_error = quantiles_of(list.value_errors);
  return counts;
}

double ErrorCounts::within(double limit) const {
  const std::uint64_t seen = true_hits + false_hits;
  return seen == 0 ? 1 : 1 - static_cast<double>(beyond(limit)) / static_cast<double>(seen);
}

std::uint64_t ErrorCounts::beyond(double limit) const {
  const auto first = std::upper_bound(sorted.begin(), sorted.end(), static_cast<float>(limit));
  return true_hits + false_hits - static_cast<std::uint64_t>(first - sorted.begin());
}

double ErrorCounts::kept_by(double share) const {
  const std::uint64_t seen = true_hits + false_hits;
  if (seen == 0) return 0;
  const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(seen))) - 1;
  return at < sorted.size() ? static_cast<double>(sorted[at]) : std::numeric_limits<double>::infinity();
}

}  // namespace rhoray::render

#include "tools/lab/picture_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "formats/base/checks.h"

namespace rhoray::study {

namespace {

/// The value such that the fraction `share` of all values is at or below it; 0 if there are no
/// values.
double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double share_above(const std::vector<double>& sorted, double limit) {
  if (sorted.empty()) return 0;
  const auto above = sorted.end() - std::upper_bound(sorted.begin(), sorted.end(), limit);
  return static_cast<double>(above) / static_cast<double>(sorted.size());
}

}  // namespace

DepthErrors depth_errors(std::span<const double> truth, std::span<const double> found, double voxel) {
  RHORAY_CHECK(truth.size() == found.size());
  DepthErrors errors{.rays = truth.size()};
  std::vector<double> differences;
  bool is_any_known = false;
  for (std::size_t r = 0; r < truth.size(); ++r) {
    const bool is_true = !std::isinf(truth[r]), is_found = !std::isinf(found[r]);
    errors.hits += is_true;
    errors.missed += is_true && !is_found;
    errors.invented += is_found && !is_true;
    if (!is_true || !is_found || std::isnan(found[r])) continue;
    is_any_known = true;
    differences.push_back(std::abs(found[r] - truth[r]) / voxel);
  }
  std::sort(differences.begin(), differences.end());
  errors.has_depth = is_any_known || errors.hits == errors.missed;
  errors.median = quantile(differences, 0.5);
  errors.p99 = quantile(differences, 0.99);
  errors.largest = quantile(differences, 1);
  errors.share_above_1 = share_above(differences, 1);
  return errors;
}

LevelErrors level_errors(std::span<const double> truth, std::span<const double> found, double window) {
  RHORAY_CHECK(truth.size() == found.size() && window > 0);
  LevelErrors errors{.rays = truth.size()};
  std::vector<double> differences;
  for (std::size_t r = 0; r < truth.size(); ++r) {
    const bool is_true = !std::isnan(truth[r]), is_found = !std::isnan(found[r]);
    errors.with_data += is_true;
    errors.missed += is_true && !is_found;
    errors.invented += is_found && !is_true;
    if (is_true && is_found) differences.push_back(255 * std::abs(found[r] - truth[r]) / window);
  }
  std::sort(differences.begin(), differences.end());
  if (!differences.empty())
    errors.mean =
        std::accumulate(differences.begin(), differences.end(), 0.0) / static_cast<double>(differences.size());
  errors.p99 = quantile(differences, 0.99);
  errors.largest = quantile(differences, 1);
  errors.share_above_1 = share_above(differences, 1);
  return errors;
}

}  // namespace rhoray::study

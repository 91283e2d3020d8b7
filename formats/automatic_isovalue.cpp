#include "formats/automatic_isovalue.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace rhoray::formats {

namespace {

// The constants were chosen by looking at 20 volumes: CT and MR of heads and chests, a tooth, an
// engine, an embryo, angiography, PET, simulations. Where a valley is nothing that one would show,
// one of them says so and Otsu's threshold is taken.

/// Fewer bins are labels, not a histogram to be smoothed.
constexpr std::size_t fewest_bins = 64;
/// Standard deviation in bins of the filter before valleys are searched. With 2, the noise-free
/// fuel injection and scans of 8 bits have valleys that nobody sees; with 4, thin ones vanish.
constexpr int smoothing_bins = 3;
/// A valley is this much lower than both peaks, as a logarithm: a fifth of their count.
constexpr double smallest_prominence = 0.25;
/// And by this many standard deviations of the number of samples that its smoothed count comes
/// from.
constexpr double prominence_deviations = 3;
/// The floor of a valley ends here, as a share of the lower peak's prominence. Midway to the far
/// peak of a wide hump would cut the hump in two.
constexpr double floor_height = 0.75;
/// Both sides of a valley hold this share of all samples. Less is noise, saturation, or a marker:
/// the iron protein has 1.2 % at the end of its scale.
constexpr double smallest_side = 0.02;
/// And this share of the smaller side of the valley that parts the samples best. It does not depend
/// on the air around an object. The bones of a head and the sleeves of the engine have 0.06 to
/// 0.08.
constexpr double smallest_part_of_best = 0.1;
/// A valley whose bottom has fewer samples than this share of the lower peak is empty. Blurred
/// boundaries of scans have 0.01 and more.
constexpr double empty_share = 1e-3;
/// Otsu's threshold wins when it is this much stronger than every valley: in a chest CT of 8 bits,
/// the only valley parts the masked outside from the noise of the air.
constexpr double much_stronger = 1.5;

/// A Gaussian filter; near the ends, the weights that are left count.
std::vector<double> smoothed(const std::vector<double>& values) {
  constexpr std::ptrdiff_t reach = 3 * smoothing_bins;
  std::array<double, 2 * reach + 1> weights;
  for (std::ptrdiff_t d = -reach; d <= reach; ++d) {
    const double deviations = static_cast<double>(d) / smoothing_bins;
    weights[static_cast<std::size_t>(d + reach)] = std::exp(-0.5 * deviations * deviations);
  }
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  std::vector<double> result;
  result.reserve(values.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    double sum = 0, weight = 0;
    for (std::ptrdiff_t d = std::max(-reach, -i); d <= std::min(reach, count - 1 - i); ++d) {
      const double w = weights[static_cast<std::size_t>(d + reach)];
      sum += w * values[static_cast<std::size_t>(i + d)];
      weight += w;
    }
    result.push_back(sum / weight);
  }
  return result;
}

/// The numbers, divided by the largest, so that products stay finite.
std::vector<double> scaled(std::vector<double> values) {
  const double largest = *std::max_element(values.begin(), values.end());
  for (double& value : values) value = largest > 0 ? value / largest : 0;
  return values;
}

/// Bins: a bottom and the peaks beside it.
struct Valley {
  std::size_t low_peak, bottom, high_peak;
};

/// All valleys, in rising order.
std::vector<Valley> valleys_of(const std::vector<double>& counts, const std::vector<double>& logarithms) {
  // A smoothed count comes from about 2 sqrt(pi) standard deviations of bins.
  const auto prominence = [&](std::size_t bin) {
    return smallest_prominence + prominence_deviations / std::sqrt(3.5 * smoothing_bins * counts[bin] + 1);
  };
  std::vector<Valley> valleys;
  std::size_t peak = 0, bottom = 0;
  bool falls = false;
  for (std::size_t bin = 1; bin < logarithms.size(); ++bin) {
    if (!falls) {
      if (logarithms[bin] > logarithms[peak]) peak = bin;
      if (logarithms[bin] < logarithms[peak] - prominence(bin)) {
        falls = true;
        bottom = bin;
      }
    } else {
      if (logarithms[bin] < logarithms[bottom]) bottom = bin;
      if (logarithms[bin] > logarithms[bottom] + prominence(bottom)) {
        if (!valleys.empty()) valleys.back().high_peak = peak;
        valleys.push_back({.low_peak = peak, .bottom = bottom, .high_peak = bin});
        falls = false;
        peak = bin;
      }
    }
  }
  if (valleys.empty()) return valleys;
  for (std::size_t bin = valleys.back().high_peak; bin < logarithms.size(); ++bin)
    if (logarithms[bin] > logarithms[valleys.back().high_peak]) valleys.back().high_peak = bin;
  return valleys;
}

/// The bin midway between the peaks, or the end of the floor towards it.
std::size_t middle_of(const Valley& valley, const std::vector<double>& logarithms) {
  const double bottom = logarithms[valley.bottom];
  const double lower_peak = std::min(logarithms[valley.low_peak], logarithms[valley.high_peak]);
  const double ceiling = bottom + floor_height * (lower_peak - bottom);
  std::size_t first = valley.bottom, last = valley.bottom;
  while (first > valley.low_peak && logarithms[first - 1] <= ceiling) --first;
  while (last < valley.high_peak && logarithms[last + 1] <= ceiling) ++last;
  return std::clamp((valley.low_peak + valley.high_peak) / 2, first, last);
}

/// Mean gradient times the root of the area for each bin, in units of its own.
std::vector<double> strengths_of(const FieldSummary& field) {
  const std::vector<double> gradients = scaled(field.mean_gradient), areas = scaled(field.isosurface_area);
  std::vector<double> products;
  for (std::size_t bin = 0; bin < areas.size(); ++bin) products.push_back(gradients[bin] * areas[bin]);
  const std::vector<double> area = smoothed(areas), sum = smoothed(products);
  std::vector<double> strengths;
  for (std::size_t bin = 0; bin < areas.size(); ++bin)
    strengths.push_back(area[bin] > 0 ? sum[bin] / std::sqrt(area[bin]) : 0);
  return strengths;
}

struct Candidate {
  std::size_t bin;
  double smaller_side;  ///< share of the samples
  bool is_empty;
  double strength;
};

}  // namespace

std::optional<AutomaticIsovalue> automatic_isovalue(const FieldSummary& field) {
  const std::optional<double> otsu = otsu_threshold(field);
  if (!otsu) return std::nullopt;
  AutomaticIsovalue result{.value = *otsu, .is_valley = false, .other_valleys = {}, .otsu_threshold = *otsu};
  const std::size_t bins = field.histogram.size();
  if (bins < fewest_bins || field.mean_gradient.size() != bins || field.isosurface_area.size() != bins) return result;

  const std::vector<double> raw_counts(field.histogram.begin(), field.histogram.end());
  const std::vector<double> counts = smoothed(raw_counts), strengths = strengths_of(field);
  std::vector<double> logarithms, below;
  double total = 0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    logarithms.push_back(std::log1p(counts[bin]));
    below.push_back(total);
    total += raw_counts[bin];
  }

  std::vector<Candidate> candidates;
  double best_side = 0;
  for (const Valley& valley : valleys_of(counts, logarithms)) {
    const std::size_t bin = middle_of(valley, logarithms);
    const double share = below[valley.bottom] / total;
    const double lower_peak = std::min(counts[valley.low_peak], counts[valley.high_peak]);
    candidates.push_back({.bin = bin,
                          .smaller_side = std::min(share, 1 - share),
                          .is_empty = counts[valley.bottom] < empty_share * lower_peak,
                          .strength = strengths[bin]});
    best_side = std::max(best_side, candidates.back().smaller_side);
  }
  std::erase_if(candidates, [&](const Candidate& one) {
    return one.smaller_side < std::max(smallest_side, smallest_part_of_best * best_side);
  });
  if (candidates.empty()) return result;
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.is_empty, -a.strength) < std::pair(b.is_empty, -b.strength);
  });

  const auto value_of = [&](std::size_t bin) {
    return std::lerp(field.range.lo, field.range.hi, (static_cast<double>(bin) + 0.5) / static_cast<double>(bins));
  };
  const double strongest = std::max_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
                             return a.strength < b.strength;
                           })->strength;
  result.is_valley = strengths[histogram_bin(field.range, bins, *otsu)] < much_stronger * strongest;
  if (result.is_valley) result.value = value_of(candidates.front().bin);
  for (std::size_t i = result.is_valley ? 1 : 0; i < candidates.size(); ++i)
    result.other_valleys.push_back(value_of(candidates[i].bin));
  return result;
}

}  // namespace rhoray::formats

#include "preprocess/values/summarize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/base/parallel.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

using Counts = std::vector<std::uint64_t>;
constexpr std::size_t largest_bin_count = 256;
// values per task: enough to hide its start, few enough to share out
constexpr std::size_t grain = 1 << 16;

/// Adds up the counts that each thread made for itself. Sums of integers do not depend on the
/// order.
Counts added_up(PerWorker<Counts>& of_threads, std::size_t size) {
  Counts sum(size, 0);
  of_threads.for_each([&](const Counts& counts) {
    for (std::size_t i = 0; i < size; ++i) sum[i] += counts[i];
  });
  return sum;
}

/// Returns the number of bins for a range; 0 when it is empty.
std::size_t bin_count_of(const Interval<double>& range, bool is_integer) {
  if (range.is_empty()) return 0;
  if (range.lo == range.hi) return 1;
  const double bins = is_integer ? range.hi - range.lo + 1 : largest_bin_count;
  return static_cast<std::size_t>(std::min<double>(bins, largest_bin_count));
}

/// For 8- and 16-bit values: one pass counts every value separately, the rest follows from the
/// table.
template <class T>
void summarize_by_table(std::span<const T> values, formats::FieldSummary& field, const Progress& progress) {
  ProgressMeter meter(progress, "finding value ranges (values)", values.size());
  constexpr auto lowest = std::numeric_limits<T>::lowest();
  constexpr std::size_t size = std::size_t{1} << (8 * sizeof(T));
  PerWorker<Counts> of_threads([] { return Counts(size, 0); });
  parallel_for(values.size(), grain, [&](const IndexRange& part) {
    Counts& counts = of_threads.of(part);
    for (std::size_t i = part.begin(); i < part.end(); ++i) ++counts[static_cast<std::size_t>(values[i] - lowest)];
    meter.add(part.size());
  });
  const Counts counts = added_up(of_threads, size);

  const auto value_at = [&](std::size_t i) { return static_cast<double>(i) + static_cast<double>(lowest); };
  for (std::size_t i = 0; i < size; ++i)
    if (counts[i] > 0) field.range.include(value_at(i));
  const std::size_t bins = bin_count_of(field.range, true);
  field.histogram.assign(bins, 0);
  for (std::size_t i = 0; i < size; ++i)
    if (counts[i] > 0) field.histogram[formats::histogram_bin(field.range, bins, value_at(i))] += counts[i];
}

template <class T>
struct Extent {
  Interval<T> range;
  std::uint64_t no_data_count = 0;
};

/// Uses independent lanes, because a float minimum computed in one chain cannot be vectorised.
template <class T>
Extent<T> extent_of(std::span<const T> values) {
  constexpr std::size_t lanes = 64 / sizeof(T);
  std::array<T, lanes> lo, hi;
  lo.fill(Interval<T>::highest());
  hi.fill(Interval<T>::lowest());
  std::uint64_t no_data_count = 0;
  const auto take = [&](std::size_t lane, T value) {
    const bool counts = has_data(value);
    lo[lane] = counts && value < lo[lane] ? value : lo[lane];
    hi[lane] = counts && value > hi[lane] ? value : hi[lane];
    no_data_count += !counts;
  };
  std::size_t i = 0;
  for (; i + lanes <= values.size(); i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) take(lane, values[i + lane]);
  for (; i < values.size(); ++i) take(0, values[i]);

  Extent<T> extent{.range = {}, .no_data_count = no_data_count};
  for (std::size_t lane = 0; lane < lanes; ++lane) extent.range.include(Interval<T>{lo[lane], hi[lane]});
  return extent;
}

template <class T>
void summarize_in_two_passes(std::span<const T> values, formats::FieldSummary& field, const Progress& progress) {
  ProgressMeter finding(progress, "finding value ranges (values)", values.size());
  const auto joined = [](Extent<T> a, const Extent<T>& b) {
    a.range.include(b.range);
    a.no_data_count += b.no_data_count;
    return a;
  };
  const Extent<T> extent = parallel_reduce(
      values.size(), grain, Extent<T>{},
      [&](const IndexRange& part) {
        finding.add(part.size());
        return extent_of(values.subspan(part.begin(), part.size()));
      },
      joined);
  field.no_data_count = extent.no_data_count;
  if (extent.range.is_empty()) return;
  field.range = {static_cast<double>(extent.range.lo), static_cast<double>(extent.range.hi)};

  const std::size_t bins = bin_count_of(field.range, std::is_integral_v<T>);
  ProgressMeter counting(progress, "making the histogram (values)", values.size());
  PerWorker<Counts> of_threads([&] { return Counts(bins, 0); });
  parallel_for(values.size(), grain, [&](const IndexRange& part) {
    Counts& counts = of_threads.of(part);
    for (std::size_t i = part.begin(); i < part.end(); ++i)
      if (has_data(values[i])) ++counts[formats::histogram_bin(field.range, bins, static_cast<double>(values[i]))];
    counting.add(part.size());
  });
  field.histogram = added_up(of_threads, bins);
}

}  // namespace

template <class T>
formats::FieldSummary summarize(std::span<const T> values, std::string name, std::string unit,
                                const Progress& progress) {
  formats::FieldSummary field;
  field.name = std::move(name);
  field.unit = std::move(unit);
  field.type = formats::element_type_of<T>();
  if constexpr (sizeof(T) <= 2)
    summarize_by_table(values, field, progress);
  else
    summarize_in_two_passes(values, field, progress);
  return field;
}

template formats::FieldSummary summarize(std::span<const std::uint8_t>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const std::int8_t>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const std::uint16_t>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const std::int16_t>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const std::uint32_t>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const std::int32_t>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const float>, std::string, std::string, const Progress&);
template formats::FieldSummary summarize(std::span<const double>, std::string, std::string, const Progress&);

}  // namespace rhoray::preprocess

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>

#include "formats/base/floating_point.h"
#include "formats/base/parallel.h"
#include "formats/brick_grid.h"
#include "formats/details/deep_checks.h"
#include "formats/details/range_checks.h"
#include "formats/details/samples_by_position.h"

namespace rhoray::formats {
namespace {

/// Calls act(first, last) on ranges of a z axis, in parallel.
template <class Act>
void over_z(std::int64_t count, Act&& act) {
  for_each_range(static_cast<std::uint64_t>(count), 4, 0, act);
}

/// Reads one field's samples again, by grid index.
template <class T>
class GridCheck {
 public:
  GridCheck(const BrickGrid& grid, std::size_t field, details::Findings& findings)
      : layout_(grid.description().layout),
        summary_(grid.description().fields[field]),
        sample_(grid, field),
        of_field_(grid.description().fields.size() == 1 ? "" : concat(" of field '", summary_.name, "'")),
        findings_(findings) {}

  void run() {
    check_field();
    if (layout_.is_sparse)
      check_padding("padding of a sparse grid that is not NaN", is_nan);
    else
      check_padding("padding that is no copy of the last sample", [this](const Index3& at, T found) {
        const Index3 last = layout_.sample_count - Index3(1, 1, 1);
        const T copied = sample_(std::min(at.x, last.x), std::min(at.y, last.y), std::min(at.z, last.z));
        return std::memcmp(&found, &copied, sizeof(T)) == 0;
      });
  }

 private:
  static bool is_nan(const Index3&, T found) { return std::isnan(static_cast<double>(found)); }

  /// Calls act(low, high) on blocks that cover the lattice of `count` samples, in parallel over
  /// ranges of z: whole layers, or the bricks of a sparse grid. start() creates the state of a
  /// range, done(range) collects it.
  template <class Start, class Act, class Done>
  void over_blocks(const Index3& count, Start&& start, Act&& act, Done&& done) const {
    const std::int64_t n = layout_.is_sparse ? layout_.brick_edge : 0;
    std::mutex guard;
    over_z(n == 0 ? count.z : (count.z + n - 1) / n, [&](std::uint64_t first, std::uint64_t last) {
      auto part = start();
      for (auto k = static_cast<std::int64_t>(first); k < static_cast<std::int64_t>(last); ++k) {
        if (n == 0) {
          act(part, Index3(0, 0, k), Index3(count.x, count.y, k + 1));
          continue;
        }
        for (std::int64_t j = 0; j < count.y; j += n)
          for (std::int64_t i = 0; i < count.x; i += n)
            act(part, Index3(i, j, k * n),
                Index3(std::min(i + n, count.x), std::min(j + n, count.y), std::min((k + 1) * n, count.z)));
      }
      const std::lock_guard lock(guard);
      done(part);
    });
  }

  template <class Act>
  static void over_samples(const Index3& low, const Index3& high, Act&& act) {
    for (std::int64_t k = low.z; k < high.z; ++k)
      for (std::int64_t j = low.y; j < high.y; ++j)
        for (std::int64_t i = low.x; i < high.x; ++i) act(i, j, k);
  }

  void check_field() {
    details::FieldTally all(summary_);
    over_blocks(
        layout_.sample_count, [this] { return details::FieldTally(summary_); },
        [this](details::FieldTally& part, const Index3& low, const Index3& high) {
          if (!sample_.some_stored(low, low))
            part.take_no_data(static_cast<std::uint64_t>(volume(high - low)));
          else
            over_samples(low, high,
                         [&](std::int64_t i, std::int64_t j, std::int64_t k) { part.take(sample_(i, j, k)); });
        },
        [&](const details::FieldTally& part) { all.take(part); });
    all.compare(findings_);
  }

  /// @param holds  true if the padding at an index is correct
  template <class Holds>
  void check_padding(const std::string& kind, Holds&& holds) {
    const Index3 count = layout_.sample_count, padded = layout_.padded_count();
    const auto nothing = [] { return 0; };
    over_blocks(
        padded, nothing,
        [&](int, const Index3& low, const Index3& high) {
          const bool has_padding = high.x > count.x || high.y > count.y || high.z > count.z;
          if (!has_padding || !sample_.some_stored(low, low)) return;
          for (std::int64_t k = low.z; k < high.z; ++k)
            for (std::int64_t j = low.y; j < high.y; ++j)
              for (std::int64_t i = k < count.z && j < count.y ? std::max(count.x, low.x) : low.x; i < high.x; ++i) {
                if (holds(Index3(i, j, k), sample_(i, j, k))) continue;
                findings_.add(concat(kind, of_field_), details::linear_order(padded, i, j, k),
                              [&] { return concat("sample (", i, ", ", j, ", ", k, ")"); });
              }
        },
        [](int) {});
  }

  const BrickLayout& layout_;
  const FieldSummary& summary_;
  details::SamplesByPosition<T> sample_;
  std::string of_field_;  ///< for findings; used if there are several fields
  details::Findings& findings_;
};

/// Checks the errors of every brick, and the totals in the certificate.
template <class T>
void check_certificate(const BrickGrid& grid, std::size_t field, const Certificate& certificate,
                       details::Findings& findings) {
  constexpr double rounding = 4 * static_cast<double>(std::numeric_limits<T>::epsilon());
  const std::span<const T> largest = grid.errors<T>(field, "max"), mean = grid.errors<T>(field, "rms");
  const std::string of = concat(" of field '", grid.description().fields[field].name, "'");
  const Index3 count = grid.description().layout.brick_count();
  double largest_of_all = 0, largest_mean = 0;
  for (std::size_t brick = 0; brick < largest.size(); ++brick) {
    const auto at = static_cast<std::int64_t>(brick);
    const double most = static_cast<double>(largest[brick]), rms = static_cast<double>(mean[brick]);
    const auto found = [&] {
      return concat("brick (", at % count.x, ", ", at / count.x % count.y, ", ", at / count.x / count.y, ") has max ",
                    most, ", rms ", rms);
    };
    if (!(most >= 0 && rms >= 0 && std::isfinite(most) && std::isfinite(rms)))
      findings.add(concat("an error", of, " that is negative or not finite"), brick, found);
    else if (rms > most * (1 + rounding))
      findings.add(concat("a mean error", of, " above the largest"), brick, found);
    largest_of_all = std::max(largest_of_all, most);
    largest_mean = std::max(largest_mean, rms);
  }
  const auto say = [&](const std::string& what, double found, double told) {
    findings.add(concat(what, of, " is wrong"), 0,
                 [&] { return concat("its bricks give ", found, ", the file says ", told); });
  };
  if (std::abs(largest_of_all - certificate.max_error) > rounding * certificate.max_error)
    say("the largest error", largest_of_all, certificate.max_error);
  if (certificate.rms_error > largest_mean * (1 + rounding)) say("the mean error", largest_mean, certificate.rms_error);
}

}  // namespace

std::vector<std::string> deep_findings(const BrickGrid& grid) {
  const DefaultFloatingPoint default_floating_point;
  details::Findings findings;
  const GridDescription& description = grid.description();
  for (std::size_t field = 0; field < description.fields.size(); ++field)
    with_element_type(description.fields[field].type,
                      [&](auto zero) { GridCheck<decltype(zero)>(grid, field, findings).run(); });
  for (std::size_t field = 0; field < description.fields.size(); ++field)
    details::check_ranges(grid, field, {}, findings);
  for (const auto& [field, certificate] : description.certificates)
    if (certificate.type == ElementType::F32)
      check_certificate<float>(grid, field, certificate, findings);
    else
      check_certificate<double>(grid, field, certificate, findings);
  return findings.sentences();
}

}  // namespace rhoray::formats

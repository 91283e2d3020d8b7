#include "formats/details/deep_checks.h"

#include <algorithm>

#include "formats/base/stopping.h"

namespace rhoray::formats::details {

void Findings::add(const std::string& kind, std::uint64_t order, const std::function<std::string()>& first) {
  const std::lock_guard lock(guard_);
  Kind& known = kinds_[kind];
  if (known.count++ > 0 && known.order <= order) return;
  known.order = order;
  known.first = first();
}

std::vector<std::string> Findings::sentences() const {
  std::vector<std::string> list;
  for (const auto& [kind, known] : kinds_)
    list.push_back(known.count == 1 ? concat(kind, ": ", known.first)
                                    : concat(kind, ": ", known.first, " (", known.count, " in all)"));
  return list;
}

FieldTally::FieldTally(const FieldSummary& summary)
    : summary_(summary), inside_(summary.histogram.size()), at_edge_(summary.histogram.size() + 1) {}

void FieldTally::take_finite(double value) {
  range_.include(value);
  ++finite_count_;
  if (inside_.empty() || !summary_.range.contains(value)) return;
  const double width = summary_.range.hi / 2 - summary_.range.lo / 2;
  const double position =
      width > 0 ? (value / 2 - summary_.range.lo / 2) / width * static_cast<double>(inside_.size()) : 0;
  const double edge = std::round(position);
  constexpr double rounding = 1e-9;  // relative to the number of bins
  if (width > 0 && std::abs(position - edge) < rounding * static_cast<double>(inside_.size()))
    ++at_edge_[static_cast<std::size_t>(edge)];
  else
    ++inside_[histogram_bin(summary_.range, inside_.size(), value)];
}

void FieldTally::take(const FieldTally& other) {
  range_.include(other.range_);
  finite_count_ += other.finite_count_;
  no_data_count_ += other.no_data_count_;
  std::transform(inside_.begin(), inside_.end(), other.inside_.begin(), inside_.begin(), std::plus<>());
  std::transform(at_edge_.begin(), at_edge_.end(), other.at_edge_.begin(), at_edge_.begin(), std::plus<>());
}

void FieldTally::compare(Findings& findings) const {
  const std::string of = concat("of field '", summary_.name, "'");
  const auto say = [&](const std::string& what, std::uint64_t order, const std::string& found,
                       const std::string& told) {
    findings.add(concat(what, " ", of, " is wrong"), order,
                 [&] { return concat("the values give ", found, ", the file says ", told); });
  };
  if (range_ != summary_.range && !(range_.is_empty() && summary_.range.is_empty()))
    say("the range", 0, interval_text(range_), interval_text(summary_.range));
  if (no_data_count_ != summary_.no_data_count)
    say("the count without data", 0, concat(no_data_count_), concat(summary_.no_data_count));

  std::uint64_t total = 0;
  for (const std::uint64_t count : summary_.histogram) total += count;
  if (!inside_.empty() && total != finite_count_) say("the histogram's sum", 0, concat(finite_count_), concat(total));
  for (std::size_t bin = 0; bin < inside_.size(); ++bin) {
    const std::uint64_t at_edges = at_edge_[bin] + at_edge_[bin + 1], told = summary_.histogram[bin];
    if (told < inside_[bin] || told > inside_[bin] + at_edges)
      say("the histogram", bin, concat(inside_[bin], " to ", inside_[bin] + at_edges, " in bin ", bin), concat(told));
  }
}

std::string cell_text(int level, const Index3& cell) {
  return concat("(", cell.x, ", ", cell.y, ", ", cell.z, ") of level ", level);
}

template <class T>
void check_levels_upward(const MacroLevelsView<T>& view, const std::string& what, const CheckOptions& options,
                         Findings& findings) {
  const std::int64_t factor = view.shape.factor;
  for (int level = view.first_level; level < view.shape.level_count; ++level) {
    const Index3 below = view.shape.count(level), above = view.shape.count(level + 1);
    const auto l = static_cast<std::size_t>(level - view.first_level);
    const std::span<const T> cells = view.ranges[l], macrocells = view.ranges[l + 1];
    const auto check_layer = [&](std::uint64_t z) {
      for_each_cell(above, z, z + 1, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        Interval<T> needed;
        const Index3 low = Index3(i, j, k) * factor;
        const Index3 high(std::min(low.x + factor, below.x), std::min(low.y + factor, below.y),
                          std::min(low.z + factor, below.z));
        for (std::int64_t c = low.z; c < high.z; ++c)
          for (std::int64_t b = low.y; b < high.y; ++b)
            for (std::int64_t a = low.x; a < high.x; ++a) {
              const std::uint64_t at = 2 * linear_order(below, a, b, c);
              const Interval<T> cell{cells[at], cells[at + 1]};
              if (!cell.is_empty()) needed.include(cell);
            }
        const std::uint64_t at = 2 * linear_order(above, i, j, k);
        const Interval<T> stored{macrocells[at], macrocells[at + 1]};
        if (holds(stored, needed)) return;
        findings.add(concat(what, ": a macrocell does not match the level below"), linear_order(above, i, j, k), [&] {
          return concat(cell_text(level + 1, {i, j, k}), " has ", interval_text(stored), ", below it ",
                        interval_text(needed));
        });
      });
    };
    for_each_until_stopped(static_cast<std::uint64_t>(above.z), 4, 1, options.threads, options.watch.stop, check_layer);
  }
}

template void check_levels_upward(const MacroLevelsView<std::uint8_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::int8_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::uint16_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::int16_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::uint32_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::int32_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::uint64_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<std::int64_t>&, const std::string&, const CheckOptions&,
                                  Findings&);
template void check_levels_upward(const MacroLevelsView<float>&, const std::string&, const CheckOptions&, Findings&);
template void check_levels_upward(const MacroLevelsView<double>&, const std::string&, const CheckOptions&, Findings&);

}  // namespace rhoray::formats::details

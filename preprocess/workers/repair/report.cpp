#include "preprocess/workers/repair/report.h"

#include <charconv>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "formats/base/error.h"

namespace rhoray::preprocess::repair {

namespace {

/// Calls `act` with every number of the report, in one order for both ways.
template <class Report, class Act>
void for_each_number(Report& report, Act act) {
  act(report.merged_points);
  act(report.dropped_flat);
  act(report.dropped_twins);
  act(report.dropped_not_finite);
  act(report.split_points);
  act(report.stitched_edges);
  act(report.filled_holes);
  act(report.crossing_pairs);
  act(report.mended_parts);
  act(report.united_parts);
  act(report.dropped_parts);
  act(report.wrapped);
  act(report.moved);
  act(report.farthest_new_from_old);
  act(report.farthest_old_from_new);
  act(report.distance_error);
  act(report.box_diagonal);
}

double number_from(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size())
    throw Error(ErrorCode::internal, concat("repairing worker: found \"", text, "\"; expected a number"));
  return number;
}

}  // namespace

std::vector<std::string> arguments_of(const RepairOptions& options) {
  return {concat(options.wrap), concat(int{options.largest_part_only}), concat(options.max_move)};
}

RepairOptions options_from(std::span<const char* const> arguments) {
  if (arguments.size() != 3)
    throw Error(ErrorCode::internal, concat("repairing worker: ", arguments.size(), " arguments; expected 3"));
  RepairOptions options;
  options.wrap = number_from(arguments[0]);
  options.largest_part_only = number_from(arguments[1]) != 0;
  options.max_move = number_from(arguments[2]);
  return options;
}

std::string rounded(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

std::string text_of(const RepairReport& report) {
  std::string text;
  for_each_number(report, [&]<class T>(const T& number) { text += concat(static_cast<double>(number), " "); });
  return text;
}

RepairReport report_from(const std::string& text) {
  RepairReport report;
  std::size_t at = 0;
  for_each_number(report, [&]<class T>(T& number) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const double value = number_from(std::string_view(text).substr(at, end - at));
    if (std::is_integral_v<T> && !(value >= 0 && value <= 0x1p53))
      throw Error(ErrorCode::internal, concat("the repairing worker's report counts ", value));
    number = static_cast<T>(value);
    at = std::min(end + 1, text.size());
  });
  return report;
}

std::vector<std::string> sentences(const RepairReport& r) {
  std::vector<std::string> all;
  const auto say = [&](std::uint64_t count, std::string_view singular, std::string_view plural, std::string_view what) {
    if (count > 0) all.push_back(concat("repair: ", count_text(count, singular, plural), " ", what));
  };
  const auto say_facets = [&](std::uint64_t count, std::string_view what) { say(count, "facet", "facets", what); };
  say_facets(r.dropped_not_finite, "with a coordinate that is not a finite number dropped");
  say(r.merged_points, "point", "points", "merged with another at the same coordinates");
  say_facets(r.dropped_flat, "without area dropped");
  say_facets(r.dropped_twins, "dropped as duplicates");
  say(r.split_points, "point", "points", "doubled where more than two facets meet in an edge, or sheets in a point");
  say(r.stitched_edges, "pair", "pairs", "of open edges joined");
  say(r.filled_holes, "hole", "holes", "filled");
  say(r.dropped_parts, "part", "parts", "dropped beside the largest");
  say(r.crossing_pairs, "pair", "pairs", "of intersecting facets found");
  say(r.mended_parts, "self-intersecting part was", "self-intersecting parts were", "remeshed");
  say(r.united_parts, "closed part", "closed parts", "united with other parts");
  if (r.wrapped) all.push_back("repair: the surface was wrapped in a new one");
  const auto share = [&](double length) {
    return concat(rounded(r.box_diagonal > 0 ? 100 * length / r.box_diagonal : 0), " %");
  };
  if (r.moved > r.distance_error)
    all.push_back(concat("repair: repaired parts moved by at most ", rounded(r.moved), " (", share(r.moved),
                         " of the box diagonal), without filled holes and inner walls"));
  all.push_back(concat("repair: the new surface is at most ", rounded(r.farthest_new_from_old), " (",
                       share(r.farthest_new_from_old), " of the box diagonal) from the old one, the old one at most ",
                       rounded(r.farthest_old_from_new), " (", share(r.farthest_old_from_new),
                       ") from the new one; both to within ", rounded(r.distance_error)));
  return all;
}

}  // namespace rhoray::preprocess::repair

#include "tools/analysis/plots.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "tools/analysis/plot_script.h"

namespace rhoray::tools {

namespace {

using Point = PlotPoint;
using Series = PlotSeries;

/// Groups whose variants form a sequence: steps, sizes, counts.
bool is_series(const std::string& group) {
  return group != group_levels && group != group_published && group != group_normals;
}

/// The same in all plots.
std::size_t look_of(const std::string& group) {
  constexpr std::string_view groups[] = {group_levels,  group_published, group_linear, group_bisect,    group_bits,
                                         group_samples, group_grids,     group_vdb,    group_occlusion, group_normals,
                                         group_size,    group_shadows,   group_edges};
  return static_cast<std::size_t>(std::find(std::begin(groups), std::end(groups), group) - std::begin(groups));
}

/// Groups of a layer's rows, in the order in which they appear.
std::vector<Series> by_group(const std::vector<ResultRow>& rows,
                             const std::function<std::optional<double>(const ResultRow&)>& y) {
  std::vector<Series> all;
  for (const ResultRow& row : rows) {
    const std::optional<double> value = y(row);
    if (!value) continue;
    const std::string& group = row.measured->variant.group;
    auto found = std::find_if(all.begin(), all.end(), [&](const Series& s) { return s.name == group; });
    if (found == all.end()) found = all.insert(all.end(), {group, {}});
    found->points.push_back({row.cpu_ms, *value, row.measured->variant.name});
  }
  return all;
}

std::string scatter(const std::vector<Series>& groups) {
  std::string text;
  for (std::size_t g = 0; g < groups.size(); ++g)
    text += concat(text.empty() ? "" : ", \\\n     ", "$g", g, " using 1:2 with ",
                   is_series(groups[g].name) ? "linespoints" : "points", " pt ", point_type_of(look_of(groups[g].name)),
                   " ps 0.8 lw 1.2 lc rgb '", color_of(look_of(groups[g].name)), "' title ", in_quotes(groups[g].name));
  return text;
}

/// Position of an error on a logarithmic axis: 0 and values below rounding are at its lower end,
/// values that are not finite at the upper end.
double on_axis(double error, double least, double most) {
  return std::isfinite(error) ? std::clamp(error, least, most) : most;
}

/// The power of ten at which a logarithmic axis shows 0: well below the smallest possible number.
double place_of_zero(double smallest) {
  return std::pow(10, std::floor(std::log10(smallest)) - 1);
}

struct ErrorAxis {
  double least, most;
  std::string label;
};

ErrorAxis error_axis(const LayerStudy& layer) {
  if (!layer.is_projection()) return {1e-16, 100, "error of depth, 99 % of the pixels within, cells"};
  const Interval<double> range = layer.dataset().field().range;
  const double width = range.hi > range.lo ? range.hi - range.lo : 1;
  return {1e-16 * width, width, concat("error of the value, 99 % of the pixels within, ", error_unit(layer))};
}

Plot error_against_time(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  const ErrorAxis axis = error_axis(layer);
  const std::vector<Series> groups = by_group(rows, [&](const ResultRow& row) -> std::optional<double> {
    if (!row.kept) return std::nullopt;
    return on_axis(*row.kept, axis.least, axis.most);
  });
  std::vector<Point> front;
  for (const ResultRow& row : rows)
    if (row.is_on_front)
      front.push_back({row.cpu_ms, on_axis(*row.kept, axis.least, axis.most), row.measured->variant.name});
  std::sort(front.begin(), front.end(), [](const Point& p, const Point& q) { return p.x < q.x; });
  // Neighbours on the front are labelled above and below it in turn.
  std::vector<Point> above, below;
  for (std::size_t i = 0; i < front.size(); ++i) (i % 2 == 0 ? above : below).push_back(front[i]);
  const char* const named = " using 1:2:3 notitle with labels left noenhanced font ',12' offset 0.8,";
  std::string script = preamble("CPU time of a picture, ms", axis.label) + blocks(groups) + data_block("front", front) +
                       data_block("above", above) + data_block("below", below) +
                       concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", axis.least / 30, ":",
                              axis.most * 3, "]\nset offsets graph 0.02, graph 0.12, 0, 0\nplot ",
                              "$front using 1:2 with steps lw 2 lc rgb '#bbbbbb' title 'Pareto front', \\\n     ",
                              scatter(groups), ", \\\n     $above", named, "0.7",
                              below.empty() ? std::string() : concat(", \\\n     $below", named, "-0.8"), "\n");
  return {"error_time", "Error against time",
          "Down and to the left is better. The error is the bound that 99 % of the pixels keep, among those that show "
          "or should show something. The grey line joins the variants that no other beats in both time and error; "
          "these are named. Thin lines join variants of a kind. Points at the upper edge have more than 1 % false "
          "negatives or false positives; points at the lower edge have no error beyond rounding.",
          std::move(script)};
}

/// Nothing if no pixel is wrong.
std::optional<Plot> wrong_against_time(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  const auto is_wrong = [](const ResultRow& row) {
    return row.kept && row.measured->errors->missed + row.measured->errors->false_hits > 0;
  };
  if (std::none_of(rows.begin(), rows.end(), is_wrong)) return std::nullopt;
  const std::uint64_t rays = layer.result()->truth.pixels.size();
  const double least = place_of_zero(1e6 / static_cast<double>(rays));
  const std::vector<Series> groups = by_group(rows, [&](const ResultRow& row) -> std::optional<double> {
    if (!row.kept) return std::nullopt;
    const render::ErrorCounts& errors = *row.measured->errors;
    return std::max(least,
                    1e6 * static_cast<double>(errors.missed + errors.false_hits) / static_cast<double>(errors.rays));
  });
  return Plot{
      "wrong_time", "Wrong pixels against time",
      concat("False negatives and false positives per million pixels. Points at 0 have none among the ", grouped(rays),
             " pixels that were compared, or among fewer pixels for methods that were too slow."),
      preamble("CPU time of a picture, ms", "false negatives and false positives per million pixels") + blocks(groups) +
          concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", least / 2, ":*]\nset ytics add ('0' ", least,
                 ")\nplot ", scatter(groups), "\n")};
}

Plot flip_against_time(const std::vector<ResultRow>& rows) {
  double smallest = 1e-3;
  for (const ResultRow& row : rows)
    if (const auto& picture = row.measured->picture_errors; picture && picture->flip > 0)
      smallest = std::min(smallest, picture->flip);
  const double least = place_of_zero(smallest);
  const std::vector<Series> groups = by_group(rows, [&](const ResultRow& row) -> std::optional<double> {
    if (!row.measured->picture_errors) return std::nullopt;
    return std::max(least, row.measured->picture_errors->flip);
  });
  return {"flip_time", "Visible difference against time",
          "Mean FLIP of the picture against the reference, 0 to 1: the visible difference for a viewer who alternates "
          "between them on a screen of 67 pixels per degree. Points at 0 are the same picture.",
          preamble("CPU time of a picture, ms", "mean FLIP") + blocks(groups) +
              concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", least / 2, ":1]\nset ytics add ('0' ",
                     least, ")\nplot ", scatter(groups), "\n")};
}

/// Memory that copies of the data save, or cost. Nothing if none was rendered.
std::optional<Plot> error_against_memory(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  const ErrorAxis axis = error_axis(layer);
  std::vector<Series> groups;
  std::vector<Point> names;
  for (const ResultRow& row : rows) {
    const Variant& variant = row.measured->variant;
    const bool is_copy = variant.data.kind != DataForm::Kind::original;
    const std::optional<render::ErrorCounts>& errors = row.measured->errors;
    if (!errors || !errors->error || row.measured->memory_bytes == 0 || !(is_copy || variant.group == group_levels))
      continue;
    const Point point{static_cast<double>(row.measured->memory_bytes) / (1 << 20),
                      on_axis(errors->error->median, axis.least, axis.most), variant.name};
    if (groups.empty() || groups.back().name != variant.group) groups.push_back({variant.group, {}});
    groups.back().points.push_back(point);
    if (variant.group == group_bits || variant.group == group_grids) names.push_back(point);
  }
  if (names.empty()) return std::nullopt;
  return Plot{"error_memory", "Error against memory",
              "Median error of the pixels that both hit, against the memory that is mapped and kept for drawing: the "
              "original data with Rhoray's levels, and copies with the default level of each. Copies are compared with "
              "the original data.",
              preamble("memory, MiB", concat("median error, ", error_unit(layer))) + blocks(groups) +
                  data_block("names", names) +
                  concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", axis.least / 30, ":", axis.most * 3,
                         "]\nset offsets graph 0.05, graph 0.15, 0, 0\nplot ", scatter(groups),
                         ", \\\n     $names using 1:2:3 notitle with labels left noenhanced font ',12' offset "
                         "0.8,0.7\n")};
}

/// Nothing if no steps were measured.
std::optional<Plot> convergence(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  std::vector<Series> groups;
  for (const char* group : {group_linear, group_bisect, group_samples}) {
    Series series{group, {}};
    for (const ResultRow& row : rows)
      if (row.measured->variant.group == group && row.measured->errors->error)
        if (const double error = row.measured->errors->error->median; error > 0)
          series.points.push_back({row.measured->variant.method->step, error, {}});
    if (series.points.size() > 1) groups.push_back(std::move(series));
  }
  if (groups.empty()) return std::nullopt;
  double anchor = 0;  // of the guides: above the first curve at a step of one cell
  for (const Point& point : groups[0].points) anchor = std::max(anchor, 2 * point.y);
  std::string guides;
  for (const int order : {1, 2})
    guides += concat(", \\\n     ", anchor, "*(x/2.0)**", order, " with lines dt 2 lc rgb '#999999' title 'order ",
                     order, "'");
  return Plot{"convergence", "Convergence of samples",
              "Median error of the pixels that both hit, against the step of the samples along the ray. Dashed: errors "
              "proportional to the step and to its square. Bisection halves a step a fixed number of times, so its "
              "error is proportional to the step.",
              preamble("step of the samples, cells", concat("median error, ", error_unit(layer))) + blocks(groups) +
                  concat("set logscale x 2\nset logscale y\nset format y '10^{%L}'\nset xrange [0.0125:2.5]\n"
                         "set xtics ('1/64' 0.015625, '1/32' 0.03125, '1/16' 0.0625, '1/8' 0.125, '1/4' 0.25, "
                         "'1/2' 0.5, '1' 1, '2' 2)\nplot ",
                         scatter(groups), guides, "\n")};
}

/// For the levels and the rows shown as pictures.
Plot distribution(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  const ErrorAxis axis = error_axis(layer);
  std::vector<Series> lines;
  for (const ResultRow& row : rows) {
    const Measured& measured = *row.measured;
    const bool is_shown = measured.variant.has_picture || measured.variant.group == group_levels;
    if (!measured.errors || !is_shown || measured.method == "exact") continue;
    const render::ErrorCounts& errors = *measured.errors;
    const double seen = static_cast<double>(errors.true_hits + errors.false_hits);
    if (errors.sorted.empty()) continue;
    Series line{measured.variant.name, {}};
    constexpr std::size_t steps = 200;
    const std::size_t count = errors.sorted.size();
    for (std::size_t i = 0; i <= steps; ++i) {
      const std::size_t at = std::min(count - 1, i * count / steps);
      line.points.push_back({on_axis(static_cast<double>(errors.sorted[at]), axis.least, axis.most),
                             100 * static_cast<double>(at + 1) / seen,
                             {}});
    }
    lines.push_back(std::move(line));
  }
  std::string plots;
  for (std::size_t l = 0; l < lines.size(); ++l)
    plots += concat(l == 0 ? "" : ", \\\n     ", "$g", l, " using 1:2 with lines lw ",
                    l % 2 == 0 ? "3.5" : "2 dt (12,8)", " lc rgb '", color_of(l), "' title ", in_quotes(lines[l].name));
  return {
      "distribution", "Distribution of errors",
      "Share of the pixels within an error, among those that show or should show something. A line that ends below 100 "
      "% has false negatives or false positives. Every other line is dashed, so that a covered line stays visible.",
      preamble(concat(layer.is_projection() ? "error of the value, " : "error of depth, ", error_unit(layer)),
               "pixels within it, %") +
          blocks(lines) +
          concat("set logscale x\nset format x '10^{%L}'\nset xrange [", axis.least, ":", axis.most,
                 "]\nset yrange [0:101]\nplot ", plots, "\n")};
}

}  // namespace

std::vector<Plot> plots_of(const LayerStudy& layer) {
  const std::vector<ResultRow> rows = rows_of(*layer.result());
  if (rows.size() < 2) return {};
  std::vector<Plot> plots{error_against_time(layer, rows)};
  if (const auto plot = wrong_against_time(layer, rows)) plots.push_back(*plot);
  if (const auto plot = convergence(layer, rows)) plots.push_back(*plot);
  plots.push_back(distribution(layer, rows));
  plots.push_back(flip_against_time(rows));
  if (const auto plot = error_against_memory(layer, rows)) plots.push_back(*plot);
  return plots;
}

}  // namespace rhoray::tools

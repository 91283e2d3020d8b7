#include "tools/rhoray/accuracy/plots.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "formats/base/text.h"
#include "tools/rhoray/accuracy/plot_script.h"

namespace rhoray::tools {

namespace {

using Point = PlotPoint;
using Series = PlotSeries;

/// The same in all plots.
std::size_t look_of(const std::string& group) {
  constexpr std::string_view groups[] = {group_levels,    group_published, group_linear, group_bisect,
                                         group_bits,      group_samples,   group_grids,  group_vdb,
                                         group_occlusion, group_normals,   group_size};
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

std::string scatter(const std::vector<Series>& groups, bool has_lines) {
  std::string text;
  for (std::size_t g = 0; g < groups.size(); ++g)
    text += concat(text.empty() ? "" : ", \\\n     ", "$g", g, " using 1:2 with ", has_lines ? "linespoints" : "points",
                   " pt ", point_type_of(look_of(groups[g].name)), " ps 0.8 lw 1.4 lc rgb '",
                   color_of(look_of(groups[g].name)), "' title ", in_quotes(groups[g].name));
  return text;
}

/// An error on a logarithmic axis: 0 and what is below rounding lie at its end, what is not finite at the other.
double on_axis(double error, double least, double most) {
  return std::isfinite(error) ? std::clamp(error, least, most) : most;
}

struct ErrorAxis {
  double least, most;
  std::string label;
};

ErrorAxis error_axis(const LayerStudy& layer) {
  if (layer.scene().layers[0].mode != render::Mode::mip)
    return {1e-16, 100, "error that 99 % of the pixels keep, cells"};
  const Interval<double> range = layer.volume().field().range;
  const double width = range.hi > range.lo ? range.hi - range.lo : 1;
  return {1e-16 * width, width, concat("error that 99 % of the pixels keep, ", error_unit(layer))};
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
  // Neighbours on the front are named above and below it in turn.
  std::vector<Point> above, below;
  for (std::size_t i = 0; i < front.size(); ++i) (i % 2 == 0 ? above : below).push_back(front[i]);
  const char* const named = " using 1:2:3 notitle with labels left noenhanced font ',12' offset 0.8,";
  std::string script = preamble("CPU time of a picture, ms", axis.label) + blocks(groups) + data_block("front", front) +
                       data_block("above", above) + data_block("below", below) +
                       concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", axis.least / 3, ":",
                              axis.most * 3, "]\nset offsets graph 0.02, graph 0.12, 0, 0\nplot ",
                              "$front using 1:2 with steps lw 2 lc rgb '#bbbbbb' title 'Pareto front', \\\n     ",
                              scatter(groups, false), ", \\\n     $above", named, "0.7",
                              below.empty() ? std::string() : concat(", \\\n     $below", named, "-0.8"), "\n");
  return {"error_time", "Error against time",
          "Down and to the left is better. The grey line joins the variants that no other beats in both; these are "
          "named. Points at the upper edge miss or invent more than 1 % of the pixels; points at the lower edge are "
          "exact to rounding.",
          std::move(script)};
}

Plot wrong_against_time(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  const std::uint64_t rays = layer.result()->truth.pixels.size();
  const double least = 0.3e6 / static_cast<double>(rays);
  const std::vector<Series> groups = by_group(rows, [&](const ResultRow& row) -> std::optional<double> {
    if (!row.kept) return std::nullopt;
    const ErrorCounts& errors = *row.measured->errors;
    return std::max(least, 1e6 * static_cast<double>(errors.missed + errors.false_hits) / static_cast<double>(rays));
  });
  return {"wrong_time", "Wrong pixels against time",
          concat("Missed and false pixels of a million. Points at the lower edge have none among the ", rays,
                 " that were judged."),
          preamble("CPU time of a picture, ms", "missed and false pixels of a million") + blocks(groups) +
              concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", least / 2, ":*]\nset ytics add ('0' ",
                     least, ")\nplot ", scatter(groups, false), "\n")};
}

Plot flip_against_time(const std::vector<ResultRow>& rows) {
  constexpr double least = 1e-7;
  const std::vector<Series> groups = by_group(rows, [&](const ResultRow& row) -> std::optional<double> {
    if (!row.measured->picture_errors) return std::nullopt;
    return std::max(least, row.measured->picture_errors->flip);
  });
  return {"flip_time", "Seen difference against time",
          "Mean FLIP of the picture against the true one: 0 is the same to the eye, and pictures whose mean is below "
          "about 0.01 are hard to tell apart. Points at the lower edge do not differ.",
          preamble("CPU time of a picture, ms", "mean FLIP") + blocks(groups) +
              concat("set logscale xy\nset format y '10^{%L}'\nset yrange [", least / 2, ":1]\nset ytics add ('0' ",
                     least, ")\nplot ", scatter(groups, false), "\n")};
}

/// Nothing where no steps were measured.
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
  return Plot{
      "convergence", "Convergence of samples",
      "Median error of pixels that both see, against the distance of samples along the ray. Dashed: errors that "
      "fall with the step and with its square. Bisection halves a step a fixed number of times, so its error "
      "falls with the step.",
      preamble("distance of samples, cells", concat("median error, ", error_unit(layer))) + blocks(groups) +
          concat("set logscale x 2\nset logscale y\nset format y '10^{%L}'\nset xrange [0.0125:2.5]\n"
                 "set xtics ('1/64' 0.015625, '1/32' 0.03125, '1/16' 0.0625, '1/8' 0.125, '1/4' 0.25, "
                 "'1/2' 0.5, '1' 1, '2' 2)\nplot ",
                 scatter(groups, true), guides, "\n")};
}

/// Of the levels and of what is shown as pictures.
Plot distribution(const LayerStudy& layer, const std::vector<ResultRow>& rows) {
  const ErrorAxis axis = error_axis(layer);
  std::vector<Series> lines;
  for (const ResultRow& row : rows) {
    const Measured& measured = *row.measured;
    const bool is_shown = measured.variant.has_picture || measured.variant.group == group_levels;
    if (!measured.errors || !is_shown || measured.method == "exact") continue;
    const ErrorCounts& errors = *measured.errors;
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
    plots += concat(l == 0 ? "" : ", \\\n     ", "$g", l, " using 1:2 with lines lw 2 lc rgb '", color_of(l),
                    "' title ", in_quotes(lines[l].name));
  return {
      "distribution", "How errors are distributed",
      "Which share of the pixels, of those that show or should show something, keeps an error. A line that ends "
      "below 100 % misses or invents the rest.",
      preamble(concat(layer.scene().layers[0].mode == render::Mode::mip ? "error of the value, " : "error of depth, ",
                      error_unit(layer)),
               "pixels that keep it, %") +
          blocks(lines) +
          concat("set logscale x\nset format x '10^{%L}'\nset xrange [", axis.least, ":", axis.most,
                 "]\nset yrange [0:101]\nplot ", plots, "\n")};
}

}  // namespace

std::vector<Plot> plots_of(const LayerStudy& layer) {
  const std::vector<ResultRow> rows = rows_of(*layer.result());
  if (rows.size() < 2) return {};
  std::vector<Plot> plots{error_against_time(layer, rows), wrong_against_time(layer, rows)};
  if (const auto plot = convergence(layer, rows)) plots.push_back(*plot);
  plots.push_back(distribution(layer, rows));
  plots.push_back(flip_against_time(rows));
  return plots;
}

}  // namespace rhoray::tools

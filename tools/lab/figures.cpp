#include "tools/lab/figures.h"

#include <algorithm>
#include <cmath>

#include "formats/base/interval.h"
#include "formats/base/pending_file.h"
#include "formats/base/text.h"
#include "tools/analysis/gnuplot.h"

namespace rhoray::study {

namespace {

/// The position of a value on the axis; not finite if the value is not drawn.
double on_axis(const Axis& axis, double value) {
  if (!axis.is_logarithmic || value > axis.least) return value;
  return axis.least > 0 ? axis.least : std::nan("");
}

std::vector<tools::PlotSeries> series_of(const Figure& figure) {
  std::vector<tools::PlotSeries> all;
  for (const Curve& curve : figure.curves) {
    tools::PlotSeries series{curve.name, {}};
    for (const tools::PlotPoint& point : curve.points) {
      const double x = on_axis(figure.x, point.x), y = on_axis(figure.y, point.y);
      if (std::isfinite(x) && std::isfinite(y)) series.points.push_back({x, y, point.label});
    }
    all.push_back(std::move(series));
  }
  return all;
}

/// @param drawn  range of the points' values
std::string axis_lines(const char* letter, const Axis& axis, const Interval<double>& drawn) {
  if (!axis.is_logarithmic) return {};
  // gnuplot would extend the range to whole powers of ten.
  return concat("set logscale ", letter, "\nset format ", letter, " '10^{%L}'\nset ", letter, "range [", drawn.lo / 1.5,
                ":", drawn.hi * 2, "]\n",
                axis.least > 0 ? concat("set ", letter, "tics add ('0' ", axis.least, ")\n") : "");
}

}  // namespace

std::string script_of(const Figure& figure) {
  const std::vector<tools::PlotSeries> all = series_of(figure);
  Interval<double> x, y;
  for (const tools::PlotSeries& series : all)
    for (const tools::PlotPoint& point : series.points) x.include(point.x), y.include(point.y);
  std::string plots;
  for (std::size_t s = 0; s < all.size(); ++s) {
    if (all[s].points.empty()) continue;
    const bool has_labels = std::any_of(all[s].points.begin(), all[s].points.end(),
                                        [](const tools::PlotPoint& point) { return !point.label.empty(); });
    plots += concat(plots.empty() ? "" : ", \\\n     ", "$g", s, " using 1:2 with linespoints pt ",
                    tools::point_type_of(s), " ps 0.8 lw 1.6 ", figure.curves[s].is_dashed ? "dt 2 " : "", "lc rgb '",
                    tools::color_of(s), "' title ", tools::in_quotes(all[s].name));
    if (has_labels)
      plots += concat(", \\\n     $g", s, " using 1:2:3 notitle with labels left noenhanced font ',11' offset 0.8,0.6");
  }
  return tools::preamble(figure.x.label, figure.y.label) + tools::blocks(all) + axis_lines("x", figure.x, x) +
         axis_lines("y", figure.y, y) +
         "set key below left maxcols 2\nset offsets graph 0.02, graph 0.02, 0, 0\nplot " + plots + "\n";
}

void publish(const std::vector<Figure>& figures, const tools::CommonOptions& common) {
  if (common.output.empty()) return;
  if (!tools::has_gnuplot()) {
    tools::say(common, concat("note: no figures are drawn: gnuplot is missing (package ", tools::gnuplot_package, ")"));
    return;
  }
  for (const Figure& figure : figures) {
    const std::vector<tools::PlotSeries> all = series_of(figure);
    if (std::all_of(all.begin(), all.end(), [](const tools::PlotSeries& series) { return series.points.empty(); }))
      continue;
    write_whole_file(common.output / (figure.name + ".svg"), tools::drawn_by_gnuplot(script_of(figure)), common.force);
  }
}

void require_publishable_figures(const tools::CommonOptions& common, const std::vector<std::string>& names) {
  if (common.output.empty()) return;
  for (const std::string& name : names) tools::require_writable(common, common.output / (name + ".svg"), {});
}

}  // namespace rhoray::study

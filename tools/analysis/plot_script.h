#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace rhoray::tools {

// Building blocks of gnuplot scripts, so that the plots of all commands look alike.

struct PlotPoint {
  double x = 0, y = 0;
  std::string label;
};

/// Named points.
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};

const char* color_of(std::size_t i);  ///< distinguishable with any colour vision
int point_type_of(std::size_t i);     ///< gnuplot's number

std::string in_quotes(const std::string& text);  ///< quoted for a script

/// The points as the block $NAME: x, y, label.
std::string data_block(const std::string& name, const std::vector<PlotPoint>& points);
/// One block for each series: $g0, $g1, ...
std::string blocks(const std::vector<PlotSeries>& series);

/// Size, frame and axis labels of an SVG plot.
std::string preamble(const std::string& x, const std::string& y);

}  // namespace rhoray::tools

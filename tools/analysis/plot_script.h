#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace rhoray::tools {

// What scripts for gnuplot are made of, so that plots of all commands look alike.

struct PlotPoint {
  double x = 0, y = 0;
  std::string label;
};

/// Points under one name.
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};

const char* color_of(std::size_t i);  ///< told apart with any colour vision
int point_type_of(std::size_t i);     ///< gnuplot's number

std::string in_quotes(const std::string& text);  ///< as a script holds it

/// The points as the block $NAME: x, y, label.
std::string data_block(const std::string& name, const std::vector<PlotPoint>& points);
/// A block for each: $g0, $g1, ...
std::string blocks(const std::vector<PlotSeries>& series);

/// Size, frame and names of the axes of a plot as SVG.
std::string preamble(const std::string& x, const std::string& y);

}  // namespace rhoray::tools

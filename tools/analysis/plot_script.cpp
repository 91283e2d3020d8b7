#include "tools/analysis/plot_script.h"

#include <algorithm>
#include <iterator>

#include "formats/base/text.h"

namespace rhoray::tools {

const char* color_of(std::size_t i) {
  // Paul Tol's scheme "bright" (technical note SRON/EPS/TN/09-002).
  constexpr const char* colors[] = {"#4477aa", "#ee6677", "#228833", "#ccbb44",
                                    "#66ccee", "#aa3377", "#888888", "#000000"};
  return colors[i % std::size(colors)];
}

int point_type_of(std::size_t i) {
  // The number of types has no common factor with the number of colours.
  constexpr int types[] = {7, 5, 9, 11, 13, 15, 4};
  return types[i % std::size(types)];
}

std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char letter : text) out += letter == '\'' ? std::string("''") : std::string(1, letter);
  return out + "'";
}

std::string data_block(const std::string& name, const std::vector<PlotPoint>& points) {
  std::string text = concat("$", name, " << EOD\n");
  for (const PlotPoint& point : points) {
    std::string label = point.label;
    std::replace(label.begin(), label.end(), '"', '\'');
    text += concat(point.x, " ", point.y, " \"", label, "\"\n");
  }
  return text + "EOD\n";
}

std::string blocks(const std::vector<PlotSeries>& series) {
  std::string text;
  for (std::size_t s = 0; s < series.size(); ++s) text += data_block(concat("g", s), series[s].points);
  return text;
}

std::string preamble(const std::string& x, const std::string& y) {
  return concat(
      "set terminal svg size 960,560 dynamic font 'Helvetica,15' background '#ffffff'\n"
      "set border 3 lc rgb '#444444'\nset tics nomirror\nset grid lc rgb '#dddddd' lt 1 lw 0.7\n"
      "set key outside right top Left reverse noenhanced samplen 1.5 spacing 1.2\nset xlabel ",
      in_quotes(x), " noenhanced\nset ylabel ", in_quotes(y), " noenhanced\n");
}

}  // namespace rhoray::tools

#pragma once

#include <string>
#include <vector>

#include "tools/analysis/plot_script.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::study {

/// An axis of a figure.
struct Axis {
  std::string label;
  bool is_logarithmic = true;
  /// For a logarithmic axis: values at or below this are drawn here, labelled "0". 0: such points
  /// are left out.
  double least = 0;
};

/// A curve; its points are joined in their order.
struct Curve {
  std::string name;
  std::vector<tools::PlotPoint> points;  ///< a label is written beside its point
  bool is_dashed = false;
};

/// A figure of a study: one SVG, drawn by gnuplot.
struct Figure {
  std::string name;  ///< file name without the extension
  Axis x, y;
  std::vector<Curve> curves;
};

std::string script_of(const Figure& figure);

/// Writes NAME.svg for each figure into the output folder, if one is given. Without gnuplot, prints
/// to stderr which package contains it. Leaves out figures without a point.
void publish(const std::vector<Figure>& figures, const tools::CommonOptions& common);

/// Refuses, before the work, an output folder in which these figures could not be published after
/// it (ErrorCode::usage).
void require_publishable_figures(const tools::CommonOptions& common, const std::vector<std::string>& names);

}  // namespace rhoray::study

#pragma once

#include <string>
#include <vector>

#include "tools/analysis/plot_script.h"
#include "tools/rhoray/common_options.h"

namespace rhoray::study {

/// An axis of a figure.
struct Axis {
  std::string label;
  bool is_logarithmic = true;
  /// Of a logarithmic axis: where values at or below it are drawn, labelled "0"; 0: such points are left out.
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
  std::string name;  ///< of its file, without the extension
  Axis x, y;
  std::vector<Curve> curves;
};

std::string script_of(const Figure& figure);

/// Writes NAME.svg for each into the output folder, if one is given; without gnuplot says on stderr which package has
/// it. Figures without a point are left out.
void publish(const std::vector<Figure>& figures, const tools::CommonOptions& common);

/// Refuses, before the work, an output folder in which these figures could not be published after it
/// (ErrorCode::usage).
void require_publishable_figures(const tools::CommonOptions& common, const std::vector<std::string>& names);

}  // namespace rhoray::study

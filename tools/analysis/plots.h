#pragma once

#include <string>
#include <vector>

#include "tools/analysis/results.h"

namespace rhoray::tools {

/// A plot as a script for gnuplot, with its data.
struct Plot {
  std::string name;  ///< of its file, without the extension
  std::string title;
  std::string caption;  ///< what it shows, sentences
  std::string script;
};

/// What can be drawn of a layer's results.
std::vector<Plot> plots_of(const LayerStudy& layer);

}  // namespace rhoray::tools

#pragma once

#include <string>
#include <vector>

#include "tools/analysis/results.h"

namespace rhoray::tools {

/// A gnuplot script with its data.
struct Plot {
  std::string name;  ///< file name without extension
  std::string title;
  std::string caption;  ///< what it shows, in sentences
  std::string script;
};

/// Returns the plots that a layer's results allow.
std::vector<Plot> plots_of(const LayerStudy& layer);

}  // namespace rhoray::tools

#pragma once

#include <string>

namespace rhoray::tools {

inline constexpr const char* gnuplot_package = "gnuplot-nox";  ///< Debian's

bool has_gnuplot();  ///< in PATH

/// Runs a script that plots to its output, and returns the SVG. Refuses with what gnuplot says
/// (ErrorCode::unsupported). Touches no disk.
std::string drawn_by_gnuplot(const std::string& script);

/// The SVG as it may stand in an HTML page: without prolog and without names of other documents.
std::string inline_svg(const std::string& svg);

}  // namespace rhoray::tools

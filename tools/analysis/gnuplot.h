#pragma once

#include <string>

namespace rhoray::tools {

inline constexpr const char* gnuplot_package = "gnuplot-nox";  ///< Debian package

bool has_gnuplot();  ///< found in PATH

/// Runs a script that plots to its output, and returns the SVG. Fails with gnuplot's message
/// (ErrorCode::unsupported). Writes nothing to disk.
std::string drawn_by_gnuplot(const std::string& script);

/// The SVG in a form that can be embedded in HTML: without prolog and without names of other
/// documents.
std::string inline_svg(const std::string& svg);

}  // namespace rhoray::tools

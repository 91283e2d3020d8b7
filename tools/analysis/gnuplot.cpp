#include "tools/analysis/gnuplot.h"

#include <unistd.h>

#include <cstdlib>
#include <regex>
#include <string_view>
#include <system_error>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "tools/analysis/run_program.h"
#include "tools/pictures/memory_file.h"

namespace rhoray::tools {

namespace {

ProgramRun run_gnuplot(const std::string& script) {
  const MemoryFile text(script);
  constexpr int script_descriptor = 3;
  return run_program({.words = {"gnuplot", concat("/dev/fd/", script_descriptor)},
                      .inherited = {{text.descriptor(), script_descriptor}}});
}

}  // namespace

bool has_gnuplot() {
  const char* const path = std::getenv("PATH");
  std::string folders = path == nullptr ? "" : path;
  for (std::size_t at = 0; at <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', at), folders.size());
    if (end > at && ::access((folders.substr(at, end - at) + "/gnuplot").c_str(), X_OK) == 0) return true;
    at = end + 1;
  }
  return false;
}

std::string drawn_by_gnuplot(const std::string& script) try {
  ProgramRun run = run_gnuplot(script);
  if (run.status != 0 || run.out.find("</svg>") == std::string::npos) {
    for (char& letter : run.err)
      if (letter == '\n') letter = ' ';
    throw Error(ErrorCode::unsupported, concat("gnuplot ended with ", run.status, ": ", run.err));
  }
  return run.out;
} catch (const std::system_error& error) {
  throw Error(ErrorCode::resource, concat("plots: ", error.what()));
}

std::string inline_svg(const std::string& svg) {
  const std::size_t begin = svg.find("<svg");
  std::string text = begin == std::string::npos ? svg : svg.substr(begin);
  static const std::regex names("\\s+xmlns(:\\w+)?=\"[^\"]*\"");
  return std::regex_replace(text, names, "");
}

}  // namespace rhoray::tools

#include "tools/rhoray/accuracy/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>

#include "formats/base/trouble.h"

namespace rhoray::tools {

namespace {

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Its exit status; 127 where it does not start.
int run_gnuplot(const std::filesystem::path& script, const std::filesystem::path& out,
                const std::filesystem::path& err) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  constexpr int flags = O_CREAT | O_WRONLY | O_TRUNC;
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), flags, 0600);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), flags, 0600);
  // Of a process group of its own: an interrupt from the terminal ends the study, not the plot that is being drawn.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string program = "gnuplot", argument = script.string();
  char* const words[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int trouble = ::posix_spawnp(&child, "gnuplot", &actions, &attributes, words, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (trouble != 0) return 127;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
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

std::string drawn_by_gnuplot(const std::string& script, const std::filesystem::path& folder) {
  const std::filesystem::path text = folder / "plot.gnuplot", out = folder / "plot.svg", err = folder / "plot.err";
  std::ofstream(text, std::ios::binary) << script;
  const int status = run_gnuplot(text, out, err);
  std::string svg = content_of(out);
  if (status != 0 || svg.find("</svg>") == std::string::npos) {
    std::string said = content_of(err);
    for (char& letter : said)
      if (letter == '\n') letter = ' ';
    throw Error(Trouble::unsupported, concat("gnuplot ended with ", status, ": ", said));
  }
  return svg;
}

std::string inline_svg(const std::string& svg) {
  const std::size_t begin = svg.find("<svg");
  std::string text = begin == std::string::npos ? svg : svg.substr(begin);
  static const std::regex names("\\s+xmlns(:\\w+)?=\"[^\"]*\"");
  return std::regex_replace(text, names, "");
}

}  // namespace rhoray::tools

#include "tools/analysis/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <regex>
#include <string_view>
#include <system_error>

#include "formats/base/error.h"
#include "tools/pictures/memory_file.h"

namespace rhoray::tools {

namespace {

std::string text_in(const MemoryFile& file) {
  const std::vector<std::byte> bytes = file.bytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct GnuplotRun {
  int status = 127;  ///< 127: not started
  std::string out, err;
};

GnuplotRun run_gnuplot(const std::string& script) {
  const MemoryFile text(script), out, err;
  constexpr int script_descriptor = 3;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, text.descriptor(), script_descriptor);
  // It has its own process group: an interrupt from the terminal ends the study, not the plot being
  // drawn.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string program = "gnuplot", argument = concat("/dev/fd/", script_descriptor);
  char* const words[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int error_code = ::posix_spawnp(&child, "gnuplot", &actions, &attributes, words, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error_code != 0) return {};
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return {.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          .out = text_in(out),
          .err = text_in(err)};
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
  GnuplotRun run = run_gnuplot(script);
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

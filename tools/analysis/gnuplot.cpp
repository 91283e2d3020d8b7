#include "tools/analysis/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <regex>
#include <string_view>
#include <utility>

#include "formats/base/error.h"

namespace rhoray::tools {

namespace {

[[noreturn]] void refuse(const char* call) {
  throw Error(ErrorCode::resource, concat("plots: ", call, ": ", std::strerror(errno)));
}

/// A file descriptor that is closed at the end of its scope.
class Descriptor {
 public:
  Descriptor(int number, const char* call) : number_(number) {
    if (number_ < 0) refuse(call);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() { close(); }

  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

/// A file in memory with this text.
Descriptor memory_file(std::string_view text) {
  Descriptor file(::memfd_create("rhoray-plot", MFD_CLOEXEC), "memfd_create");
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t put = ::pwrite(file.number(), text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) refuse("pwrite");
    done += static_cast<std::size_t>(put);
  }
  return file;
}

/// Reads to the end.
std::string content_of(int descriptor) {
  std::string text;
  char piece[4096];
  for (;;) {
    const ssize_t count = ::read(descriptor, piece, sizeof piece);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse("read");
    if (count == 0) return text;
    text.append(piece, static_cast<std::size_t>(count));
  }
}

struct GnuplotRun {
  int status = 127;  ///< 127: not started
  std::string out, err;
};

GnuplotRun run_gnuplot(const std::string& script) {
  const Descriptor text = memory_file(script), err = memory_file({});
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) refuse("pipe2");
  const Descriptor hear(ends[0], "pipe2");
  Descriptor speak(ends[1], "pipe2");

  constexpr int script_descriptor = 3;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, speak.number(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err.number(), STDERR_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, text.number(), script_descriptor);
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
  GnuplotRun run;
  if (error_code != 0) return run;
  speak.close();
  run.out = content_of(hear.number());
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (::lseek(err.number(), 0, SEEK_SET) < 0) refuse("lseek");
  run.err = content_of(err.number());
  return run;
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

std::string drawn_by_gnuplot(const std::string& script) {
  GnuplotRun run = run_gnuplot(script);
  if (run.status != 0 || run.out.find("</svg>") == std::string::npos) {
    for (char& letter : run.err)
      if (letter == '\n') letter = ' ';
    throw Error(ErrorCode::unsupported, concat("gnuplot ended with ", run.status, ": ", run.err));
  }
  return run.out;
}

std::string inline_svg(const std::string& svg) {
  const std::size_t begin = svg.find("<svg");
  std::string text = begin == std::string::npos ? svg : svg.substr(begin);
  static const std::regex names("\\s+xmlns(:\\w+)?=\"[^\"]*\"");
  return std::regex_replace(text, names, "");
}

}  // namespace rhoray::tools

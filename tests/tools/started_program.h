#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/text.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// `rhoray` with these words, running in this folder while the test goes on. If the first word is a
/// full path, runs that program of the build instead. Keeps its output on stderr.
class StartedProgram {
 public:
  struct Streams {
    int out = -1;                   ///< descriptor that becomes standard output; -1: /dev/null
    int in = -1;                    ///< the same for standard input
    std::vector<int> ignored = {};  ///< signals that are ignored from the start, as under nohup
  };

  StartedProgram(const std::filesystem::path& folder, std::vector<std::string> words, const Streams& streams) {
    if (!words.front().starts_with('/')) words.insert(words.begin(), RHORAY_PROGRAM);
    const std::string said = (said_ / "err").string();
    process_ = ::fork();
    if (process_ != 0) return;
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    for (const int signal : streams.ignored) ::signal(signal, SIG_IGN);
    const int nothing = ::open("/dev/null", O_RDWR);
    const bool ready = ::dup2(streams.in < 0 ? nothing : streams.in, 0) >= 0 &&
                       ::dup2(streams.out < 0 ? nothing : streams.out, 1) >= 0 &&
                       ::dup2(::open(said.c_str(), O_CREAT | O_WRONLY, 0600), 2) >= 0 && ::chdir(folder.c_str()) == 0;
    if (ready) ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  StartedProgram(const std::filesystem::path& folder, std::vector<std::string> words)
      : StartedProgram(folder, std::move(words), Streams{}) {}
  StartedProgram(const StartedProgram&) = delete;
  StartedProgram& operator=(const StartedProgram&) = delete;
  ~StartedProgram() {
    send(SIGKILL);
    wait();
  }

  /// Waits until the program maps a file of this name. Returns false if the program ended before.
  bool maps(const std::string& name) {
    const std::string maps = concat("/proc/", process_, "/maps");
    while (!has_ended()) {
      if (read_file(maps).find("/" + name + "\n") != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }

  void send(int signal) {
    if (!has_ended()) ::kill(process_, signal);
  }

  /// Returns the exit code, or 128 + signal.
  int wait() {
    if (!ended_) ::waitpid(process_, &status_, 0);
    ended_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }
  bool exited() { return wait(), WIFEXITED(status_); }  ///< no signal ended it
  std::string said() const { return read_file(said_ / "err"); }

 private:
  bool has_ended() {
    if (!ended_ && ::waitpid(process_, &status_, WNOHANG) == process_) ended_ = true;
    return ended_;
  }

  TemporaryFolder said_;
  pid_t process_ = -1;
  int status_ = 0;
  bool ended_ = false;
};

}  // namespace rhoray::tests

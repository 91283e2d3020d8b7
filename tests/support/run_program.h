#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// Exit code and output of a program.
struct RunResult {
  int exit_code = -1;  ///< 128 + signal if a signal ended it
  std::string out;
  std::string err;
};

/// Runs a program (looked up in PATH) with these arguments in this folder, with empty standard
/// input, and waits for its end.
inline RunResult run_program(const std::vector<std::string>& words, const std::filesystem::path& folder = ".") {
  const TemporaryFolder caught;
  const std::filesystem::path out = caught / "out", err = caught / "err";
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    const auto put = [](const char* path, int flags, int descriptor) {
      return ::dup2(::open(path, flags, 0600), descriptor) >= 0;
    };
    const bool ready = put("/dev/null", O_RDONLY, 0) && put(out.c_str(), O_CREAT | O_WRONLY, 1) &&
                       put(err.c_str(), O_CREAT | O_WRONLY, 2) && ::chdir(folder.c_str()) == 0;
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    if (ready) ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
  }
  return {.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          .out = read_file(out),
          .err = read_file(err)};
}

}  // namespace rhoray::tests

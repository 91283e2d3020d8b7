#pragma once

#include <string>
#include <utility>
#include <vector>

namespace rhoray::tools {

/// A program to run.
struct ProgramRequest {
  std::vector<std::string> words;                ///< the program, looked up in PATH, and its arguments
  std::vector<std::string> environment{};        ///< "NAME=value", beside our own
  std::string folder{};                          ///< empty: ours
  std::vector<std::pair<int, int>> inherited{};  ///< a descriptor of ours, and its number in the program
};

struct ProgramRun {
  int status = 127;  ///< exit code; 127: not started; 128 + signal
  std::string out, err;
};

/// Runs a program with empty standard input and waits for its end. It has its own process group: an
/// interrupt from the terminal does not end it. Throws std::system_error without memory for its
/// output.
ProgramRun run_program(const ProgramRequest& request);

}  // namespace rhoray::tools
